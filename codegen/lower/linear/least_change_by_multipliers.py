"""The least change by the multipliers of the constraints: d = W Φ_qᵀ μ with Φ_q W Φ_qᵀ μ = r."""

from collections.abc import Mapping, Sequence

from codegen.lower.graph import Graph
from codegen.lower.linear.coordinate_order import Row
from codegen.lower.linear.factorization import Elimination
from codegen.lower.linear.labels import Labels
from codegen.lower.linear.sparse_row_elimination import SparseRows, prefixed
from codegen.lower.program import Check


class NormalEquations(SparseRows):
    """The least change by multipliers."""

    def solve(self) -> list[list[int]]:
        """The changes, one list a right side."""
        graph, task = self.graph, self.task
        while (i := self._first_row(self._determines)) is not None:
            ((k, number),) = self._remove(i).items()  # the weights do not matter there
            self.checks.append(Check(task.weights[k], graph.zero, i))
            self._eliminate(k, {}, [graph.div(column[i], number) for column in self.right])
        left = list(self._rows)
        names = [task.rows[i] for i in left]
        multipliers = [stem.replace("rhs", "mu") for stem in task.stems]
        sides, unknowns = prefixed(task.stems, names), prefixed(multipliers, names)
        self.labels = Labels(names, sides, unknowns, "S")
        self.labels.step("The matrix and the right sides")
        right = [[column[i] for i in left] for column in self.right]
        weights = dict(enumerate(task.weights))
        matrix = [self._rows[i] for i in left]
        solved, checks = solve_by_multipliers(graph, matrix, weights, right, self.labels)
        self.checks += [check._replace(constraint=left[check.constraint]) for check in checks]
        changes = []
        for column, sums in enumerate(solved):
            sums |= {k: right[column] for k, _, right in self._eliminated}
            changes.append([sums.get(k, graph.zero) for k in weights])
        return changes

    def _determines(self, row: Row) -> bool:
        """Whether a row has one unknown and a number in front of it."""
        return len(row) == 1 and all(self.graph.floats[entry] is not None for entry in row.values())


def solve_by_multipliers(
    graph: Graph, rows: Sequence[Row], weights: Mapping[int, int], right: list[list[int]],
    labels: Labels,
) -> tuple[list[Row], list[Check]]:  # fmt: skip
    """x = W Aᵀ μ, A W Aᵀ μ = r, with positive pivots in any position that is not singular.

    Returns column → value, one a right side, and the pivots to watch, by the number of the row.
    """
    entries: dict[tuple[int, int], int] = {}
    users: dict[int, list[int]] = {}  # column → rows that contain it
    for a, row in enumerate(rows):
        for k in row:
            users.setdefault(k, []).append(a)
    for a, row in enumerate(rows):
        weighted: Row = {}  # by column, once it is needed
        for b in sorted({a, *(b for k in row for b in users[k] if b > a)}):
            other, terms = rows[b], []
            for k, x in row.items():
                if k in other:
                    if k not in weighted:
                        weighted[k] = graph.mul(x, weights[k])
                    terms.append(graph.mul(weighted[k], other[k]))
            entries[a, b] = entries[b, a] = graph.total(terms)
            labels.entry(entries[a, b], a, b)
    references = {a: entries[a, a] for a in range(len(rows))}
    for a in range(len(rows)):
        labels.sides(right, a)
    system = Elimination(graph, entries, right, references=references, labels=labels)
    multipliers = system.solve("schur")
    labels.step("W Φ_qᵀ μ")
    solutions = []
    for column in multipliers:
        sums: Row = {}
        for row, mu in zip(rows, column, strict=True):
            for k, entry in row.items():
                sums[k] = graph.add(sums.get(k, graph.zero), graph.mul(entry, mu))
        solutions.append({k: graph.mul(weights[k], pull) for k, pull in sums.items()})
    return solutions, system.checks
