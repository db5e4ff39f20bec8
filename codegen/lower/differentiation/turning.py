"""The rotation of a body in space as values of a graph, with its derivatives by turns.

The nine entries of A are leaves of differentiation. A turn δπ' about the body's own axes changes
them by ∂A/∂π'_k = A ẽ_k, a signed swap of columns that costs nothing, as sin' = cos does in the
plane; along the motion Ȧ = A ω̃' and, without accelerations, Ä = A ω̃' ω̃'.

The same holds by turns δπ about global axes, ∂A/∂π_k = ẽ_k A, Ȧ = ω̃ A and ω = 2 E ṗ. There the
slopes of a turned vector A a' are its own components, of either sign, and Φ_p = 2 Φ_π E, so that
the columns of p cost less; the axes of the body cost less where ω' and Φ_π' are needed as well.

The Euler parameters themselves bend, too: p̈ = ½ Gᵀ ω̇' - (ṗᵀṗ) p, whose second term belongs to the
motion without accelerations. So equations that a user writes in e0 ... e3 are differentiated by the
same walk, and with Φ_π' = ½ Φ_p Gᵀ they have the columns of all others.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from functools import cached_property, partial
from typing import Any

from codegen.declare.rotation_entries import E, G
from codegen.lower.differentiation.derivative_along_motion import (
    PLAIN,
    Direction,
    Factors,
    Jet,
    Parts,
)
from codegen.lower.graph import Graph
from codegen.lower.program import dependencies

THREE = range(3)


def rotation_entry(graph: Graph, i: int, k: int, p: Sequence[int]) -> int:
    """A_ik."""
    double = [graph.mul(graph.constant(2.0), e) for e in p]

    def product(a: int, b: int) -> int:
        return graph.mul(double[min(a, b)], p[max(a, b)])

    if i == k:
        return graph.add(graph.sub(product(0, 0), graph.one), product(i + 1, i + 1))
    combine = graph.add if (i - k) % 3 == 1 else graph.sub
    return combine(product(i + 1, k + 1), product(0, 4 - i - k))


def spin_entry(graph: Graph, k: int, p: Sequence[int], rates: Sequence[int]) -> int:
    """ω'_k = 2 (G ṗ)_k."""
    return along_g(graph, k, [graph.mul(graph.constant(2.0), e) for e in p], rates)


def along_g(graph: Graph, k: int, p: Sequence[int], values: Sequence[int], matrix: Any = G) -> int:
    """Row k of G(p) or E(p), times values."""
    total = graph.zero
    for (sign, j), value in zip(matrix[k], values, strict=True):
        combine = graph.add if sign > 0 else graph.sub
        total = combine(total, graph.mul(p[j], value))
    return total


def across_g(graph: Graph, p: Sequence[int], values: Sequence[int], matrix: Any = G) -> list[int]:
    """Gᵀ(p) or Eᵀ(p), times three values: four."""
    totals = []
    for column in range(4):
        total = graph.zero
        for row, value in zip(matrix, values, strict=True):
            sign, j = row[column]
            combine = graph.add if sign > 0 else graph.sub
            total = combine(total, graph.mul(p[j], value))
        totals.append(total)
    return totals


class Turn:
    """The rotation of one body; its Euler parameters are the coordinates from `first` on."""

    def __init__(self, graph: Graph, number: int, first: int, q: list[int], v: list[int]) -> None:
        self.graph, self.first = graph, first
        self.p, self.rates = q[first : first + 4], v[first : first + 4]
        self.entries = [[rotation_entry(graph, i, k, self.p) for k in THREE] for i in THREE]
        self.omega = [spin_entry(graph, k, self.p, self.rates) for k in THREE]
        # the directions δπ', which stand for the columns of slopes and have no value
        self.axes = tuple(graph.input("turn", 3 * number + k, f"turn_{number}_{k}") for k in THREE)
        for entry in (e for row in self.entries for e in row):
            graph.count_as_moved_by(entry, self.axes[0])

    @cached_property
    def double(self) -> list[int]:
        """2 p."""
        return [self.graph.mul(self.graph.constant(2.0), e) for e in self.p]

    @cached_property
    def square(self) -> int:
        """ṗᵀṗ."""
        return self.graph.dot(self.rates, self.rates)

    def along_axis(self, k: int, *, in_ground: bool = False) -> Direction:
        """The direction of a turn about the body's axis k, or the global one."""
        slopes = dict[int, int]()
        for line, axis, after, before in self._lines(in_ground):
            if axis == k:
                slopes |= {line[after]: line[before], line[before]: self.graph.neg(line[after])}
        return Direction(self.graph, slopes, order=1)

    def _lines(self, in_ground: bool) -> Iterator[tuple[Sequence[int], int, int, int]]:
        """Rows of A, each axis and those after and before it; of Aᵀ, which turns by -ω, back."""
        for line in zip(*self.entries, strict=True) if in_ground else self.entries:
            for k in THREE:
                after, before = (k + 1) % 3, (k + 2) % 3
                yield (line, k, before, after) if in_ground else (line, k, after, before)

    def jets(self, *, in_ground: bool = False) -> dict[int, Jet]:
        """Derivatives of A and p along the motion, without accelerations, by ω' or by ω."""
        graph, jets, omega = self.graph, dict[int, Jet](), self.omega
        if in_ground:
            omega = [along_g(graph, k, self.double, self.rates, E) for k in THREE]
        spins = [[graph.mul(a, b) for b in omega] for a in omega]
        for line, k, after, before in self._lines(in_ground):
            first: dict[Factors, int] = {
                (1.0, (omega[before],)): line[after],
                (1.0, (graph.neg(omega[after]),)): line[before],
            }
            both = graph.neg(graph.add(spins[after][after], spins[before][before]))
            second: dict[Factors, int] = {(1.0, (both,)): line[k]}
            for j in (after, before):
                second[1.0, (spins[min(j, k)][max(j, k)],)] = line[j]
            jets[line[k]] = Jet(Parts(graph, first), Parts(graph, second))
        for e, rate in zip(self.p, self.rates, strict=True):
            bend = Parts(graph, {PLAIN: graph.neg(graph.mul(self.square, e))})
            jets[e] = Jet(Parts(graph, {PLAIN: rate}), bend)
        return jets

    def seven(self, values: Sequence[int], matrix: Any = G) -> list[int]:
        """Slopes or forces by p, from those by π' or, with E, by π: 2 Gᵀ times them."""
        return across_g(self.graph, self.double, values, matrix)

    def six(self, values: Sequence[int], matrix: Any = G) -> list[int]:
        """Slopes or forces by π' or, with E, by π, from those by p: ½ G times them."""
        half = [self.graph.mul(self.graph.constant(0.5), value) for value in values]
        return [along_g(self.graph, k, self.p, half, matrix) for k in THREE]

    def acceleration(self, values: Sequence[int], is_change: bool = False) -> list[int]:
        """p̈ = ½ Gᵀ ω̇' - (ṗᵀṗ) p; without its last term, a change of p̈."""
        graph = self.graph
        half = [graph.mul(graph.constant(0.5), value) for value in values]
        turned = across_g(graph, self.p, half)
        if is_change:
            return turned
        bends = [graph.mul(self.square, e) for e in self.p]
        return [graph.sub(a, b) for a, b in zip(turned, bends, strict=True)]


