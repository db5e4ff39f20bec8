"""The rotation of a body in space as values of a graph, with its derivatives by turns.

The nine entries of A are leaves of differentiation. A turn δπ' about the body's own axes changes
them by ∂A/∂π'_k = A ẽ_k, a signed swap of columns that costs nothing, as sin' = cos does in the
plane; along the motion Ȧ = A ω̃' and, without accelerations, Ä = A ω̃' ω̃'.

The Euler parameters themselves bend, too: p̈ = ½ Gᵀ ω̇' - (ṗᵀṗ) p, whose second term belongs to the
motion without accelerations. So equations that a user writes in e0 ... e3 are differentiated by the
same walk, and with Φ_π' = ½ Φ_p Gᵀ they have the columns of all others.
"""

from collections.abc import Callable, Sequence
from functools import cached_property

from codegen.declare.rotation_entries import G
from codegen.lower.differentiation.derivative_along_motion import (
    PLAIN,
    Direction,
    Factors,
    Jet,
    Parts,
)
from codegen.lower.graph import Graph

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


def along_g(graph: Graph, k: int, p: Sequence[int], values: Sequence[int]) -> int:
    """Row k of G(p), times values."""
    total = graph.zero
    for (sign, j), value in zip(G[k], values, strict=True):
        combine = graph.add if sign > 0 else graph.sub
        total = combine(total, graph.mul(p[j], value))
    return total


def across_g(graph: Graph, p: Sequence[int], values: Sequence[int]) -> list[int]:
    """Gᵀ(p), times three values: four."""
    totals = []
    for column in range(4):
        total = graph.zero
        for row, value in zip(G, values, strict=True):
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

    def along_axis(self, k: int) -> Direction:
        """The direction of a turn about the body's axis k."""
        after, before = (k + 1) % 3, (k + 2) % 3
        slopes = dict[int, int]()
        for row in self.entries:
            slopes |= {row[after]: row[before], row[before]: self.graph.neg(row[after])}
        return Direction(self.graph, slopes, order=1)

    def jets(self) -> dict[int, Jet]:
        """Derivatives of A and p along the motion, without accelerations."""
        graph, jets = self.graph, dict[int, Jet]()
        spins = [[graph.mul(a, b) for b in self.omega] for a in self.omega]
        for row in self.entries:
            for k in THREE:
                after, before = (k + 1) % 3, (k + 2) % 3
                first: dict[Factors, int] = {
                    (1.0, (self.omega[before],)): row[after],
                    (1.0, (self.omega[after],)): graph.neg(row[before]),
                }
                both = graph.add(spins[after][after], spins[before][before])
                second: dict[Factors, int] = {(1.0, (both,)): graph.neg(row[k])}
                for j in (after, before):
                    second[1.0, (spins[min(j, k)][max(j, k)],)] = row[j]
                jets[row[k]] = Jet(Parts(graph, first), Parts(graph, second))
        for e, rate in zip(self.p, self.rates, strict=True):
            bend = Parts(graph, {PLAIN: graph.neg(graph.mul(self.square, e))})
            jets[e] = Jet(Parts(graph, {PLAIN: rate}), bend)
        return jets

    def seven(self, values: Sequence[int]) -> list[int]:
        """Slopes or forces by p, from those by π': 2 Gᵀ times them."""
        return across_g(self.graph, self.double, values)

    def six(self, values: Sequence[int]) -> list[int]:
        """Slopes or forces by π', from those by p: ½ G times them."""
        half = [self.graph.mul(self.graph.constant(0.5), value) for value in values]
        return [along_g(self.graph, k, self.p, half) for k in THREE]

    def acceleration(self, values: Sequence[int], is_change: bool = False) -> list[int]:
        """p̈ = ½ Gᵀ ω̇' - (ṗᵀṗ) p; without its last term, a change of p̈."""
        graph = self.graph
        half = [graph.mul(graph.constant(0.5), value) for value in values]
        turned = across_g(graph, self.p, half)
        if is_change:
            return turned
        bends = [graph.mul(self.square, e) for e in self.p]
        return [graph.sub(a, b) for a, b in zip(turned, bends, strict=True)]


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

    def six(self, row: Row) -> Row:
        """A row of slopes or forces in the columns of motion."""
        for turn, at in self.turns:
            given = [row.get(turn.first + k, self.graph.zero) for k in range(4)]
            row = self._moved(row, turn.first, given, at, turn.six)
        return row

    def seven(self, row: Row) -> Row:
        """A row of slopes or forces in the columns of coordinates."""
        for turn, at in self.turns:
            given = [row.get(at + k, self.graph.zero) for k in THREE]
            row = self._moved(row, at, given, turn.first, turn.seven)
        return row

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
