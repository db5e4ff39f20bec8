"""The least change that meets the constraints: by the null space of Φ_q, or by multipliers.

    min Σ d_k² / w_k   with   Φ_q d = r

has the solutions d = d₀ + N z of its constraints, and z from Nᵀ W⁻¹ N z = -Nᵀ W⁻¹ d₀ (Å. Björck,
Numerical Methods for Least Squares Problems, 1996, section 5.1.3). N is found row by row: a number
in Φ_q determines its coordinate, whatever the weights are; one row with two unknowns, or
two with three, leave one unknown z along n = (v, -u) or n = c₁ × c₂; d₀ is their least solution.
Neither divides by anything but n·n, which vanishes in singular positions only.

Where every coordinate follows one z, z = -Σ g n d₀ / Σ g n² with g = 1/w divides by a sum of
positive terms: no digits are lost, however far apart the weights lie. The elimination of Φ_q W Φ_qᵀ
takes back from its pivots what a heavy weight added to them, and loses as many digits as the
weights lie apart. With more than one degree of freedom in a loop that elimination is taken, by the
multipliers of the constraints: d = W Φ_qᵀ μ with Φ_q W Φ_qᵀ μ = r.
"""

from collections.abc import Iterable, Mapping, Sequence

from codegen.lower.graph import Graph
from codegen.lower.linear.elimination_order import Row
from codegen.lower.linear.factorization import Elimination
from codegen.lower.linear.sparse_row_elimination import SparseRows, Task, prefixed
from codegen.lower.program import Check, Labels

TINY = 1e-100  # safety: added to weights before they are inverted; w = 0 holds a coordinate
LARGEST = 2  # closures that are solved together


