"""The order of elimination of a scene's equations of motion, chosen before values are built."""

import math

from codegen.lower.linear.factorization import Elimination, Entries, Strategy, augmented
from codegen.lower.linear.labels import Labels
from codegen.lower.linear.structural_cost import LARGE, CostExceededError, Structure
from codegen.lower.scene_graph import SceneGraph

CLOSE = 1.1  # measured: costs by structure this near to the least are equal, shared values unknown

ORDERS: tuple[Strategy, ...] = ("substitute", "mixed", "schur")
"""The orders of a small system that are compared; of equal ones the first is taken."""

ORDERS_OF_LARGE: tuple[Strategy, ...] = (*ORDERS, "leaves")
SUBSTITUTING: tuple[Strategy, ...] = ("substitute", "leaves")
"""The orders that divide by no mass before a constraint determines its coordinate."""

FILLS: tuple[Strategy, ...] = ("mixed", "leaves", "schur", "substitute")
"""From the least fill to the most, in any machine: the first ones limit the cost of the others."""


def is_large(scene: SceneGraph) -> bool:
    """Whether a scene has so many unknowns that its order is chosen by structure."""
    return scene.n + scene.m >= LARGE


def elimination(
    scene: SceneGraph, labels: Labels, structure: Structure | None = None
) -> Elimination:
    """The system [M Φ_qᵀ; Φ_q 0], with a right side for the forces and for each friction.

    In a `structure` its values are kinds of values.
    """
    n, graph = scene.n, structure or scene.graph
    mass, jacobian = (_kinds(scene, e, structure) for e in (scene.mass, scene.jacobian))
    entries, references = augmented(graph, mass, jacobian, n)
    for i, size in references.items():
        labels.name(size, "size", i)
    right, duals = [scene.forces + scene.gamma], frozenset(range(n, n + scene.m))
    for friction in scene.frictions:  # a unit force of it
        push = [friction.direction.get(k, scene.graph.zero) for k in range(n)]
        right.append([*push, *[scene.graph.zero] * scene.m])
    if structure:
        right = [structure.kinds(scene.graph, column) for column in right]
    lengths = {k for k, q in enumerate(scene.equations.coordinates) if q.unit == "m"}
    with_lengths = {i for i, k in scene.jacobian if k in lengths}
    located = [(k, n + i, i not in with_lengths) for i, k in scene.massless]
    owners = [*(q.owner for q in scene.equations.coordinates), *scene.owners]
    return Elimination(graph, entries, right, duals, references, located, labels, owners)


def _kinds(scene: SceneGraph, entries: Entries, structure: Structure | None) -> Entries:
    if structure is None:
        return entries
    return {place: structure.kind(scene.graph, value) for place, value in entries.items()}


def cheapest_by_structure(
    scene: SceneGraph, orders: tuple[Strategy, ...] = ORDERS_OF_LARGE
) -> Strategy:
    """The first of the orders that cost least, by the structure of the equations of motion."""
    costs, least = dict[Strategy, float](), math.inf
    for strategy in sorted(orders, key=FILLS.index):
        structure = Structure(CLOSE * least)
        try:
            elimination(scene, Labels(), structure).solve(strategy)
        except CostExceededError:
            continue
        costs[strategy] = structure.cost
        least = min(costs.values())
    return next(s for s in orders if costs.get(s, math.inf) <= CLOSE * least)
