"""Sparse rows of Φ_q x = r, from which unknowns are eliminated one after the other.

An entry of Φ_q that is a number gives a coordinate by a constraint in every position: such pivots
come first, whichever way the rows that are left are solved.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from codegen.lower.graph import Graph
from codegen.lower.linear.labels import Labels
from codegen.lower.program import Check

LEAST_PIVOT = 0.1  # accuracy: part of the largest number in its row of Φ_q that a pivot must have
ROUNDING = 1e-12  # accuracy: a number below this part of the numbers it is a difference of is zero
SEARCHED = 30  # safety: rows among which small sets are searched for
Row = dict[int, int]  # unknown → coefficient


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

    def labels(self, names: Sequence[str]) -> Labels:
        """Names for a solution whose steps are called after coordinates or constraints."""
        return Labels(names, prefixed(self.stems, self.rows), self.unknowns)


class SparseRows:
    """The rows of a task, from which unknowns are eliminated."""

    def __init__(self, task: Task) -> None:
        self.task, self.graph, self.labels = task, task.graph, Labels()
        self.right = [list(column) for column in task.right]
        self.checks: list[Check] = []  # pivots to watch; the constraint of a check is a row
        self._rows: dict[int, Row] = {i: {} for i in range(len(self.right[0]))}
        for (i, k), entry in sorted(task.jacobian.items()):
            self._rows[i][k] = entry
        self._original = {i: dict(row) for i, row in self._rows.items()}
        self._eliminated: list[tuple[int, Row, list[int]]] = []

    def _explicit_coordinate(self) -> tuple[int, int] | None:
        """Row and column of the number whose elimination fills in least, if any is left."""
        counts = Counter(k for row in self._rows.values() for k in row)
        candidates = []
        for i, row in self._rows.items():
            sizes = {k: abs(self.graph.number(entry) or 0.0) for k, entry in row.items()}
            least = LEAST_PIVOT * max(sizes.values(), default=0.0)
            candidates += [
                ((len(row) - 1) * (counts[k] - 1), -len(row), i, k)
                for k, size in sizes.items()
                if size > 0.0 and size >= least
            ]
        return min(candidates)[2:] if candidates else None

    def _eliminate(self, k: int, coefficients: Row, right: list[int]) -> None:
        """Put x_k = right - Σ coefficient x into the rows."""
        graph = self.graph
        self._eliminated.append((k, coefficients, right))
        for i, row in self._rows.items():
            if k not in row:
                continue
            factor = row.pop(k)
            for j, coefficient in coefficients.items():
                before = row.pop(j, graph.zero)
                changed = graph.sub(before, graph.mul(factor, coefficient))
                number, was = graph.number(changed), graph.number(before)
                if number is None or abs(number) > ROUNDING * abs(was or 0.0):
                    row[j] = changed
                    self._name(changed, "Phi", i, j)
            for column, known in zip(self.right, right, strict=True):
                column[i] = graph.sub(column[i], graph.mul(factor, known))
            self.labels.sides(self.right, i)

    def _smallest_set(self, largest: int, surplus: range) -> tuple[int, ...] | None:
        """The fewest rows, `largest` at the most, with so many unknowns more than they are."""
        rows = tuple(self._rows)
        for size in range(1, largest + 1 if len(rows) <= SEARCHED else 2):
            for chosen in combinations(rows, size):
                if len(self._unknowns_of(chosen)) - size in surplus:
                    return chosen
        return None

    def _unknowns_of(self, chosen: tuple[int, ...]) -> list[int]:
        return sorted(set().union(*(self._rows[i] for i in chosen)))

    def _take(self, chosen: tuple[int, ...], columns: list[int]) -> list[list[int]]:
        """The dense matrix of rows, which leave the system."""
        rows = [self._rows.pop(i) for i in chosen]
        return [[row.get(k, self.graph.zero) for k in columns] for row in rows]

    def _name(self, value: int, stem: str, row: int, column: int) -> None:
        """Name an entry, where a solution does."""


def prefixed(stems: Sequence[str], names: Sequence[str]) -> list[list[str]]:
    """Each name with each stem before it."""
    return [[f"{stem}_{name}" for name in names] for stem in stems]