class NullSpace(SparseRows):
    """The least change by base solutions and a null space."""

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self.labels, self.weights = task.labels(task.columns), task.weights
        self._unknowns = dict.fromkeys(range(len(self.weights)))
        self._determined: set[int] = set()

    def solve(self) -> list[list[int]] | None:
        """The changes, one list a right side; None where this is not the way to find them."""
        while pivot := self._explicit_coordinate():
            self._give_coordinate(*pivot)
        while self._rows:
            chosen = self._smallest_set(LARGEST, range(1, 2))
            if chosen is None:
                return None
            self._give_closures(chosen)
        return self._least()

    # -- the null space ----------------------------------------------------------------------

    def _give_coordinate(self, i: int, k: int) -> None:
        """x_k = (r - Σ entry x) / number."""
        graph = self.graph
        row = self._remove(i)
        self._step(f"Eliminate {self.labels.titles(k)} with", i)
        inverse = graph.div(graph.one, row.pop(k))
        if not row:  # what a constraint determines may not be held
            self.checks.append(Check(self.weights[k], graph.zero, i))
            self._determined.add(k)
        coefficients = {j: graph.mul(inverse, entry) for j, entry in row.items()}
        self._give(k, coefficients, [graph.mul(inverse, column[i]) for column in self.right])

    def _give(self, k: int, coefficients: Row, base: list[int]) -> None:
        """Put x_k = base - Σ coefficient x into the rows."""
        del self._unknowns[k]
        for names, start in zip(self.labels.solution, base, strict=False):
            if k < len(names):
                self.labels.add(start, f"part_{names[k]}")
        self._eliminate(k, coefficients, base)

    def _step(self, title: str, *rows: int) -> None:
        if self.task.rows:
            self.labels.step(f"{title} {', '.join(self.task.rows[i] for i in rows)}")

    def _name_all(self, unknowns: Iterable[int], values: Iterable[int], stem: str) -> None:
        """Name values of unknowns, as far as these are coordinates."""
        for k, value in zip(unknowns, values, strict=True):
            if k < len(self.labels.names):
                self.labels.name(value, stem, k)

    def _give_closures(self, chosen: tuple[int, ...]) -> None:
        """Replace the unknowns of rows by their least solution and one unknown along n."""
        graph = self.graph
        columns = self._unknowns_of(chosen)
        self._step("Take the least solution and the null space of", *chosen)
        rows = [self._rows[i] for i in chosen]
        matrix = self._take(chosen, columns)
        if len(chosen) == 1:
            ((u, v),) = matrix
            n, least = [v, graph.neg(u)], [[u, v]]
        else:
            n = self._cross(*matrix)
            least = [self._cross(matrix[1], n), self._cross(n, matrix[0])]
        square = graph.dot(n, n)
        self._watch(chosen, rows, columns, n)
        inverse = graph.div(graph.one, square)
        self._name_all(columns, n, "n")
        z = len(self.weights) + len(self._eliminated)
        self._unknowns[z] = None
        factors = [[graph.mul(inverse, column[i]) for i in chosen] for column in self.right]
        for at, k in enumerate(columns):
            base = [graph.dot(r, [x[at] for x in least]) for r in factors]
            self._give(k, {z: graph.neg(n[at])}, base)

    def _cross(self, a: list[int], b: list[int]) -> list[int]:
        mul, sub = self.graph.mul, self.graph.sub
        return [sub(mul(a[i], b[j]), mul(a[j], b[i])) for i, j in ((1, 2), (2, 0), (0, 1))]

    def _watch(
        self, chosen: tuple[int, ...], rows: list[Row], columns: list[int], n: list[int]
    ) -> None:
        """Hold det(C W Cᵀ) of the closures against the diagonal of Φ_q W Φ_qᵀ."""
        graph = self.graph
        weights = dict.fromkeys(columns, graph.one)
        if columns[-1] < len(self.weights):  # without what constraints determine
            weights = {k: w for k, w in enumerate(self.weights) if k not in self._determined}
            rows = [self._original[i] for i in chosen]
        pivot, reference = graph.zero, graph.one
        for k, minor in zip(columns, n, strict=True):
            term = graph.mul(minor, minor)
            for other in columns:
                term = term if other == k else graph.mul(weights[other], term)
            pivot = graph.add(pivot, term)
        for row in rows:
            terms = [graph.mul(weights[k], graph.mul(x, x)) for k, x in row.items() if k in weights]
            reference = graph.mul(reference, graph.total(terms))
        self.checks.append(Check(pivot, reference, max(chosen)))
        if self.task.rows:
            names = "_".join(self.task.rows[i] for i in chosen)
            self.labels.add(pivot, f"det_{names}")
            self.labels.add(reference, f"size_{names}")

    # -- the least change --------------------------------------------------------------------

    def _least(self) -> list[list[int]] | None:
        """The change along each unknown that is left; None where one coordinate follows two."""
        graph, mul, labels = self.graph, self.graph.mul, self.labels
        labels.step("Substitute back")
        coordinates = range(len(self.weights))
        nothing = [graph.zero] * len(self.right)
        slopes: dict[int, Row] = {z: {z: graph.one} for z in self._unknowns}
        base = dict.fromkeys(self._unknowns, nothing)
        for k, row, start in reversed(self._eliminated):
            slopes[k], base[k] = {}, list(start)
            for j, factor in row.items():
                for z, slope in slopes[j].items():
                    product = mul(factor, slope)
                    slopes[k][z] = graph.sub(slopes[k].get(z, graph.zero), product)
                for column, shift in enumerate(base[j]):
                    base[k][column] = graph.sub(base[k][column], mul(factor, shift))
            if k in coordinates and len(slopes[k]) > 1:
                return None
        for column, names in enumerate(labels.solution):
            for k in coordinates:
                labels.add(base[k][column], f"base_{names[k]}")
        labels.step("Solve for the change along the null space")
        changes = [[base[k][column] for k in coordinates] for column in range(len(self.right))]
        for z in self._unknowns:
            moved = {k: slopes[k][z] for k in coordinates if z in slopes[k]}
            small = graph.constant(TINY)
            ease = {k: graph.div(graph.one, graph.add(self.weights[k], small)) for k in moved}
            pull = {k: mul(ease[k], slope) for k, slope in moved.items()}
            inverse = graph.div(graph.one, graph.dot(pull.values(), moved.values()))
            free = {k: mul(self.weights[k], ease[k]) for k in moved}  # 1, and 0 where k is held
            self._name_all(moved, moved.values(), "n")
            self._name_all(ease, ease.values(), "g")
            for d in changes:
                step = mul(inverse, graph.dot(pull.values(), [d[k] for k in moved]))
                for k, slope in moved.items():
                    d[k] = mul(free[k], graph.sub(d[k], mul(step, slope)))
        labels.solved(changes)
        return changes


