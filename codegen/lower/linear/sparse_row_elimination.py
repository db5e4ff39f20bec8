"""Sparse rows of Φ_q x = r, from which unknowns are eliminated one after the other.

An entry of Φ_q that is a number gives a coordinate by a constraint in every position: such pivots
come first, whichever way the rows that are left are solved.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush
from itertools import combinations

from codegen.lower.graph import Graph
from codegen.lower.linear.elimination_order import LARGE, CoordinateOrder, Row, Structure
from codegen.lower.program import Check, Labels

ROUNDING = 1e-12  # accuracy: a difference below this part of its operands is zero
SEARCHED = 30  # safety: rows among which small sets are searched for


@dataclass(frozen=True)
class Task:
    """Φ_q d = r for several r, d least in the norm dᵀ W⁻¹ d; names for the text, if any."""

    graph: Graph
    jacobian: dict[tuple[int, int], int]  # (row, column) → value, structural non-zeros of Φ_q
    right: list[list[int]]  # one list of rows a right side
    weights: Sequence[int] = ()  # one a column
    columns: Sequence[str] = ()  # names of the coordinates
    rows: Sequence[str] = ()  # names of the constraints
    stems: Sequence[str] = ()  # how names of each right side begin
    unknowns: Sequence[Sequence[str]] = ()  # names of each solution's entries
    # where W is no diagonal: column → its row of W; unknown → its row of what gives it from Φ_qᵀ μ
    blocks: Mapping[int, Row] = field(default_factory=dict)
    changes: Mapping[int, Row] = field(default_factory=dict)

    def labels(self, names: Sequence[str]) -> Labels:
        """Names for a solution whose steps are called after coordinates or constraints."""
        return Labels(names, prefixed(self.stems, self.rows), self.unknowns)


def is_large(task: Task) -> bool:
    """Whether a task is so large that its ways are compared by structure."""
    return len(task.right[0]) + len(task.weights) >= LARGE


def structure_of(task: Task) -> Task:
    """The task without names in a structure, which shows whether a way leads to a solution."""
    structure, graph = Structure(), task.graph
    jacobian = {place: structure.kind(graph, value) for place, value in task.jacobian.items()}
    right = [structure.kinds(graph, column) for column in task.right]
    return Task(structure, jacobian, right, structure.kinds(graph, task.weights))


class SparseRows:
    """The rows of a task, from which unknowns are eliminated."""

    def __init__(self, task: Task) -> None:
        self.task, self.graph, self.labels = task, task.graph, Labels()
        self.right = [list(column) for column in task.right]
        self.checks: list[Check] = []  # pivots to watch; the constraint of a check is a row
        self._rows: dict[int, Row] = {i: {} for i in range(len(self.right[0]))}
        for (i, k), entry in sorted(task.jacobian.items()):
            self._rows[i][k] = entry
        self._columns: dict[int, set[int]] = {}  # unknown → the rows that contain it
        for i, row in self._rows.items():
            for k in row:
                self._columns.setdefault(k, set()).add(i)
        self._original = {i: dict(row) for i, row in self._rows.items()}
        self._eliminated: list[tuple[int, Row, list[int]]] = []
        self._order = CoordinateOrder(self.graph, self._rows, self._columns)
        # rows and columns that changed since the order was asked last, and a heap of rows that
        # changed since they were looked at
        self._changed, self._changed_columns = set(self._rows), set[int]()
        self._unseen = list(self._rows)

    def _explicit_coordinate(self) -> tuple[int, int] | None:
        """Row and column of the number whose elimination fills in least, if any is left."""
        self._order.renew(self._changed, self._changed_columns)
        self._changed, self._changed_columns = set(), set()
        return self._order.first()

    def _remove(self, i: int) -> Row:
        """A row, which leaves the system."""
        row = self._rows.pop(i)
        self._changed.add(i)
        for k in row:
            self._columns[k].discard(i)
            self._changed_columns.add(k)
        return row

    def _eliminate(self, k: int, coefficients: Row, right: list[int]) -> None:
        """Put x_k = right - Σ coefficient x into the rows."""
        graph = self.graph
        self._eliminated.append((k, coefficients, right))
        for i in sorted(self._columns.pop(k, ())):
            row = self._rows[i]
            factor = row.pop(k)
            for j, coefficient in coefficients.items():
                before = row.pop(j, graph.zero)
                changed = graph.sub(before, graph.mul(factor, coefficient))
                number, was = graph.number(changed), graph.number(before)
                around = self._columns.setdefault(j, set())
                if number is None or abs(number) > ROUNDING * abs(was or 0.0):
                    row[j] = changed
                    around.add(i)
                    self._name(changed, "Phi", i, j)
                else:
                    around.discard(i)
                self._changed_columns.add(j)
            self._changed.add(i)
            heappush(self._unseen, i)
            for column, known in zip(self.right, right, strict=True):
                column[i] = graph.sub(column[i], graph.mul(factor, known))
            self.labels.sides(self.right, i)

    def _first_row(self, holds: Callable[[Row], bool]) -> int | None:
        """The first row for which `holds`, a question of the row alone, the same in all calls."""
        while self._unseen:
            i = self._unseen[0]
            if i in self._rows and holds(self._rows[i]):
                return i
            heappop(self._unseen)
        return None

    def _smallest_set(self, largest: int, surplus: range) -> tuple[int, ...] | None:
        """The fewest rows, `largest` at the most, with so many unknowns more than they are."""
        first = self._first_row(lambda row: len(row) - 1 in surplus)
        if first is not None:
            return (first,)
        rows = tuple(self._rows)
        for size in range(2, largest + 1 if len(rows) <= SEARCHED else 2):
            for chosen in combinations(rows, size):
                if len(self._unknowns_of(chosen)) - size in surplus:
                    return chosen
        return None

    def _unknowns_of(self, chosen: tuple[int, ...]) -> list[int]:
        return sorted(set().union(*(self._rows[i] for i in chosen)))

    def _take(self, chosen: tuple[int, ...], columns: list[int]) -> list[list[int]]:
        """The dense matrix of rows, which leave the system."""
        rows = [self._remove(i) for i in chosen]
        return [[row.get(k, self.graph.zero) for k in columns] for row in rows]

    def _name(self, value: int, stem: str, row: int, column: int) -> None:
        """Name an entry, where a solution does."""


def prefixed(stems: Sequence[str], names: Sequence[str]) -> list[list[str]]:
    """Each name with each stem before it."""
    return [[f"{stem}_{name}" for name in names] for stem in stems]
