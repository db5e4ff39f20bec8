"""Friction from reactions: accelerations and multipliers consistent with the friction they cause.

Without friction the solution is x₀; a unit force of friction j adds x_j. With the force -g_j S_j,
S_j the sum of the sizes of its loads, every load is linear in the solution, and the sums obey

    S_i = Σ |c + e_i S_i|,   c = load(x₀) - Σ_{j≠i} g_j S_j load(x_j),   e_i = -g_i load(x_i).

The right side is convex, so Newton's steps from 0 rise to the smallest solution: at once where one
load keeps its sign, in a step more for each sign that changes. Several frictions take a step each
in turn, a fixed number of times, so that the kernel stays one straight line.

A friction that sticks has no such equation: its force is an input, which the run determines so
that the slip stays zero. Whether sliding would jam does not matter then. The force stands in the
place of -g_j S_j.

The kernel checks the solution. Where the slope 1 - d/dS Σ|c + e S| is not positive no friction
balances the loads that it causes: the joint jams, and the result is nan. A remainder means that
the steps did not suffice; it is reported with the joint's name.
"""

from codegen.lower.program import Check
from codegen.lower.scene_graph import SceneGraph

ALONE, SWEEPS = 6, 12  # steps for a single friction; sweeps over several
AGREED = 1e-7  # accuracy: accepted remainder of the equation of the loads, in parts of the loads
TINY = 1e-300  # safety: added to squares under a root, so that a load of zero has the size zero

Loads = list[list[tuple[int, list[int]]]]
"""A contact → its entries → (value without friction, change for a unit of each friction)."""


def with_friction(scene: SceneGraph, solutions: list[list[int]]) -> tuple[list[int], list[Check]]:
    """The solution with its friction, from the one without and those of unit forces."""
    graph, n = scene.graph, scene.n
    base, *units = solutions
    if not scene.frictions:
        return base, []
    coefficients = [f.choice(graph, f.stiction, graph.neg(f.coefficient)) for f in scene.frictions]
    changes = [
        [graph.mul(coefficient, x) for x in unit[n:]]
        for coefficient, unit in zip(coefficients, units, strict=True)
    ]

    def pressed(entry: dict[int, int]) -> tuple[int, list[int]]:
        return scene.along(entry, base[n:]), [scene.along(entry, change) for change in changes]

    loads = [[[pressed(e) for e in contact] for contact in f.loads] for f in scene.frictions]
    sums = [graph.zero] * len(loads)
    alone = len(loads) == 1
    if not alone:
        sums = [friction.choice(graph, graph.one, graph.zero) for friction in scene.frictions]
    for _ in range(ALONE if alone else SWEEPS):
        for i, (friction, contacts) in enumerate(zip(scene.frictions, loads, strict=True)):
            rest, slope = _remainder(scene, contacts, sums, i)
            sums[i] = graph.sub(sums[i], graph.div(rest, slope))
            if not alone:
                sums[i] = friction.choice(graph, graph.one, sums[i])
    checks: list[Check] = []
    for i, (friction, contacts) in enumerate(zip(scene.frictions, loads, strict=True)):
        row = min(row for load in friction.loads for entry in load for row in entry)
        rest, slope = _remainder(scene, contacts, sums, i)
        allowed = graph.mul(graph.constant(AGREED), graph.add(sums[i], graph.constant(TINY)))
        checks.append(Check(friction.choice(graph, graph.one, slope), graph.one, row))
        root = graph.power(slope, 0.5)  # nan where the joint jams: no number there means anything
        total = graph.div(graph.mul(sums[i], graph.mul(root, root)), slope)
        sums[i] = friction.choice(graph, graph.one, total)
        left = graph.sub(allowed, scene.size([rest]))
        checks.append(Check(friction.choice(graph, graph.one, left), graph.zero, row))
    result = list(base)
    for total, coefficient, unit in zip(sums, coefficients, units, strict=True):
        force = graph.mul(coefficient, total)
        result = [graph.add(x, graph.mul(force, y)) for x, y in zip(result, unit, strict=True)]
    return result, checks


def _remainder(scene: SceneGraph, contacts: Loads, sums: list[int], i: int) -> tuple[int, int]:
    """S_i - Σ |c + e S|, and its derivative by S_i."""
    graph = scene.graph
    rest, slope = sums[i], graph.one
    for load in contacts:
        pressed, pull = [], graph.zero
        for free, changes in load:
            terms = [graph.mul(e, s) for e, s in zip(changes, sums, strict=True)]
            pressed.append(graph.total([free, *terms]))
            pull = graph.add(pull, graph.mul(pressed[-1], changes[i]))
        squares = [graph.mul(x, x) for x in pressed]
        size = graph.power(graph.total([graph.constant(TINY), *squares]), 0.5)
        rest = graph.sub(rest, size)
        slope = graph.sub(slope, graph.div(pull, size))
    return rest, slope