class NormalEquations(SparseRows):
    """The least change by multipliers."""

    def solve(self) -> list[list[int]]:
        """The changes, one list a right side."""
        graph, task = self.graph, self.task
        while (i := self._first_row(self._determines)) is not None:
            ((k, number),) = self._remove(i).items()  # the weights do not matter there
            self.checks.append(Check(task.weights[k], graph.zero, i))
            self._eliminate(k, {}, [graph.div(column[i], number) for column in self.right])
        left = list(self._rows)
        names = [task.rows[i] for i in left]
        multipliers = [stem.replace("rhs", "mu") for stem in task.stems]
        sides, unknowns = prefixed(task.stems, names), prefixed(multipliers, names)
        self.labels = Labels(names, sides, unknowns, "S")
        self.labels.step("The matrix and the right sides")
        right = [[column[i] for i in left] for column in self.right]
        weights = task.blocks or {k: {k: w} for k, w in enumerate(task.weights)}
        matrix = [self._rows[i] for i in left]
        given = graph, matrix, weights, right, self.labels, task.changes
        solved, checks = solve_by_multipliers(*given)
        self.checks += [check._replace(constraint=left[check.constraint]) for check in checks]
        changes = []
        for column, sums in enumerate(solved):
            sums |= {k: right[column] for k, _, right in self._eliminated}
            changes.append([sums.get(k, graph.zero) for k in task.changes or weights])
        return changes

    def _determines(self, row: Row) -> bool:
        """Whether a row has one unknown and a number in front of it."""
        return len(row) == 1 and all(self.graph.floats[entry] is not None for entry in row.values())


def solve_by_multipliers(
    graph: Graph, rows: Sequence[Row], weights: Mapping[int, Row], right: list[list[int]],
    labels: Labels, changes: Mapping[int, Row] | None = None,
) -> tuple[list[Row], list[Check]]:  # fmt: skip
    """x = W Aᵀ μ, A W Aᵀ μ = r, with positive pivots in any position that is not singular.

    `weights` has the rows of W. Returns column → value, one a right side, and the pivots to watch,
    by the number of the row. Of `changes`, unknown → its row of a matrix in the place of W before
    Aᵀ μ, these unknowns are returned.
    """
    entries: dict[tuple[int, int], int] = {}
    users: dict[int, list[int]] = {}  # column → rows that contain it
    for a, row in enumerate(rows):
        for k in row:
            users.setdefault(k, []).append(a)
    for a, row in enumerate(rows):
        weighted: Row = {}  # by column, once it is needed
        around = dict.fromkeys(k for j in row for k in weights[j])
        for b in sorted({a, *(b for k in around for b in users.get(k, ()) if b > a)}):
            other, terms = rows[b], []
            for k in around:
                if k in other:
                    if k not in weighted:
                        weighted[k] = _product(graph, weights[k], row)
                    terms.append(graph.mul(weighted[k], other[k]))
            entries[a, b] = entries[b, a] = graph.total(terms)
            labels.entry(entries[a, b], a, b)
    references = {a: entries[a, a] for a in range(len(rows))}
    for a in range(len(rows)):
        labels.sides(right, a)
    system = Elimination(graph, entries, right, references=references, labels=labels)
    multipliers = system.solve("schur")
    labels.step("W Φ_qᵀ μ")
    solutions = []
    for column in multipliers:
        sums: Row = {}
        for row, mu in zip(rows, column, strict=True):
            for k, entry in row.items():
                sums[k] = graph.add(sums.get(k, graph.zero), graph.mul(entry, mu))
        given = changes or {k: weights[k] for k in sums}
        solutions.append({k: _product(graph, of, sums) for k, of in given.items()})
    return solutions, system.checks


def _product(graph: Graph, one: Row, other: Row) -> int:
    """The product of two rows."""
    return graph.total([graph.mul(x, other[k]) for k, x in one.items() if k in other])
