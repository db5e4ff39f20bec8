"""The orders of eliminations: of coordinates by constraints, and of pivots.

Constraints give coordinates in the order of least fill at every stage.

An entry of Φ_q that is a number, and not small beside the others of its row, gives a coordinate by
a constraint. The pair that fills in least comes first, then the longer row, then the smaller
number. Of one column the shortest row fills in least; so a heap a column and one heap of the
columns' best pairs find it in log n, however many rows a column has.

Pivots follow by the least work that they cause at every stage.

The costs of the candidates lie in heaps. A pivot changes the degrees of the unknowns that it was
coupled with, and so the costs of these and of the pairs that contain them; all others stay. A
machine whose rows keep a bounded number of entries is ordered in n log n. Ties go to the smaller
number, so that the order does not depend on how it is found.

From the leaves to the root a body goes as soon as one joint alone holds it: first the pairs of its
coordinates with this joint's constraints, then what is left of it, which no constraint couples any
longer. So a tree is eliminated as articulated bodies are (R. Featherstone, Rigid Body Dynamics
Algorithms, 2008, chapter 7), at the same cost for each body; loops follow as by substitution.

The cost of an elimination from the structure of its matrix, without a value built.

A large system is not eliminated by every order to find the cheapest one. A `Structure` does the
arithmetic of a graph on three kinds of values only: numbers, values of parameters alone, and those
that are known in a run. It counts the operations, and equal ones each time that they are asked for.
"""

from collections.abc import Iterable, Mapping, Sequence
from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING

from codegen.lower.graph import Graph
from codegen.lower.operation_count import WEIGHTS
from codegen.lower.program import Op

if TYPE_CHECKING:
    from codegen.lower.linear.factorization import Elimination, Strategy


LARGE = 200  # measured: unknowns from which on the cost of an order is estimated, not built


class CostExceededError(Exception):
    """An elimination costs more than the `limit` of its structure."""


class Structure(Graph):
    """A graph of two values beside numbers: one that parameters determine, and one that moves."""

    def __init__(self, limit: float = float("inf")) -> None:
        super().__init__()
        self.cost, self.limit = 0, limit
        self.parameter = self.input("p", 0, "")
        self.moving = self.input("q", 0, "")

    def kind(self, graph: Graph, value: int) -> int:
        """The value of this structure for one of a graph."""
        number = graph.floats[value]
        if number is not None:
            return self.constant(number)
        return self.parameter if graph.settled[value] else self.moving

    def kinds(self, graph: Graph, values: Sequence[int]) -> list[int]:
        """The values of this structure for those of a graph."""
        return [self.kind(graph, value) for value in values]

    def neg(self, a: int) -> int:
        """-a, which costs nothing."""
        number = self.floats[a]
        return a if number is None else self.constant(-number)

    def add(self, a: int, b: int) -> int:
        """The kind of a + b."""
        return self._moved(1) if a == b == self.moving else self._sum(a, b, 1)

    def sub(self, a: int, b: int) -> int:
        """The kind of a - b."""
        return self._moved(1) if a == b == self.moving else self._sum(a, b, -1)

    def _sum(self, a: int, b: int, sign: int) -> int:
        x, y = self.floats[a], self.floats[b]
        if x is not None and y is not None:
            return self.constant(x + sign * y)
        if y == 0.0:
            return a
        return b if x == 0.0 else self._operation(Op.ADD, a, b)

    def mul(self, a: int, b: int) -> int:
        """The kind of a b."""
        if a == b == self.moving:
            return self._moved(1)
        x, y = self.floats[a], self.floats[b]
        if x is not None and y is not None:
            return self.constant(x * y)
        if 0.0 in (x, y):
            return self.zero
        if x is not None and abs(x) == 1.0:
            return b
        if y is not None and abs(y) == 1.0:
            return a
        return self._operation(Op.MUL, a, b)

    def div(self, a: int, b: int) -> int:
        """The kind of a / b."""
        x, y = self.floats[a], self.floats[b]
        if x == 0.0:
            return self.zero
        if y is not None and y != 0.0:
            return self.mul(self.constant(1.0 / y), a)
        return self._operation(Op.DIV, a, b)

    def _operation(self, op: Op, a: int, b: int) -> int:
        """The kind of an operation's result, which adds to the cost unless parameters do."""
        if self.settled[a] and self.settled[b]:
            return self.parameter
        return self._moved(WEIGHTS.get(op, 1))

    def _moved(self, cost: int) -> int:
        """The kind of what is computed in a run, which adds to the cost."""
        self.cost += cost
        if self.cost > self.limit:
            raise CostExceededError
        return self.moving


LEAST_PIVOT = 0.1  # accuracy: part of the largest number in its row of Φ_q that a pivot must have

Row = dict[int, int]  # unknown → coefficient
_Key = tuple[int, int, int, int]  # fill, minus the row's length, row, column
DIVISION = 8  # measured: operations that one division is worth in the choice of an order
Pivot = tuple[int, ...]  # an unknown, or a coordinate and the constraint that gives it
Heap = list[tuple[tuple[int, int], Pivot]]  # of rank and cost, and the candidate


class CoordinateOrder:
    """The pairs (row, column) of an elimination by the fill that they cause."""

    def __init__(
        self, graph: Graph, rows: Mapping[int, Row], columns: Mapping[int, set[int]]
    ) -> None:
        self._graph, self._rows, self._columns = graph, rows, columns
        self._given: dict[int, set[int]] = {}  # row → coordinates that it gives
        self._shortest: dict[int, list[tuple[int, int]]] = {}  # column → heap of (length, row)
        self._best: dict[int, _Key] = {}  # column → its best pair; other entries of `_heap` are old
        self._heap: list[_Key] = []

    def renew(self, rows: Iterable[int], columns: Iterable[int]) -> None:
        """Note that rows have other entries, or are gone, and columns other rows."""
        changed = set(columns)
        for i in rows:
            self._given.pop(i, None)
            if i in self._rows:
                changed |= self._rows[i].keys()
                self._offer(i)
        for k in changed:
            self._renew_column(k)

    def first(self) -> tuple[int, int] | None:
        """Row and column of the pair that fills in least, if any is left."""
        while self._heap and self._best.get(self._heap[0][3]) != self._heap[0]:
            heappop(self._heap)
        return self._heap[0][2:] if self._heap else None

    def _offer(self, i: int) -> None:
        row = self._rows[i]
        sizes = {k: abs(self._graph.floats[entry] or 0.0) for k, entry in row.items()}
        least = LEAST_PIVOT * max(sizes.values(), default=0.0)
        self._given[i] = {k for k, size in sizes.items() if size > 0.0 and size >= least}
        for k in self._given[i]:
            heappush(self._shortest.setdefault(k, []), (len(row), i))

    def _renew_column(self, k: int) -> None:
        heap = self._shortest.get(k, [])
        while heap and not self._is_offered(*heap[0], k):
            heappop(heap)
        if not heap:
            self._best.pop(k, None)
            return
        length, i = heap[0]
        key = (length - 1) * (len(self._columns[k]) - 1), -length, i, k
        if self._best.get(k) != key:
            self._best[k] = key
            heappush(self._heap, key)

    def _is_offered(self, length: int, i: int, k: int) -> bool:
        return k in self._given.get(i, ()) and len(self._rows[i]) == length


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
