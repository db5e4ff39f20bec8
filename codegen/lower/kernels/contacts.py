"""Kernels of what holds on to its surface: frictions that stick, and rigid contacts."""

import sys

from codegen.lower.kernels.selection import Selection
from codegen.lower.program import Kernel, Op, Output, store
from codegen.lower.scene_graph import SceneGraph

UNBOUNDED = sys.float_info.max
"""Stands for an infinite bound, which is no literal of a generated text."""


def hold_kernels(scene: SceneGraph, selection: Selection) -> list[Kernel]:
    """Those that the scene needs."""
    kernels = []
    if any(s.kind == "contact" or s.ratio is not None for s in scene.equations.switches):
        kernels.append(_holds(scene))
    if scene.equations.contacts:
        kernels += _contacts(scene)
    reported = [k for k, (name, *_) in enumerate(scene.reactions) if selection.reaction(name)]
    switched = switched_reactions(scene)
    outputs = tuple(
        Output("out", row, scene.reactions[k][3], reaction_note(scene, k))
        for row, k in enumerate(reported)
        if k in switched
    )
    if outputs:
        kernels.append(
            Kernel(
                "switched_reactions",
                "The rows of REACTIONS that a mode decides; `reactions` fills the others.",
                ("t", "q", "v", "p", "modes", "lam", "out"),
                outputs,
            )
        )
    return kernels


def switched_reactions(scene: SceneGraph) -> list[int]:
    """Rows of REACTIONS whose values depend on a mode."""
    values = scene.graph.values
    switched: dict[int, bool] = {}

    def depends(number: int) -> bool:
        stack = [number]
        while stack:
            top = stack[-1]
            unknown = [a for a in values[top].args if a not in switched]
            if top not in switched and unknown:
                stack += unknown
                continue
            stack.pop()
            switched[top] = values[top].op is Op.MODE or any(switched[a] for a in values[top].args)
        return switched[number]

    return [k for k, (*_, value) in enumerate(scene.reactions) if depends(value)]


def reaction_note(scene: SceneGraph, k: int) -> str:
    """What stands in a row of REACTIONS."""
    element, part, unit, _ = scene.reactions[k]
    return f"{element} {part}, {unit}" if unit else f"{element} {part}"


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
    return [
        Kernel(
            "gap_accelerations",
            "d²g/dt² of the gaps of the rigid contacts, in the order of RIGID.",
            ("t", "q", "v", "a", "p", "out"),
            store("out", gaps, names),
        ),
        Kernel(
            "restitution",
            "e of ġ⁺ = -e ġ⁻, of the rigid contacts.",
            ("p", "out"),
            store("out", restitution, names),
        ),
        Kernel(
            "contact_scale",
            "F0, N: the reaction that a rigid contact exerts in mode 0, before it is scaled.",
            ("p", "out"),
            store("out", scales, names),
        ),
    ]
