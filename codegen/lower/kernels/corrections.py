"""The kernel `correction`: the changes of q and v that meet the constraints, least in a norm.

    d = W Φ_qᵀ (Φ_q W Φ_qᵀ)⁻¹ r,   r = -Φ, then -(Φ_q v + Φ_t)

As many constraints as coordinates leave no choice (`lower.linear.square_systems`). Otherwise it is
solved by the null space of Φ_q (`lower.linear.null_space`) or by eliminating Φ_q W Φ_qᵀ, whichever
costs less.
"""

from dataclasses import dataclass
from itertools import combinations_with_replacement

from codegen.lower.constant_hoisting import with_constants
from codegen.lower.graph import Graph
from codegen.lower.linear.factorization import Elimination
from codegen.lower.linear.labels import Labels
from codegen.lower.linear.null_space import NullSpace
from codegen.lower.linear.square_systems import Square
from codegen.lower.operation_count import cost
from codegen.lower.program import STATE, Check, Kernel, store
from codegen.lower.scene_graph import SceneGraph

Entries = dict[tuple[int, int], int]
"""(row, column) → value, structural non-zeros of Φ_q."""

Solution = tuple[list[list[int]], tuple[Check, ...], Labels]
"""The unknowns, one list a right side, the pivots to watch, and names for the text."""


@dataclass(frozen=True)
class Task:
    """Φ_q d = r for several r, d least in the norm dᵀ W⁻¹ d.

    Attributes
    ----------
    jacobian, right, weights
        Φ_q by (row, column), one list of rows a right side, one weight a column.
    names, rows
        Of the coordinates and of the constraints.
    stems, unknowns
        How names of each right side begin, and names of its solution's entries.
    """

    graph: Graph
    jacobian: Entries
    right: list[list[int]]
    weights: list[int]
    names: list[str]
    rows: list[str]
    stems: list[str]
    unknowns: list[list[str]]

    def labels(self, unknowns: list[list[str]], matrix: str = "M") -> Labels:
        """Names of the constraints' values."""
        return Labels(self.rows, stemmed(self.stems, self.rows), unknowns, matrix)


def stemmed(stems: list[str], names: list[str]) -> list[list[str]]:
    """Each name with each stem before it."""
    return [[f"{stem}_{name}" for name in names] for stem in stems]


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
        stems, unknowns = ["rhs_q", "rhs_v"], stemmed(["dq", "dv"], names)
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
        checks,
        watched=True,
        labels=tuple(labels.by_value.values()),
        steps=tuple(labels.steps),
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
        labels = task.labels(task.unknowns)
        square = Square(graph, task.jacobian, right, labels, task.names)
        solutions = square.solve()
        if solutions is not None:
            return [(solutions, tuple(square.checks), labels)]
    candidates = []
    labels = Labels(task.names, stemmed(task.stems, task.rows), task.unknowns)
    space = NullSpace(graph, task.jacobian, right, task.weights, labels, task.rows)
    changes = space.solve()
    if changes is not None:
        candidates.append((changes, tuple(space.checks), labels))
    return [*candidates, _by_multipliers(task)]


def _by_multipliers(task: Task) -> Solution:
    """d = W Φ_qᵀ μ with Φ_q W Φ_qᵀ μ = r, after coordinates that one constraint determines."""
    graph, weights = task.graph, task.weights
    rows: dict[int, dict[int, int]] = {i: {} for i in range(len(task.right[0]))}
    for (i, k), entry in sorted(task.jacobian.items()):
        rows[i][k] = entry
    right = [list(column) for column in task.right]
    solutions = [[graph.zero] * len(weights) for _ in right]
    checks = _give_determined(graph, rows, right, weights, solutions)
    left = list(rows)
    names = [task.rows[i] for i in left]
    multipliers = stemmed([stem.replace("rhs", "mu") for stem in task.stems], names)
    labels = Labels(names, stemmed(task.stems, names), multipliers, "S")
    labels.step("The matrix and the right sides")
    entries: Entries = {}
    for a, b in combinations_with_replacement(range(len(left)), 2):
        one, other = rows[left[a]], rows[left[b]]
        terms = [
            graph.mul(graph.mul(x, weights[k]), other[k]) for k, x in one.items() if k in other
        ]
        if terms or a == b:
            entries[a, b] = entries[b, a] = graph.total(terms)
            labels.entry(entries[a, b], a, b)
    references = {a: entries[a, a] for a in range(len(left))}
    sides = [[column[i] for i in left] for column in right]
    for a in range(len(left)):
        labels.sides(sides, a)
    system = Elimination(graph, entries, sides, references=references, labels=labels)
    solved = system.solve("schur")
    labels.step("W Φ_qᵀ μ")
    for d, column in zip(solutions, solved, strict=True):
        sums: dict[int, int] = {}
        for i, mu in zip(left, column, strict=True):
            for k, entry in rows[i].items():
                sums[k] = graph.add(sums.get(k, graph.zero), graph.mul(entry, mu))
        for k, pull in sums.items():
            d[k] = graph.mul(weights[k], pull)
    checks += [check._replace(constraint=left[check.constraint]) for check in system.checks]
    return solutions, tuple(checks), labels


def _give_determined(
    graph: Graph,
    rows: dict[int, dict[int, int]],
    right: list[list[int]],
    weights: list[int],
    solutions: list[list[int]],
) -> list[Check]:
    """Solve rows with one unknown and a constant coefficient; the weights do not matter there."""
    checks: list[Check] = []
    while True:
        numbers = {i: [graph.number(x) for x in row.values()] for i, row in rows.items()}
        alone = [
            i
            for i, coefficients in numbers.items()
            if len(coefficients) == 1 and coefficients[0] is not None
        ]
        if not alone:
            return checks
        i = alone[0]
        ((k, number),) = rows.pop(i).items()
        checks.append(Check(weights[k], graph.zero, i))
        for column, d in zip(right, solutions, strict=True):
            d[k] = graph.div(column[i], number)
            for other, row in rows.items():
                if k in row:
                    column[other] = graph.sub(column[other], graph.mul(row[k], d[k]))
        for row in rows.values():
            row.pop(k, None)
