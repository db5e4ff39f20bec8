"""Kernels that return scalars of a scene: samples, conditions on parameters, set-valued forces.

The samples of the values that clocks renew, and the clocks.

Kernels of what a scene asks of its parameters: the numbers that are judged before each run.

Kernels of sticking frictions, rigid contacts and freewheels: bounds of α, gaps, restitution.
"""

import sys
from collections.abc import Sequence

import sympy

from codegen.lower.program import STATE, Kernel, Op, Output, dependencies, store, storing
from codegen.lower.scene_graph import Reaction, SceneGraph
from codegen.lower.sympy_translation import Translator
from codegen.readers.calls import errors_at

NEW, KEPT = sympy.symbols("new kept", cls=sympy.Dummy, real=True)


def sampling_kernels(scene: SceneGraph) -> list[Kernel]:
    """The kernels `samples` and `clocks`, of scenes that have sampled values.

    `samples` takes in `modes` which of them are due, 1 or 0. A value is computed from those that
    are due at the same instant and stand before it, unless these have a delay; the kernel asks
    whether one that is a parameter is 0. Conditions are compared, since nothing is integrated
    across a sample.
    """
    graph, states = scene.graph, scene.equations.sampled
    if not states:
        return []
    translate = Translator(graph, scene.translate.environment, None)
    values, clocks = list[int](), list[int]()
    for k, state in enumerate(states):
        with graph.serving(state.name), errors_at(f"sampled value '{state.name}'"):
            value = now = scene.translate.environment[state.symbol]
            if state.sample is not None:
                value = graph.select(graph.mode(k), translate(state.sample), now)
            clocks += [scene.translate(state.every), scene.translate(state.delay)]
        values.append(value)
        if not state.delay.is_number:  # a parameter, which may be 0
            acts = sympy.Piecewise((NEW, state.delay <= 0), (KEPT, True))
            value = translate.scoped({NEW: value, KEPT: now})(acts)
        if not state.delay.is_number or state.delay == 0:
            translate = translate.scoped({state.symbol: value})
    names = [state.name for state in states]
    summary = "Samples of SAMPLED; those that are not due, modes 0, keep their values."
    times = [f"{name}: {word}, s" for name in names for word in ("period", "delay")]
    return [
        storing("samples", summary, "t q v p modes out", values, names),
        storing("clocks", "Period and delay of each of SAMPLED.", "p out", clocks, times),
    ]


def watching_kernels(scene: SceneGraph) -> list[Kernel]:
    """The kernel `watched`, of scenes with conditions that a run watches: 1 where one holds."""
    values, names = list[int](), list[str]()
    for effect in scene.equations.effects:
        if effect.terms.watched is not None:
            with scene.graph.serving(effect.name), errors_at(f"condition '{effect.name}'"):
                values.append(scene.translate(effect.terms.watched))
            names.append(effect.name)
    if not values:
        return []
    summary = "1 where a condition of WATCHED holds, else 0."
    return [storing("watched", summary, "t q v p modes out", values, names)]


NAME = "conditions"


def condition_kernels(scene: SceneGraph) -> list[Kernel]:
    """The kernels `conditions` and `profiles`, of scenes that have any."""
    kernels, equations = [], scene.equations
    if equations.conditions:
        values, notes = list[int](), list[str]()
        for one in equations.conditions:
            numbers = one.condition.numbers
            with errors_at(one.element):
                values += [_translated(scene, number) for number in numbers]
            notes += [one.element] * len(numbers)
        summary = "Numbers that CONDITIONS bound and show, in their order."
        kernels.append(storing(NAME, summary, "p out", values, notes))
    if equations.profiles:
        values = []
        for curve in equations.profiles:
            with errors_at(curve.row.element):
                values += [_translated(scene, e) for e in curve.derivatives]
        notes = [curve.row.element for curve in equations.profiles for _ in curve.derivatives]
        summary = "x, y and their first and second derivatives by α, which t stands for: PROFILES."
        kernels.append(storing("profiles", summary, "t p out", values, notes))
    return kernels


def _translated(scene: SceneGraph, expression: sympy.Expr) -> int:
    """The value of an expression whose sizes and larger ones are taken of parameters alone."""
    graph = scene.graph
    plain = expression.replace(sympy.Max, _larger)
    plain = plain.replace(sympy.Min, lambda *terms: -_larger(*(-term for term in terms)))
    translate, known = scene.translate, dict[sympy.Expr, int]()
    for size in sorted(plain.atoms(sympy.Abs), key=lambda e: (e.count_ops(), str(e))):
        inside = (translate.scoped(known) if known else translate)(size.args[0])
        known[size] = graph.power(graph.mul(inside, inside), 0.5)
    return (translate.scoped(known) if known else translate)(plain)


def _larger(*terms: sympy.Expr) -> sympy.Expr:
    first, *rest = terms
    other = _larger(*rest) if len(rest) > 1 else rest[0]
    return (first + other + sympy.Abs(first - other)) / 2


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
