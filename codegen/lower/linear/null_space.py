"""The least change that meets the constraints, by the null space of Φ_q.

    min Σ d_k² / w_k   with   Φ_q d = r

has the solutions d = d₀ + N z of its constraints, and z from Nᵀ W⁻¹ N z = -Nᵀ W⁻¹ d₀ (Å. Björck,
Numerical Methods for Least Squares Problems, 1996, section 5.1.3). N is found row by row: a number
in Φ_q gives its coordinate outright, the weights have no part in it; one row with two unknowns, or
two with three, leave one unknown z along n = (v, -u) or n = c₁ × c₂; d₀ is their least solution.
Neither divides by anything but n·n, which vanishes in singular positions only.

Where every coordinate follows one z, z = -Σ g n d₀ / Σ g n² with g = 1/w divides by a sum of
positive terms: no digits are lost, however far apart the weights lie. The elimination of Φ_q W Φ_qᵀ
takes back from its pivots what a heavy weight added to them, and loses as many digits as the
weights lie apart. With more than one degree of freedom in a loop that elimination is taken.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import combinations

from codegen.lower.graph import Graph
from codegen.lower.linear.labels import Labels
from codegen.lower.linear.pivots import explicit_coordinate
from codegen.lower.program import Check

TINY = 1e-100  # safety: added to weights before they are inverted; w = 0 holds a coordinate
LARGEST = 2
"""Closures that are solved together."""
SEARCHED = 30  # safety: rows among which pairs of closures are looked for

Row = dict[int, int]
"""Unknown → coefficient."""


@dataclass
class NullSpace:
    """Φ_q d = r for several right sides, d least in the norm dᵀ W⁻¹ d.

    Attributes
    ----------
    entries
        (row, column) → value, structural non-zeros only.
    right
        Right sides, one list of rows each.
    weights
        One value a column.
    labels, rows
        Names for the text, of coordinates and of constraints.
    checks
        What is watched; the constraint of a check is a row.
    """

    graph: Graph
    entries: dict[tuple[int, int], int]
    right: list[list[int]]
    weights: list[int]
    labels: Labels = field(default_factory=Labels)
    rows: Sequence[str] = ()
    checks: list[Check] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self.right = [list(column) for column in self.right]
        self._rows: dict[int, Row] = {i: {} for i in range(len(self.right[0]))}
        for (i, k), entry in sorted(self.entries.items()):
            self._rows[i][k] = entry
        self._original = {i: dict(row) for i, row in self._rows.items()}
        self._unknowns = dict.fromkeys(range(len(self.weights)))
        self._eliminated: list[tuple[int, Row, list[int]]] = []
        self._determined: set[int] = set()

    def solve(self) -> list[list[int]] | None:
        """The changes, one list a right side; None where this is not the way to find them."""
        while pivot := explicit_coordinate(self.graph, self._rows):
            self._give_coordinate(*pivot)
        while self._rows:
            chosen = self._closures()
            if chosen is None:
                return None
            self._give_closures(chosen)
        return self._least()

    # -- the null space ----------------------------------------------------------------------

    def _give_coordinate(self, i: int, k: int) -> None:
        """x_k = (r - Σ entry x) / number."""
        graph = self.graph
        row = self._rows.pop(i)
        self._step(f"Eliminate {self.labels.titles(k)} with", i)
        inverse = graph.div(graph.one, row.pop(k))
        slopes = {j: graph.neg(graph.mul(inverse, entry)) for j, entry in row.items()}
        if not slopes:  # what a constraint determines may not be held
            self.checks.append(Check(self.weights[k], graph.zero, i))
            self._determined.add(k)
        self._give(k, slopes, [graph.mul(inverse, column[i]) for column in self.right])

    def _give(self, k: int, slopes: Row, base: list[int]) -> None:
        """Put x_k = base + Σ slope x into the rows."""
        graph = self.graph
        del self._unknowns[k]
        self._eliminated.append((k, slopes, base))
        for i, row in self._rows.items():
            if k not in row:
                continue
            factor = row.pop(k)
            for j, slope in slopes.items():
                entry = graph.add(row.pop(j, graph.zero), graph.mul(factor, slope))
                if entry != graph.zero:
                    row[j] = entry
            for column, start in zip(self.right, base, strict=True):
                column[i] = graph.sub(column[i], graph.mul(factor, start))

    def _closures(self) -> tuple[int, ...] | None:
        """Fewest rows with one unknown more than they are."""
        rows = tuple(self._rows)
        for size in range(1, LARGEST + 1 if len(rows) <= SEARCHED else 2):
            for chosen in combinations(rows, size):
                if len(self._columns(chosen)) == size + 1:
                    return chosen
        return None

    def _step(self, title: str, *rows: int) -> None:
        if self.rows:
            self.labels.step(f"{title} {', '.join(self.rows[i] for i in rows)}")

    def _name(self, unknowns: Iterable[int], values: Iterable[int], stem: str) -> None:
        """Name values of unknowns, as far as these are coordinates."""
        for k, value in zip(unknowns, values, strict=True):
            if k < len(self.labels.names):
                self.labels.add(value, self.labels.of(stem, k))

    def _columns(self, chosen: tuple[int, ...]) -> list[int]:
        return sorted(set().union(*(self._rows[i] for i in chosen)))

    def _give_closures(self, chosen: tuple[int, ...]) -> None:
        """Replace the unknowns of rows by their least solution and one unknown along n."""
        graph = self.graph
        mul, total = graph.mul, graph.total
        columns = self._columns(chosen)
        self._step("Solve, by the least solution and the null space,", *chosen)
        matrix = [[self._rows[i].get(k, graph.zero) for k in columns] for i in chosen]
        rights = [[column[i] for i in chosen] for column in self.right]
        if len(chosen) == 1:
            ((u, v),) = matrix
            n, least = [v, graph.neg(u)], [[u, v]]
        else:
            n = self._cross(*matrix)
            least = [self._cross(matrix[1], n), self._cross(n, matrix[0])]
        square = total([mul(x, x) for x in n])
        self._watch(chosen, columns, n)
        inverse = graph.div(graph.one, square)
        self._name(columns, n, "n")
        z = len(self.weights) + len(self._eliminated)
        self._unknowns[z] = None
        factors = [[mul(inverse, r) for r in right] for right in rights]
        for i in chosen:
            del self._rows[i]
        for at, k in enumerate(columns):
            base = [total([mul(f, x[at]) for f, x in zip(r, least, strict=True)]) for r in factors]
            self._give(k, {z: n[at]}, base)

    def _cross(self, a: list[int], b: list[int]) -> list[int]:
        mul, sub = self.graph.mul, self.graph.sub
        return [sub(mul(a[i], b[j]), mul(a[j], b[i])) for i, j in ((1, 2), (2, 0), (0, 1))]

    def _watch(self, chosen: tuple[int, ...], columns: list[int], n: list[int]) -> None:
        """Hold det(C W Cᵀ) of the closures against the diagonal of Φ_q W Φ_qᵀ."""
        graph = self.graph
        original = columns[-1] < len(self.weights)
        weights = {k: self.weights[k] if original else graph.one for k in columns}
        rows = {i: self._rows[i] for i in chosen}
        if original:  # without what constraints determine
            moving = {k: w for k, w in enumerate(self.weights) if k not in self._determined}
            weights, rows = moving, {i: self._original[i] for i in chosen}
        pivot, reference = graph.zero, graph.one
        for k, minor in zip(columns, n, strict=True):
            term = graph.mul(minor, minor)
            for other in columns:
                term = term if other == k else graph.mul(weights[other], term)
            pivot = graph.add(pivot, term)
        for row in rows.values():
            terms = [graph.mul(weights[k], graph.mul(x, x)) for k, x in row.items() if k in weights]
            reference = graph.mul(reference, graph.total(terms))
        self.checks.append(Check(pivot, reference, max(chosen)))

    # -- the least change --------------------------------------------------------------------

    def _least(self) -> list[list[int]] | None:
        """The change along each unknown that is left; None where one coordinate follows two."""
        graph, labels = self.graph, self.labels
        mul, total = graph.mul, graph.total
        labels.step("Substitute back")
        nothing = [graph.zero] * len(self.right)
        slopes: dict[int, Row] = {z: {z: graph.one} for z in self._unknowns}
        base = dict.fromkeys(self._unknowns, nothing)
        for k, row, start in reversed(self._eliminated):
            slopes[k], base[k] = {}, list(start)
            for j, factor in row.items():
                for z, slope in slopes[j].items():
                    product = mul(factor, slope)
                    slopes[k][z] = graph.add(slopes[k].get(z, graph.zero), product)
                for column, shift in enumerate(base[j]):
                    base[k][column] = graph.add(base[k][column], mul(factor, shift))
        coordinates = range(len(self.weights))
        for column, names in enumerate(labels.solution):
            for k in coordinates:
                labels.add(base[k][column], f"base_{names[k]}")
        if any(len(slopes[k]) > 1 for k in coordinates):
            return None
        labels.step("Solve for the change along the null space")
        changes = [[base[k][column] for k in coordinates] for column in range(len(self.right))]
        for z in self._unknowns:
            moved = {k: slopes[k][z] for k in coordinates if z in slopes[k]}
            small = graph.constant(TINY)
            ease = {k: graph.div(graph.one, graph.add(self.weights[k], small)) for k in moved}
            pull = {k: mul(ease[k], slope) for k, slope in moved.items()}
            inverse = graph.div(graph.one, total([mul(pull[k], n) for k, n in moved.items()]))
            free = {k: mul(self.weights[k], ease[k]) for k in moved}  # 1, and 0 where k is held
            self._name(moved, moved.values(), "n")
            self._name(ease, ease.values(), "g")
            for d in changes:
                step = mul(inverse, total([mul(pull[k], d[k]) for k in moved]))
                for k, slope in moved.items():
                    d[k] = mul(free[k], graph.sub(d[k], mul(step, slope)))
        labels.solved(changes)
        return changes
