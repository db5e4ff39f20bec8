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

The pivots of an elimination: forward through a right side, and back to its unknowns.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Literal

from codegen.lower.graph import Graph
from codegen.lower.linear.elimination_order import PivotOrder
from codegen.lower.program import Check, Labels


@dataclass(frozen=True)
class Single:
    """An eliminated unknown i: x_i = inverse · right_i - Σ across · x_j."""

    i: int
    inverse: int
    along: dict[int, int]  # the row
    across: dict[int, int]  # inverse · along

    def update(self, graph: Graph, j: int, k: int) -> int:
        """The number that the entry (j, k) loses with the unknown."""
        return graph.mul(self.across[j], self.along[k])

    def prepare(self, graph: Graph, right: list[int]) -> None:
        """Nothing: the right side of the row stays."""

    def forward(self, graph: Graph, right: list[int], j: int) -> None:
        """Take the unknown out of the right side of row j."""
        right[j] = graph.sub(right[j], graph.mul(self.across[j], right[self.i]))

    def back(self, graph: Graph, right: list[int], x: dict[int, int]) -> None:
        """Find the unknown from those eliminated later."""
        x[self.i] = graph.less(graph.mul(self.inverse, right[self.i]), self.across, x)


@dataclass(frozen=True)
class Pair:
    """A coordinate k and a constraint c that gives it: b x_k + Σ b across · x_j = b right_c."""

    k: int
    c: int
    a: int
    over_b: int
    along: dict[int, int]
    across: dict[int, int]
    rest: dict[int, int]  # along - a across

    def update(self, graph: Graph, i: int, j: int) -> int:
        """The number that the entry (i, j) loses with both unknowns."""
        first = graph.mul(self.along[i], self.across[j])
        return graph.add(first, graph.mul(self.across[i], self.rest[j]))

    def prepare(self, graph: Graph, right: list[int]) -> None:
        """Divide the right side of row c by b."""
        right[self.c] = graph.mul(self.over_b, right[self.c])

    def forward(self, graph: Graph, right: list[int], j: int) -> None:
        """Take both unknowns out of the right side of row j."""
        inner = graph.sub(right[self.k], graph.mul(self.a, right[self.c]))
        both = graph.mul(self.along[j], right[self.c]), graph.mul(self.across[j], inner)
        right[j] = graph.sub(right[j], graph.add(*both))

    def back(self, graph: Graph, right: list[int], x: dict[int, int]) -> None:
        """Find both unknowns from those eliminated later."""
        x[self.k] = graph.less(right[self.c], self.across, x)
        force = graph.sub(right[self.k], graph.mul(self.a, x[self.k]))
        x[self.c] = graph.mul(self.over_b, graph.less(force, self.along, x))


@dataclass(frozen=True)
class Loop:
    """Two coordinates and the constraint that closes a loop, the last that is left.

    [[a, b, u], [b, d, v], [u, v, 0]] is solved by its adjugate: one division instead of three. The
    determinant is minus the positive definite form a v² - 2 b u v + d u².
    """

    i: int
    j: int
    c: int
    u: int
    v: int
    minor_i: int
    minor_j: int
    area: int
    inverse: int  # of the form

    def back(self, graph: Graph, right: list[int], x: dict[int, int]) -> None:
        """Find the three unknowns."""
        mul, sub = graph.mul, graph.sub
        r_i, r_j, r_c = right[self.i], right[self.j], right[self.c]
        across = sub(mul(self.v, r_i), mul(self.u, r_j))
        x_i = graph.add(mul(self.minor_i, r_c), mul(self.v, across))
        x_j = sub(mul(self.minor_j, r_c), mul(self.u, across))
        force = graph.add(mul(self.minor_i, r_i), mul(self.minor_j, r_j))
        force = sub(force, mul(self.area, r_c))
        for unknown, value in ((self.i, x_i), (self.j, x_j), (self.c, force)):
            x[unknown] = mul(self.inverse, value)


