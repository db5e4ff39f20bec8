"""The order of an elimination: the pivot that causes the least work at every stage.

The costs of the candidates lie in heaps. A pivot changes the degrees of the unknowns that it was
coupled with, and so the costs of these and of the pairs that contain them; all others stay. A
machine whose rows keep a bounded number of entries is ordered in n log n. Ties go to the smaller
number, so that the order does not depend on how it is found.

From the leaves to the root a body goes as soon as one joint alone holds it: first the pairs of its
coordinates with this joint's constraints, then what is left of it, which no constraint couples any
longer. So a tree is eliminated as articulated bodies are (R. Featherstone, Rigid Body Dynamics
Algorithms, 2008, chapter 7), at the same cost for each body; loops follow as by substitution.
"""

from collections.abc import Iterable
from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING

from codegen.lower.linear.coordinate_order import LEAST_PIVOT

if TYPE_CHECKING:
    from codegen.lower.linear.factorization import Elimination, Strategy

DIVISION = 8  # measured: operations that one division is worth in the choice of an order

Pivot = tuple[int, ...]  # an unknown, or a coordinate and the constraint that gives it
Heap = list[tuple[tuple[int, int], Pivot]]  # of rank and cost, and the candidate


class PivotOrder:
    """The candidates of an elimination by their costs."""

    def __init__(self, system: "Elimination", strategy: "Strategy") -> None:
        self._system, self._strategy = system, strategy
        self._costs: dict[
            Pivot, tuple[int, int]
        ] = {}  # rank and cost of the candidates; other entries of heaps are old
        self._by_row: dict[int, set[int]] = {}  # constraint → coordinates that it may give
        self._primals: Heap = []
        self._multipliers: Heap = []
        self._pairs: Heap = []
        self._bodies: dict[str, list[int]] = {}  # body → its coordinates
        if strategy == "leaves":
            for k, body in enumerate(system.owners):
                if k not in system.duals:
                    self._bodies.setdefault(body, []).append(k)
        self.renew((), system.neighbours)
        for heap in (self._primals, self._multipliers, self._pairs):
            heapify(heap)

    def cheapest(self) -> Pivot:
        """The pivot that causes the least work now, among those that the strategy prefers."""
        heaps = (self._primals, self._multipliers, self._pairs)
        return min(top for heap in heaps for top in self._top(heap))[1]

    def renew(self, gone: Iterable[int], changed: Iterable[int]) -> None:
        """Note that unknowns have left the system, and that the rows of others have changed."""
        gone, changed = tuple(gone), tuple(changed)
        duals, neighbours = self._system.duals, self._system.neighbours
        for u in gone:
            self._costs.pop((u,), None)
            for k in self._by_row.pop(u, ()):
                self._costs.pop((k, u), None)
        for i in changed:
            if i not in duals:
                self._offer(self._primals, (i,), self._single_rank(i), self._single_cost(i))
            elif duals.issuperset(neighbours[i]):
                self._offer(self._multipliers, (i,), self._single_rank(i), self._single_cost(i))
            else:
                self._costs.pop((i,), None)
        if self._strategy == "schur":
            return
        for i in changed:
            if i in duals:
                self._renew_row(i)
        for i in self._of_bodies(gone, changed):
            for c in duals.intersection(neighbours[i]):
                if (i, c) in self._costs:
                    self._offer_pair(i, c)

    def _of_bodies(self, gone: Iterable[int], changed: Iterable[int]) -> Iterable[int]:
        """The coordinates whose pairs may have other ranks or costs."""
        system = self._system
        primals = [i for i in changed if i not in system.duals]
        if self._strategy != "leaves":
            return primals
        owners = {system.owners[i] for i in (*gone, *primals) if i not in system.duals}
        alike = (k for body in owners for k in self._bodies[body] if k in system.neighbours)
        return sorted(alike)

    def _renew_row(self, c: int) -> None:
        """Offer the coordinates that a constraint gives, with its row as it is now."""
        given = self._given(c)
        for k in self._by_row.get(c, set()) - given:
            self._costs.pop((k, c), None)
        self._by_row[c] = given
        for k in given:
            self._offer_pair(k, c)

    def _given(self, c: int) -> set[int]:
        """Coordinates with a number in the row of a constraint that no pivot has touched yet."""
        system = self._system
        if system.diagonal[c] != system.graph.zero:
            return set()
        duals, floats = system.duals, system.graph.floats
        sizes = {j: abs(floats[entry] or 0.0) for j, entry in system.neighbours[c].items()}
        least = LEAST_PIVOT * max(sizes.values(), default=0.0)
        return {k for k, size in sizes.items() if size > 0.0 and size >= least and k not in duals}

    def _offer_pair(self, k: int, c: int) -> None:
        self._offer(self._pairs, (k, c), self._pair_rank(k), self._pair_cost(k, c))

    def _offer(self, heap: Heap, pivot: Pivot, rank: int, cost: int) -> None:
        """Set the rank and the cost of a candidate."""
        if self._costs.get(pivot) != (rank, cost):
            self._costs[pivot] = rank, cost
            heappush(heap, ((rank, cost), pivot))

    def _top(self, heap: Heap) -> Heap:
        """The first entry of a heap that is not old, if there is one."""
        while heap and self._costs.get(heap[0][1]) != heap[0][0]:
            heappop(heap)
        return heap[:1]

    def _single_rank(self, i: int) -> int:
        """Smaller ranks go first: how much a strategy prefers an unknown."""
        system = self._system
        match self._strategy:
            case "substitute":
                return 1
            case "schur":
                return int(i in system.duals)
            case "leaves":
                free = i not in system.duals and system.duals.isdisjoint(system.neighbours[i])
                return 0 if free else 3
        return 0

    def _pair_rank(self, k: int) -> int:
        """The same of a pair: a leaf of a tree is a body that one joint holds."""
        if self._strategy != "leaves":
            return 0
        system = self._system
        left = [j for j in self._bodies[system.owners[k]] if j in system.neighbours]
        constraints = system.duals.intersection(c for j in left for c in system.neighbours[j])
        return 1 if len({system.owners[c] for c in constraints}) == 1 else 2

    def _single_cost(self, i: int) -> int:
        degree = len(self._system.neighbours[i])
        division = 0 if self._system.graph.settled[self._system.diagonal[i]] else DIVISION
        return division + degree * (degree + 3) // 2

    def _pair_cost(self, k: int, c: int) -> int:
        system = self._system
        along, across = len(system.neighbours[k]) - 1, len(system.neighbours[c]) - 1
        mass = 0 if system.diagonal[k] == system.graph.zero else across * (across + 1) // 2
        return across * along + mass + along + across
