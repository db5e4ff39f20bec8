"""The kernel `correction`: the changes of q and v that meet the constraints, least in a norm.

    d = W Φ_qᵀ (Φ_q W Φ_qᵀ)⁻¹ r,   r = -Φ, then -(Φ_q v + Φ_t)

As many constraints as coordinates leave no choice. Otherwise it is
solved by the null space of Φ_q (`lower.linear.least_change_by_null_space`) or by eliminating
Φ_q W Φ_qᵀ, whichever costs less.

The linear systems of a driven machine: as many independent constraints as coordinates.

Φ_q x = r has one solution, whatever the norm. Many constraints determine a coordinate
by a number in Φ_q: these are eliminated first, and the factorization shrinks to the loops, of which
few are left. There the smallest sets of rows with as many unknowns are solved one after the other,
up to three rows by their adjugate, larger ones by the normal equations of what is left. Where the
determinant of such a set vanishes the machine is in a singular position: det² is held against the
product of the rows' squares, as the pivots of Φ_q Φ_qᵀ are against its diagonal.
"""

from collections.abc import Sequence
from dataclasses import replace

from codegen.lower.graph import Graph
from codegen.lower.kernels.turning_correction import changes_by_turns
from codegen.lower.linear.factorization import Entries
from codegen.lower.linear.least_change import NormalEquations, NullSpace, solve_by_multipliers
from codegen.lower.linear.sparse_row_elimination import (
    SparseRows,
    Task,
    is_large,
    prefixed,
    structure_of,
)
from codegen.lower.operation_count import cheapest
from codegen.lower.program import Check, Kernel, Labels, store
from codegen.lower.scene_graph import SceneGraph

LARGEST = 3  # measured: rows of the largest set that is solved by its adjugate
SHARPER = 1e-6  # accuracy: part of the product of the rows' squares that det² is compared with