Entries = dict[tuple[int, int], int]  # (row, column) → value, structural non-zeros only
Strategy = Literal["substitute", "mixed", "schur", "leaves", "square"]
"""Pairs while there are any; whatever is cheapest now; accelerations, then multipliers; from the
leaves to the root; what constraints alone determine, `codegen.lower.kernels.corrections`."""


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
    entries: Entries  # as stated, both triangles
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
    # of each unknown the body or the joint that it belongs to, where bodies are eliminated whole
    owners: Sequence[str] = ()
    checks: list[Check] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self._stated = [list(right) for right in self.right]
        self._pivots: list[Single | Pair] = []
        self._loop: list[Loop] = []  # the loop that closes the system, where one does
        size, zero = len(self.right[0]), self.graph.zero
        self.diagonal = [zero] * size
        # unknown that is left → those that it is coupled with → the entry
        self.neighbours: dict[int, dict[int, int]] = {i: {} for i in range(size)}
        for (i, j), entry in self.entries.items():
            if i == j:
                self.diagonal[i] = entry
            else:
                self.neighbours[i][j] = entry

    def solve(self, strategy: Strategy) -> list[list[int]]:
        """Values of the unknowns, one list a right side."""
        known: list[dict[int, int]] = [{} for _ in self.right]
        self._eliminate_located()
        order = PivotOrder(self, strategy)
        while self.neighbours and not self._loop:
            if last := self._last_loop():
                self._close_loop(*last)
                for right, x in zip(self.right, known, strict=True):
                    self._loop[0].back(self.graph, right, x)
                for names, x in zip(self.labels.solution, known, strict=False):
                    for i, value in x.items():
                        self.labels.add(value, names[i])
            else:
                step = order.cheapest()
                changed = self._pair(*step) if len(step) == 2 else self._single(*step)
                order.renew(step, changed)
        self.labels.step("Substitute back")
        columns = [self._back(right, x) for right, x in zip(self.right, known, strict=True)]
        self.labels.solved(columns)
        return columns

    def refined(self, solution: list[list[int]]) -> list[list[int]]:
        """The unknowns after one step of iterative refinement with the original equations.

        One step makes an elimination whose order ignores the sizes of masses as accurate as the
        equations themselves (R. D. Skeel, Mathematics of Computation 35, 1980).
        """
        graph, columns = self.graph, []
        for right, x in zip(self._stated, solution, strict=True):
            lack = list(right)
            for (i, j), entry in self.entries.items():
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

    # -- pivots ------------------------------------------------------------------------------

    def at(self, i: int, j: int) -> int:
        """The entry (i, j), zero where there is none."""
        return self.diagonal[i] if i == j else self.neighbours[i].get(j, self.graph.zero)

    def _detach(self, unknown: int) -> dict[int, int]:
        """Take an unknown out of the system; returns its row, in order."""
        row = self.neighbours.pop(unknown)
        for j in row:
            del self.neighbours[j][unknown]
        return dict(sorted(row.items()))

    def _single(self, i: int) -> Iterable[int]:
        """Eliminate an unknown; returns those whose rows change."""
        graph, labels, pivot = self.graph, self.labels, self.diagonal[i]
        if i in self.references:
            size = graph.neg(pivot) if i in self.duals else pivot
            known = graph.number(size) is not None and graph.number(self.references[i]) is not None
            if not known:  # two numbers are compared before the build
                self.checks.append(Check(size, self.references[i], i))
        inverse = graph.div(graph.one, pivot)
        labels.step(f"Eliminate {labels.titles(i)}")
        labels.pivot(pivot, inverse, i)
        along = self._detach(i)
        across = {j: graph.mul(inverse, entry) for j, entry in along.items()}
        for j, entry in across.items():
            labels.name(entry, "L", j, i)
        self._eliminate(Single(i, inverse, along, across))
        return across

    def _eliminate_located(self) -> None:
        """Eliminate the pairs of `located`: a massless coordinate with the row that determines it.

        A watched pair brings a check: where its entry vanishes, the row no longer determines the
        coordinate. The rows are measured as they were stated, before any pair is eliminated.
        """
        graph, squares = self.graph, {}
        for _, c, watched in self.located:
            if watched:
                row = [self.at(j, c) for j in sorted(self.neighbours[c])]
                squares[c] = graph.dot(row, row)
        for k, c, watched in self.located:
            entry = self.at(k, c)
            if watched and graph.number(square := graph.mul(entry, entry)) is None:
                self.checks.append(Check(square, squares[c], c))
            self._pair(k, c)

    def _pair(self, k: int, c: int) -> Iterable[int]:
        """Eliminate a coordinate and its constraint; returns the unknowns whose rows change."""
        graph, labels = self.graph, self.labels
        a, b, zero = self.diagonal[k], self.at(k, c), graph.zero
        over_b = graph.div(graph.one, b)
        labels.step(f"Eliminate {labels.titles(k)} with {labels.titles(c)}")
        labels.pivot(b, over_b, c)
        first, second = self._detach(k), self._detach(c)
        first.pop(c, None)
        around = sorted({*first, *second})
        along = {j: first.get(j, zero) for j in around}
        across = {j: graph.mul(over_b, second.get(j, zero)) for j in around}
        rest = {j: graph.sub(along[j], graph.mul(a, across[j])) for j in around}
        for j in around:
            labels.name(across[j], "L", c, j)
            labels.entry(rest[j], k, j, self.duals)
        self._eliminate(Pair(k, c, a, over_b, along, across, rest))
        return across

    def _eliminate(self, pivot: Single | Pair) -> None:
        """Take the unknowns of a pivot out of the rows that they were coupled with."""
        self._pivots.append(pivot)
        graph, labels, zero = self.graph, self.labels, self.graph.zero
        for right in self.right:
            pivot.prepare(graph, right)
        around = list(pivot.across)
        for n, i in enumerate(around):
            row = self.neighbours[i]
            for j in around[n:]:
                lost = pivot.update(graph, i, j)
                if lost == zero:
                    continue
                if i == j:
                    entry = self.diagonal[i] = graph.sub(self.diagonal[i], lost)
                else:
                    entry = row[j] = self.neighbours[j][i] = graph.sub(row.get(j, zero), lost)
                labels.entry(entry, i, j, self.duals)
            for right in self.right:
                pivot.forward(graph, right, i)
            labels.sides(self.right, i)

    def _last_loop(self) -> tuple[int, int, int] | None:
        """Two coordinates and the constraint that closes a loop, where nothing else is left."""
        if len(self.neighbours) != 3:
            return None
        left = sorted(self.neighbours)
        if [i in self.duals for i in left] != [False, False, True]:
            return None
        i, j, c = left
        coupled = c in self.neighbours[i] and c in self.neighbours[j]
        return (i, j, c) if coupled and self.at(c, c) == self.graph.zero else None

    def _close_loop(self, i: int, j: int, c: int) -> None:
        graph, labels = self.graph, self.labels
        mul, sub = graph.mul, graph.sub
        a, b, d = self.at(i, i), self.at(i, j), self.at(j, j)
        u, v = self.at(i, c), self.at(j, c)
        minor_i, minor_j = sub(mul(d, u), mul(b, v)), sub(mul(a, v), mul(b, u))
        area = sub(mul(a, d), mul(b, b))
        form = graph.add(mul(u, minor_i), mul(v, minor_j))
        labels.step(f"Solve for {labels.titles(i, j)} and the multiplier of {labels.titles(c)}")
        if c in self.references:
            size = mul(area, self.references[c])
            self.checks.append(Check(form, size, c))
            labels.name(size, "limit", c)
        inverse = graph.div(graph.one, form)
        labels.pivot(form, inverse, c)
        labels.name(area, "det_M", i, j)
        labels.name(minor_i, "minor", i)
        labels.name(minor_j, "minor", j)
        self._loop.append(Loop(i, j, c, u, v, minor_i, minor_j, area, inverse))
