"""The kernel `correction`: the changes of q and v that meet the constraints, least in a norm.

    d = W Φ_qᵀ (Φ_q W Φ_qᵀ)⁻¹ r,   r = -Φ, then -(Φ_q v + Φ_t)

As many constraints as coordinates leave no choice (`lower.linear.square_systems`). Otherwise it is
solved by the null space of Φ_q (`lower.linear.least_change_by_null_space`) or by eliminating
Φ_q W Φ_qᵀ, whichever costs less.
"""

from codegen.lower.graph import Graph
from codegen.lower.linear.factorization import Entries
from codegen.lower.linear.least_change import NormalEquations, NullSpace
from codegen.lower.linear.sparse_row_elimination import (
    SparseRows,
    Task,
    is_large,
    prefixed,
    structure_of,
)
from codegen.lower.linear.square_systems import Square
from codegen.lower.operation_count import cheapest
from codegen.lower.program import Kernel, store
from codegen.lower.scene_graph import SceneGraph

Solution = tuple[list[list[int]], SparseRows]
"""The unknowns, one list a right side, and the solver, with its pivots and names."""


def correction(scene: SceneGraph) -> Kernel:
    """The kernel of a scene in all its coordinates."""
    equations = scene.graph, scene.jacobian, scene.phi, scene.nu
    return least_correction(*equations, scene.v, scene.w, scene.names, scene.rows)


def least_correction(
    graph: Graph, jacobian: Entries, phi: list[int], nu: list[int], v: list[int], w: list[int],
    names: list[str], rows: list[str],
) -> Kernel:  # fmt: skip
    """The kernel for constraints, named `rows`, of a graph with or without its scene."""
    rates = [graph.neg(one) for one in nu]
    trials = []
    with graph.serving("correction"):
        for (i, k), entry in jacobian.items():
            rates[i] = graph.add(rates[i], graph.mul(entry, v[k]))
        right = [[graph.neg(one) for one in phi], [graph.neg(rate) for rate in rates]]
        stems, unknowns = ["rhs_q", "rhs_v"], prefixed(["dq", "dv"], names)
        task = Task(graph, jacobian, right, w, names, rows, stems, unknowns)
        # Where the coordinates and rows are many, it is not worth building everything twice.
        for cancels in (True,) if is_large(task) else (True, False):
            with graph.cancelling(cancels):
                trials += [_kernel(names, *solution) for solution in solutions(task)]
    return cheapest(graph, trials)


def _kernel(names: list[str], changes: list[list[int]], solver: SparseRows) -> Kernel:
    dq, dv = changes
    outputs = store("dq", dq, names) + store("dv", dv, names)
    summary = "W Φ_qᵀ (Φ_q W Φ_qᵀ)⁻¹ times -Φ and -(Φ_q q̇ + Φ_t): w = 0 holds a coordinate."
    return solver.labels.kernel("correction", summary, "t q v p w dq dv", outputs, solver.checks)


def solutions(task: Task) -> list[Solution]:
    """The solutions to compare, the most accurate first; the least where there is a choice."""
    if len(task.right[0]) == len(task.weights) > 0:
        square = Square(task)
        if (unknowns := square.solve()) is not None:
            return [(unknowns, square)]
    solvers: list[NullSpace | NormalEquations] = [NormalEquations(task)]
    if not is_large(task) or NullSpace(structure_of(task)).solve() is not None:
        solvers.insert(0, NullSpace(task))
    return [(changes, one) for one in solvers if (changes := one.solve()) is not None]