def jets_of(turns: Sequence[Turn], *, in_ground: bool) -> dict[int, Jet]:
    """The derivatives of all bodies' A and p along the motion."""
    return {v: jet for turn in turns for v, jet in turn.jets(in_ground=in_ground).items()}


Entries = dict[tuple[int, int], int]
Row = dict[int, int]
"""Column → value, where it is not zero."""


class TurningColumns:
    """The columns of coordinates, seven a body in space, and those of motion, six a body.

    Behind the n columns of coordinates stand three for the turns of each body.
    """

    def __init__(self, graph: Graph, turns: Sequence[Turn], n: int) -> None:
        self.graph, self.turns = graph, [(turn, n + 3 * k) for k, turn in enumerate(turns)]

    def of_motion(self, columns: int) -> list[int]:
        """The columns of motion: a turn's in place of its Euler parameters, all others as is."""
        starts = {turn.first: at for turn, at in self.turns}
        inner = {turn.first + k for turn, _ in self.turns for k in range(4)}
        found = list[int]()
        for k in range(columns):
            found += range(starts[k], starts[k] + 3) if k in starts else [] if k in inner else [k]
        return found

    def six(self, row: Row, matrix: Any = G) -> Row:
        """A row of slopes or forces in the columns of motion."""
        for turn, at in self.turns:
            given = [row.get(turn.first + k, self.graph.zero) for k in range(4)]
            row = self._moved(row, turn.first, given, at, partial(turn.six, matrix=matrix))
        return row

    def seven(self, row: Row, matrix: Any = G) -> Row:
        """A row of slopes or forces in the columns of coordinates."""
        for turn, at in self.turns:
            given = [row.get(at + k, self.graph.zero) for k in THREE]
            row = self._moved(row, at, given, turn.first, partial(turn.seven, matrix=matrix))
        return row

    def gammas(self, bends: list[list[int]], turned: Entries) -> tuple[list[int], list[int]]:
        """γ by the way of turning that needs the fewest values, alone, and beside Φ_π' and ω'."""
        values, ways = self.graph.values, list(map(list, zip(*bends, strict=True))) or [[]]
        beside = [*turned.values(), *(w for turn, _ in self.turns for w in turn.omega)]
        alone = min(ways, key=lambda way: len(dependencies(values, way)))
        return alone, min(ways, key=lambda way: len(dependencies(values, [*way, *beside])))

    def by_coordinates(self, row: Row) -> Row:
        """A row of slopes by global turns and coordinates in the columns of coordinates."""
        return self.seven(self.six(row, E), E)

    def jacobian(self, entries: Entries, turned: Entries, norms: Collection[int]) -> Entries:
        """Φ_q from the turned Jacobian, whose values are there where accelerations are."""
        if not self.turns:
            return entries
        rows: dict[int, Row] = {i: {} for i, _ in sorted(entries)}
        kept = (pair for pair in entries.items() if pair[0][0] in norms)
        for (i, k), slope in (*kept, *turned.items()):
            rows[i][k] = slope
        return {(i, k): x for i, row in rows.items() for k, x in self.seven(row).items()}

    def _moved(
        self, row: Row, first: int, given: list[int], to: int,
        converted: Callable[[Sequence[int]], list[int]],
    ) -> Row:  # fmt: skip
        """The row with what is given from column `first` on converted and added from `to` on."""
        if all(value == self.graph.zero for value in given):
            return row
        moved = {k: value for k, value in row.items() if not first <= k < first + len(given)}
        for k, value in enumerate(converted(given), to):
            moved[k] = self.graph.add(moved.get(k, self.graph.zero), value)
        return {k: moved[k] for k in sorted(moved) if moved[k] != self.graph.zero}
