"""The static factorization: which unknown to eliminate when is decided here, at build time.

The unknowns of dynamics solve

    [ M    Φ_qᵀ ] [ q̈ ]   [ Q ]
    [ Φ_q  0    ] [ λ ] = [ γ ] .

Eliminating all accelerations first leaves S = Φ_q M⁻¹ Φ_qᵀ, to be factored LDLᵀ. That is one of
the orders tried. Another uses that many constraints give a coordinate outright: where an entry
of Φ_q is a number, the pair (coordinate, constraint) is a pivot of two rows that is as good as a
substitution, and what is left shrinks to the closures of the loops. M is positive definite
(`codegen.derive.inertia` makes it so where bodies have equations of their own). So no pivot
vanishes in any position where the constraints are independent: a coordinate's pivot is positive, a
constraint's negative, and a pair's determinant at most -b², with b at least a tenth of the largest
number in its row of Φ_q. The cheapest order may be taken.
"""

from dataclasses import dataclass, field
from typing import Literal

from codegen.lower.graph import Graph
from codegen.lower.linear.back_substitution import Loop, Pair, Single
from codegen.lower.linear.labels import Labels
from codegen.lower.linear.sparse_row_elimination import LEAST_PIVOT
from codegen.lower.program import Check

DIVISION = 8  # measured: operations that one division is worth in the choice of an order

Entries = dict[tuple[int, int], int]  # (row, column) → value, structural non-zeros only
Strategy = Literal["substitute", "mixed", "schur", "square"]
"""Pairs while there are any; whatever is cheapest now; accelerations, then multipliers; what
constraints alone determine, `codegen.lower.linear.square_systems`."""


def augmented(
    graph: Graph, mass: Entries, jacobian: Entries, n: int
) -> tuple[Entries, dict[int, int]]:
    """[M Φ_qᵀ; Φ_q 0] of n coordinates, and by unknown the diagonal of Φ_q M⁻¹ Φ_qᵀ."""
    entries = {place: m for place, m in mass.items() if m != graph.zero}
    references: dict[int, int] = {}
    for (i, k), entry in jacobian.items():
        entries[n + i, k] = entries[k, n + i] = entry
        if (k, k) in entries:
            part = graph.div(graph.mul(entry, entry), mass[k, k])
            references[n + i] = graph.add(references.get(n + i, graph.zero), part)
    return entries, references


