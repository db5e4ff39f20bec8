"""Kernels of sticking frictions, rigid contacts and freewheels: bounds of α, gaps, restitution."""

import sys
from collections.abc import Sequence

from codegen.lower.program import STATE, Kernel, Op, Output, dependencies, store, storing
from codegen.lower.scene_graph import Reaction, SceneGraph

UNBOUNDED = sys.float_info.max  # an infinite bound, which is no literal of a generated text

CONTACT_KERNELS = (
    (
        "gap_accelerations",
        "d²g/dt² of the gaps of the rigid contacts, in the order of RIGID.",
        "t q v a p out",
    ),
    ("restitution", "e of ġ⁺ = -e ġ⁻, of the rigid contacts.", "p out"),
    (
        "contact_scale",
        "F0, N: the reaction that a rigid contact exerts in mode 0, before it is scaled.",
        "p out",
    ),
)


def hold_kernels(scene: SceneGraph, reported: Sequence[Reaction]) -> list[Kernel]:
    """The kernels of sticking frictions, rigid contacts and freewheels that a scene needs."""
    kernels, contacts = [], scene.equations.contacts
    if any(s.alone or s.ratio is not None for s in scene.equations.switches):
        kernels.append(_holds(scene))
    if contacts:
        columns = zip(
            *(scene.credited(c.effect, c.acceleration, c.restitution, c.scale) for c in contacts),
            strict=True,
        )
        names = [contact.effect for contact in contacts]
        for row, values in zip(CONTACT_KERNELS, columns, strict=True):
            kernels.append(storing(*row, values, names))
    if outputs := reaction_outputs(scene, reported, switched=True):
        summary = "The rows of REACTIONS that a mode decides; `reactions` fills the others."
        arguments = (*STATE, "modes", "lam", "out")
        kernels.append(Kernel("switched_reactions", summary, arguments, outputs))
    return kernels


def reaction_outputs(
    scene: SceneGraph, reported: Sequence[Reaction], switched: bool
) -> tuple[Output, ...]:
    """The reported rows of REACTIONS whose values depend on a mode, or on none."""
    values, outputs = scene.graph.values, []
    for row, (element, part, unit, value, _) in enumerate(reported):
        depends = (values[k].op is Op.MODE for k in dependencies(scene.graph.values, [value]))
        if any(depends) is switched:
            note = f"{element} {part}, {unit}" if unit else f"{element} {part}"
            outputs.append(Output("out", row, value, note))
    return tuple(outputs)


def _holds(scene: SceneGraph) -> Kernel:
    graph = scene.graph
    low, high, notes = [], [], []
    for switch in scene.equations.switches:
        notes.append(f"{switch.effect}: {switch.kind}")
        first, last = graph.zero, graph.one
        if switch.alone:
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
