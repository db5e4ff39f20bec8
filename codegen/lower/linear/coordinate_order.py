"""The order in which constraints give coordinates: the least fill at every stage.

An entry of Φ_q that is a number, and not small beside the others of its row, gives a coordinate by
a constraint. The pair that fills in least comes first, then the longer row, then the smaller
number. Of one column the shortest row fills in least; so a heap a column and one heap of the
columns' best pairs find it in log n, however many rows a column has.
"""

from collections.abc import Iterable, Mapping
from heapq import heappop, heappush

from codegen.lower.graph import Graph

LEAST_PIVOT = 0.1  # accuracy: part of the largest number in its row of Φ_q that a pivot must have

Row = dict[int, int]  # unknown → coefficient
_Key = tuple[int, int, int, int]  # fill, minus the row's length, row, column


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