@dataclass
class Elimination:
    """A symmetric sparse system of graph values, reduced pivot by pivot."""

    graph: Graph
    entries: Entries  # both triangles
    right: list[list[int]]  # right sides, one list a column
    duals: frozenset[int] = frozenset()  # the unknowns that are multipliers
    # Unknown → the size that its pivot is held against; the others are not watched.
    references: dict[int, int] = field(default_factory=dict)
    # Pairs to eliminate first, in this order: a coordinate without mass, the constraint that
    # determines it, and whether to watch that it does. Along a curve without cusps it does always;
    # where two directions have to differ, the entry is held against those of the row as it was
    # stated, which are angles like it.
    located: list[tuple[int, int, bool]] = field(default_factory=list)
    labels: Labels = field(default_factory=Labels)  # of entries, pivots, right sides and unknowns
    checks: list[Check] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self._stated = dict(self.entries), [list(right) for right in self.right]
        self._pivots: list[Single | Pair] = []
        self._loop: list[Loop] = []  # the loop that closes the system, where one does
        self._neighbours: dict[int, set[int]] = {i: set() for i in range(len(self.right[0]))}
        for i, j in self.entries:
            if i != j:
                self._neighbours[i].add(j)

    def solve(self, strategy: Strategy) -> list[list[int]]:
        """Values of the unknowns, one list a right side."""
        known: list[dict[int, int]] = [{} for _ in self.right]
        self._eliminate_located()
        while self._neighbours and not self._loop:
            if last := self._last_loop():
                self._close_loop(*last)
                for right, x in zip(self.right, known, strict=True):
                    self._loop[0].back(self.graph, right, x)
                for names, x in zip(self.labels.solution, known, strict=False):
                    for i, value in x.items():
                        self.labels.add(value, names[i])
            elif len(step := self._cheapest(strategy)) == 2:
                self._pair(*step)
            else:
                self._single(*step)
        self.labels.step("Substitute back")
        columns = [self._back(right, x) for right, x in zip(self.right, known, strict=True)]
        self.labels.solved(columns)
        return columns

    def refined(self, solution: list[list[int]]) -> list[list[int]]:
        """The unknowns after one step of iterative refinement with the original equations.

        One step makes an elimination whose order ignores the sizes of masses as accurate as the
        equations themselves (R. D. Skeel, Mathematics of Computation 35, 1980).
        """
        graph, (entries, sides) = self.graph, self._stated
        columns = []
        for right, x in zip(sides, solution, strict=True):
            lack = list(right)
            for (i, j), entry in entries.items():
                lack[i] = graph.sub(lack[i], graph.mul(entry, x[j]))
            for pivot in self._pivots:
                pivot.prepare(graph, lack)
                for j in pivot.across:
                    pivot.forward(graph, lack, j)
            columns.append(list(map(graph.add, x, self._back(lack, {}))))
        return columns

    def _back(self, right: list[int], x: dict[int, int]) -> list[int]:
        """The unknowns of a right side through which the pivots have gone forward."""
        for pivot in reversed([*self._pivots, *self._loop]):
            pivot.back(self.graph, right, x)
        return [x[i] for i in range(len(x))]

    # -- order -------------------------------------------------------------------------------

    def _cheapest(self, strategy: Strategy) -> tuple[int, ...]:
        """The pivot that causes the least work now; ties go to the smaller number."""
        left = self._neighbours
        primals = [i for i in left if i not in self.duals]
        ready = [i for i in left if i in self.duals and not left[i] - self.duals]
        singles = [(self._single_cost(i), (i,)) for i in primals]
        if strategy == "schur":
            return min(singles or [(self._single_cost(c), (c,)) for c in ready])[1]
        pairs = [(self._pair_cost(*pair), pair) for pair in self._pairs()]
        if strategy == "substitute" and pairs:
            return min(pairs)[1]
        return min(singles + pairs + [(self._single_cost(c), (c,)) for c in ready])[1]

    def _pairs(self) -> list[tuple[int, int]]:
        """Coordinate and constraint with a number between them, the constraint untouched yet."""
        return [
            (k, c)
            for c in self._neighbours
            if c in self.duals and self._at(c, c) == self.graph.zero
            for k in self._neighbours[c] - self.duals
            if self._size(k, c) >= LEAST_PIVOT * max(self._size(j, c) for j in self._neighbours[c])
            and self._size(k, c) > 0.0
        ]

    def _size(self, k: int, c: int) -> float:
        """Size of an entry of Φ_q that is a number, else 0."""
        return abs(self.graph.number(self._at(k, c)) or 0.0)

    def _single_cost(self, i: int) -> int:
        degree = len(self._neighbours[i])
        division = 0 if self.graph.settled[self._at(i, i)] else DIVISION
        return division + degree * (degree + 3) // 2

    def _pair_cost(self, k: int, c: int) -> int:
        along, across = len(self._neighbours[k]) - 1, len(self._neighbours[c]) - 1
        mass = 0 if self._at(k, k) == self.graph.zero else across * (across + 1) // 2
        return across * along + mass + along + across

    # -- pivots ------------------------------------------------------------------------------

    def _at(self, i: int, j: int) -> int:
        return self.entries.get((i, j), self.graph.zero)

    def _subtract(self, i: int, j: int, value: int) -> None:
        if value == self.graph.zero:
            return
        self.entries[i, j] = self.entries[j, i] = self.graph.sub(self._at(i, j), value)
        self.labels.entry(self.entries[i, j], i, j, self.duals)
        if i != j:
            self._neighbours[i].add(j)
            self._neighbours[j].add(i)

    def _detach(self, *unknowns: int) -> list[int]:
        """Take unknowns out of the system; returns those that they were coupled with."""
        around = set().union(*(self._neighbours.pop(u) for u in unknowns)) - {*unknowns}
        for j in around:
            self._neighbours[j] -= {*unknowns}
        return sorted(around)

    def _single(self, i: int) -> None:
        graph, labels, pivot = self.graph, self.labels, self._at(i, i)
        if i in self.references:
            size = graph.neg(pivot) if i in self.duals else pivot
            known = graph.number(size) is not None and graph.number(self.references[i]) is not None
            if not known:  # two numbers are compared before the build
                self.checks.append(Check(size, self.references[i], i))
        inverse = graph.div(graph.one, pivot)
        labels.step(f"Eliminate {labels.titles(i)}")
        labels.pivot(pivot, inverse, i)
        along = {j: self._at(i, j) for j in self._detach(i)}
        across = {j: graph.mul(inverse, entry) for j, entry in along.items()}
        for j, entry in across.items():
            labels.add(entry, labels.of("L", j, i))
        self._eliminate(Single(i, inverse, along, across))

    def _eliminate_located(self) -> None:
        """Eliminate the pairs of `located`: a massless coordinate with the row that determines it.

        A watched pair brings a check: where its entry vanishes, the row no longer determines the
        coordinate. The rows are measured as they were stated, before any pair is eliminated.
        """
        graph, squares = self.graph, {}
        for _, c, watched in self.located:
            if watched:
                row = [self._at(j, c) for j in sorted(self._neighbours[c])]
                squares[c] = graph.dot(row, row)
        for k, c, watched in self.located:
            entry = self._at(k, c)
            if watched and graph.number(square := graph.mul(entry, entry)) is None:
                self.checks.append(Check(square, squares[c], c))
            self._pair(k, c)

    def _pair(self, k: int, c: int) -> None:
        graph, labels = self.graph, self.labels
        a, over_b = self._at(k, k), graph.div(graph.one, self._at(k, c))
        labels.step(f"Eliminate {labels.titles(k)} with {labels.titles(c)}")
        labels.pivot(self._at(k, c), over_b, c)
        along = {j: self._at(k, j) for j in self._detach(k, c)}
        across = {j: graph.mul(over_b, self._at(c, j)) for j in along}
        rest = {j: graph.sub(along[j], graph.mul(a, across[j])) for j in along}
        for j in along:
            labels.add(across[j], labels.of("L", c, j))
            labels.entry(rest[j], k, j, self.duals)
        self._eliminate(Pair(k, c, a, over_b, along, across, rest))

    def _eliminate(self, pivot: Single | Pair) -> None:
        """Take the unknowns of a pivot out of the rows that they were coupled with."""
        self._pivots.append(pivot)
        for right in self.right:
            pivot.prepare(self.graph, right)
        around = list(pivot.across)
        for n, i in enumerate(around):
            for j in around[n:]:
                self._subtract(i, j, pivot.update(self.graph, i, j))
            for right in self.right:
                pivot.forward(self.graph, right, i)
            self.labels.sides(self.right, i)

    def _last_loop(self) -> tuple[int, int, int] | None:
        """Two coordinates and the constraint that closes a loop, where nothing else is left."""
        left = sorted(self._neighbours)
        if len(left) != 3 or [i in self.duals for i in left] != [False, False, True]:
            return None
        i, j, c = left
        coupled = c in self._neighbours[i] and c in self._neighbours[j]
        return (i, j, c) if coupled and self._at(c, c) == self.graph.zero else None

    def _close_loop(self, i: int, j: int, c: int) -> None:
        graph, labels = self.graph, self.labels
        mul, sub = graph.mul, graph.sub
        a, b, d = self._at(i, i), self._at(i, j), self._at(j, j)
        u, v = self._at(i, c), self._at(j, c)
        minor_i, minor_j = sub(mul(d, u), mul(b, v)), sub(mul(a, v), mul(b, u))
        area = sub(mul(a, d), mul(b, b))
        form = graph.add(mul(u, minor_i), mul(v, minor_j))
        labels.step(f"Solve for {labels.titles(i, j)} and the multiplier of {labels.titles(c)}")
        if c in self.references:
            size = mul(area, self.references[c])
            self.checks.append(Check(form, size, c))
            labels.add(size, labels.of("limit", c))
        inverse = graph.div(graph.one, form)
        labels.pivot(form, inverse, c)
        labels.add(area, labels.of("det_M", i, j))
        labels.add(minor_i, labels.of("minor", i))
        labels.add(minor_j, labels.of("minor", j))
        self._loop.append(Loop(i, j, c, u, v, minor_i, minor_j, area, inverse))
