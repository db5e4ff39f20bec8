"""The kernel `correction`: the changes of q and v that meet the constraints, least in a norm.

    d = W Φ_qᵀ (Φ_q W Φ_qᵀ)⁻¹ r,   r = -Φ, then -(Φ_q v + Φ_t)

As many constraints as coordinates leave no choice (`lower.linear.square_systems`). Otherwise it is
solved by the null space of Φ_q (`lower.linear.least_change_by_null_space`) or by eliminating
Φ_q W Φ_qᵀ, whichever costs less.
"""

from dataclasses import dataclass

from codegen.lower.constant_hoisting import with_constants
from codegen.lower.graph import Graph
from codegen.lower.linear.labels import Labels
from codegen.lower.linear.least_change_by_multipliers import NormalEquations, prefixed
from codegen.lower.linear.least_change_by_null_space import NullSpace
from codegen.lower.linear.square_systems import Square
from codegen.lower.operation_count import cost
from codegen.lower.program import STATE, Check, Kernel, store
from codegen.lower.scene_graph import SceneGraph

Entries = dict[tuple[int, int], int]  # (row, column) → value, structural non-zeros of Φ_q

Solution = tuple[list[list[int]], list[Check], Labels]
"""The unknowns, one list a right side, the pivots to watch, and names for the text."""


@dataclass(frozen=True)
class Task:
    """Φ_q d = r for several r, d least in the norm dᵀ W⁻¹ d."""

    graph: Graph
    jacobian: Entries  # Φ_q by (row, column)
    right: list[list[int]]  # one list of rows a right side
    weights: list[int]  # one a column
    names: list[str]  # of the coordinates
    rows: list[str]  # names of the constraints
    stems: list[str]  # how names of each right side begin
    unknowns: list[list[str]]  # names of each solution's entries


def correction(scene: SceneGraph) -> Kernel:
    """The kernel of a scene in all its coordinates."""
    names = [q.name for q in scene.equations.coordinates]
    return least_correction(
        scene.graph, scene.jacobian, scene.phi, scene.nu, scene.v, scene.w, names, scene.row_names()
    )


def least_correction(
    graph: Graph,
    jacobian: Entries,
    phi: list[int],
    nu: list[int],
    v: list[int],
    w: list[int],
    names: list[str],
    rows: list[str],
) -> Kernel:
    """The kernel for constraints, named `rows`, of a graph with or without its scene."""
    rates = [graph.neg(one) for one in nu]
    trials = []
    with graph.serving("correction"):
        for (i, k), entry in jacobian.items():
            rates[i] = graph.add(rates[i], graph.mul(entry, v[k]))
        right = [[graph.neg(one) for one in phi], [graph.neg(rate) for rate in rates]]
        stems, unknowns = ["rhs_q", "rhs_v"], prefixed(["dq", "dv"], names)
        task = Task(graph, jacobian, right, w, names, rows, stems, unknowns)
        for cancels in (True, False):
            with graph.cancelling(cancels):
                trials += [_kernel(names, solution) for solution in _solutions(task)]
    programs = (with_constants(graph, (kernel,), declared=0) for kernel in trials)
    costs = [cost(program, program.kernels[-1]) for program in programs]
    return trials[costs.index(min(costs))]


def _kernel(names: list[str], solution: Solution) -> Kernel:
    (dq, dv), checks, labels = solution
    return Kernel(
        "correction",
        "W Φ_qᵀ (Φ_q W Φ_qᵀ)⁻¹ times -Φ and -(Φ_q q̇ + Φ_t): w = 0 holds a coordinate.",
        (*STATE, "w", "dq", "dv"),
        store("dq", dq, names) + store("dv", dv, names),
        tuple(checks),
        watched=True,
        **labels.text,
    )


def least_changes(
    scene: SceneGraph, right: list[list[int]], stems: list[str], unknowns: list[list[str]]
) -> Solution:
    """Solutions d of Φ_q d = right, the least where the constraints leave a choice."""
    names = [q.name for q in scene.equations.coordinates]
    weights = [scene.graph.one] * scene.n
    rows = scene.row_names()
    task = Task(scene.graph, scene.jacobian, right, weights, names, rows, stems, unknowns)
    return _solutions(task)[0]


def _solutions(task: Task) -> list[Solution]:
    """The solutions to compare, the most accurate first."""
    graph, right = task.graph, task.right
    if len(right[0]) == len(task.weights) > 0:
        labels = Labels(task.rows, prefixed(task.stems, task.rows), task.unknowns)
        square = Square(graph, task.jacobian, right, labels, task.names)
        solutions = square.solve()
        if solutions is not None:
            return [(solutions, square.checks, labels)]
    candidates: list[Solution] = []
    labels = Labels(task.names, prefixed(task.stems, task.rows), task.unknowns)
    weights, rows = task.weights, task.rows
    space = NullSpace(graph, task.jacobian, right, labels, weights=weights, rows=rows)
    changes = space.solve()
    if changes is not None:
        candidates.append((changes, space.checks, labels))
    normal = NormalEquations(
        graph, task.jacobian, right, weights=weights, rows=rows, stems=task.stems
    )
    return [*candidates, (normal.solve(), normal.checks, normal.text)]
