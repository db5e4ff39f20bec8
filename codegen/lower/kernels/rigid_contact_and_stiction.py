"""Kernels of sticking frictions and rigid contacts: bounds of α, gaps, restitution."""

import sys

from codegen.lower.program import STATE, Kernel, Op, Output, store, storing
from codegen.lower.scene_graph import SceneGraph
from codegen.lower.substitution import dependencies

UNBOUNDED = sys.float_info.max  # an infinite bound, which is no literal of a generated text


def hold_kernels(scene: SceneGraph, reported: tuple[int, ...]) -> list[Kernel]:
    """The kernels of sticking frictions and rigid contacts that a scene needs."""
    kernels = []
    if any(s.kind == "contact" or s.ratio is not None for s in scene.equations.switches):
        kernels.append(_holds(scene))
    if scene.equations.contacts:
        kernels += _contacts(scene)
    if outputs := reaction_outputs(scene, reported, switched=True):
        summary = "The rows of REACTIONS that a mode decides; `reactions` fills the others."
        arguments = (*STATE, "modes", "lam", "out")
        kernels.append(Kernel("switched_reactions", summary, arguments, outputs))
    return kernels


def reaction_outputs(
    scene: SceneGraph, reported: tuple[int, ...], switched: bool
) -> tuple[Output, ...]:
    """The reported rows of REACTIONS whose values depend on a mode, or on none."""
    values = scene.graph.values
    depends: dict[int, bool] = {}
    for number in sorted(dependencies(scene.graph, [scene.reactions[k][3] for k in reported])):
        operation = values[number]
        depends[number] = operation.op is Op.MODE or any(depends[a] for a in operation.args)
    outputs = []
    for row, k in enumerate(reported):
        element, part, unit, value = scene.reactions[k]
        if depends[value] is switched:
            note = f"{element} {part}, {unit}" if unit else f"{element} {part}"
            outputs.append(Output("out", row, value, note))
    return tuple(outputs)


def _holds(scene: SceneGraph) -> Kernel:
    graph = scene.graph
    low, high, notes = [], [], []
    for switch in scene.equations.switches:
        notes.append(f"{switch.effect}: {switch.kind}")
        first, last = graph.zero, graph.one
        if switch.kind == "contact":
            first = graph.constant(-UNBOUNDED)
        elif switch.ratio is not None:
            half = graph.constant(0.5)
            with graph.serving(switch.effect):
                reach = graph.mul(half, scene.translate(switch.ratio))
                first, last = graph.sub(half, reach), graph.add(half, reach)
        low.append(first)
        high.append(last)
    return Kernel(
        "holds",
        "Bounds of α with which q̈ = q̈₀ + α (q̈₁ - q̈₀), of modes 0 and 1, may hold g at 0.",
        ("p", "low", "high"),
        store("low", low, notes) + store("high", high, notes),
    )


def _contacts(scene: SceneGraph) -> list[Kernel]:
    gaps, restitution, scales, names = [], [], [], []
    for contact in scene.equations.contacts:
        with scene.graph.serving(contact.effect):
            gaps.append(scene.translate(contact.acceleration))
            restitution.append(scene.translate(contact.restitution))
            scales.append(scene.translate(contact.scale))
        names.append(contact.effect)
    rows = (
        (
            "gap_accelerations",
            "d²g/dt² of the gaps of the rigid contacts, in the order of RIGID.",
            "t q v a p out",
            gaps,
        ),
        ("restitution", "e of ġ⁺ = -e ġ⁻, of the rigid contacts.", "p out", restitution),
        (
            "contact_scale",
            "F0, N: the reaction that a rigid contact exerts in mode 0, before it is scaled.",
            "p out",
            scales,
        ),
    )
    return [storing(*row, names) for row in rows]