class Square(SparseRows):
    """As many rows as unknowns."""

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self.labels = task.labels(task.rows)

    def solve(self) -> list[list[int]] | None:
        """The unknowns, one list a right side; None where no position determines them all."""
        while pivot := self._explicit_coordinate():
            self._substitute(*pivot)
        x: list[dict[int, int]] = [{} for _ in self.right]
        while self._rows:
            chosen = self._smallest_set(LARGEST, range(-LARGEST, 1)) or tuple(self._rows)
            if len(self._unknowns_of(chosen)) != len(chosen):
                return None
            self._solve_set(chosen, x)
        self.labels.step("Substitute back")
        for k, row, right in reversed(self._eliminated):
            for known, value in zip(x, right, strict=True):
                if k not in known:
                    known[k] = self.graph.less(value, row, known)
        solutions = [[known[k] for k in range(len(known))] for known in x]
        self.labels.solved(solutions)
        return solutions

    # -- coordinates that one constraint determines ------------------------------------------

    def _substitute(self, i: int, k: int) -> None:
        graph = self.graph
        row = self._remove(i)
        pivot = row.pop(k)
        inverse = graph.div(graph.one, pivot)
        self._step([i], [k])
        self.labels.pivot(pivot, inverse, i)
        coefficients = {j: graph.mul(inverse, entry) for j, entry in row.items()}
        for j, entry in coefficients.items():
            self._name(entry, "L", i, j)
        self._eliminate(k, coefficients, [graph.mul(inverse, column[i]) for column in self.right])

    def _step(self, rows: Sequence[int], columns: Sequence[int]) -> None:
        if self.task.columns:
            unknowns = ", ".join(self.task.columns[k] for k in columns)
            self.labels.step(f"Solve {self.labels.titles(*rows)} for {unknowns}")

    def _name(self, value: int, stem: str, row: int, column: int) -> None:
        if self.task.columns:
            self.labels.add(value, f"{self.labels.of(stem, row)}_{self.task.columns[column]}")

    # -- loops -------------------------------------------------------------------------------

    def _solve_set(self, chosen: tuple[int, ...], x: list[dict[int, int]]) -> None:
        """Solve the rows for their unknowns, and take these out of the other rows."""
        columns = self._unknowns_of(chosen)
        self._step(chosen, columns)
        matrix = self._take(chosen, columns)
        right = [[column[i] for i in chosen] for column in self.right]
        if len(chosen) <= LARGEST:
            solutions = self._by_adjugate(chosen, matrix, right)
        else:
            solutions = self._by_normal_equations(chosen, matrix, right)
        for names, values in zip(self.labels.solution, solutions, strict=False):
            for k, value in zip(columns, values, strict=True):
                self.labels.add(value, names[k])
        for known, found in zip(x, solutions, strict=True):
            known |= dict(zip(columns, found, strict=True))
        for k in columns:
            self._eliminate(k, {}, [known[k] for known in x])

    def _by_adjugate(
        self, chosen: tuple[int, ...], a: list[list[int]], right: list[list[int]]
    ) -> list[list[int]]:
        graph, size = self.graph, len(chosen)
        minors = [[self._cofactor(a, i, k) for k in range(size)] for i in range(size)]
        det = graph.dot(a[0], minors[0])
        if graph.number(det) is None:
            reference = graph.one
            for i in chosen:
                entries = self._original[i].values()
                reference = graph.mul(reference, graph.dot(entries, entries))
            # Nothing has been squared to find det, so that it may be smaller than a pivot of
            # Φ_q Φ_qᵀ; and short arms make it so where nothing is singular.
            square = graph.mul(det, det)
            self.checks.append(Check(square, reference, max(chosen), SHARPER))
            self.labels.name(square, "det2", *chosen)
            self.labels.name(reference, "size", *chosen)
        inverse = graph.div(graph.one, det)
        self.labels.name(det, "det", *chosen)
        self.labels.name(inverse, "inverse_det", *chosen)
        columns = list(zip(*minors, strict=True))
        return [[graph.mul(inverse, graph.dot(minor, r)) for minor in columns] for r in right]

    def _cofactor(self, a: list[list[int]], i: int, k: int) -> int:
        graph = self.graph
        rest = [[x for j, x in enumerate(row) if j != k] for n, row in enumerate(a) if n != i]
        if not rest:
            return graph.one
        if len(rest) == 1:
            minor = rest[0][0]
        else:
            (p, q), (r, s) = rest
            minor = graph.sub(graph.mul(p, s), graph.mul(q, r))
        return graph.neg(minor) if (i + k) % 2 else minor

    def _by_normal_equations(
        self, chosen: tuple[int, ...], a: list[list[int]], right: list[list[int]]
    ) -> list[list[int]]:
        graph, size = self.graph, len(chosen)
        rows = [{k: x for k, x in enumerate(row) if x != graph.zero} for row in a]
        weights = {k: {k: graph.one} for k in range(size)}
        solutions, checks = solve_by_multipliers(graph, rows, weights, right, Labels())
        self.checks += [check._replace(constraint=chosen[check.constraint]) for check in checks]
        return [[x[k] for k in range(size)] for x in solutions]


Solution = tuple[list[list[int]], SparseRows]
"""The unknowns, one list a right side, and the solver, with its pivots and names."""


def correction(scene: SceneGraph) -> Kernel:
    """The kernel of a scene in all its coordinates."""
    jacobian = scene.turning.jacobian(scene.jacobian, scene.turned_jacobian, scene.norms)
    equations, stated = (scene.graph, jacobian, scene.phi, scene.nu), scene.stated
    kernel = least_correction(*equations, scene.v, scene.w, scene.names, scene.rows)
    if scene.turns and scene.m < scene.n:
        with scene.graph.serving("correction"), scene.graph.cancelling():
            by_turns = _kernel(scene.names, *changes_by_turns(scene))
        kernel = cheapest(scene.graph, [by_turns, kernel])
    checks = (check._replace(constraint=stated[check.constraint]) for check in kernel.checks)
    return replace(kernel, checks=tuple(checks))


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
