"""The linear systems of a driven machine: as many independent constraints as coordinates.

Φ_q x = r has one solution, whatever a norm says of it. Many constraints give a coordinate outright,
by a number in Φ_q: these are eliminated first, and the factorization shrinks to the loops, of which
few are left. There the smallest sets of rows with as many unknowns are solved one after the other,
up to three rows by their adjugate, larger ones by the normal equations of what is left. Where the
determinant of such a set vanishes the machine is in a singular position: det² is held against the
product of the rows' squares, as the pivots of Φ_q Φ_qᵀ are against its diagonal.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations

from codegen.lower.graph import Graph
from codegen.lower.linear.factorization import Elimination
from codegen.lower.linear.labels import Labels
from codegen.lower.linear.pivots import explicit_coordinate
from codegen.lower.program import Check

LARGEST = 3
"""measured: rows of the largest set that is solved by its adjugate."""

ROUNDING = 1e-12
"""accuracy: a number below this part of the numbers it is a difference of is zero."""

SHARPER = 1e-6
"""accuracy: part of the product of the rows' squares that det² is compared with."""

SEARCHED = 30
"""safety: rows among which such sets are searched for; more are solved together."""


@dataclass
class Square:
    """A square sparse system of graph values, for several right sides.

    Attributes
    ----------
    entries
        (row, column) → value, structural non-zeros only.
    right
        Right sides, one list of rows each.
    labels, coordinates
        Names for the text, of rows and of the unknowns.
    checks
        What is held against its size; the constraint of a check is a row.
    """

    graph: Graph
    entries: dict[tuple[int, int], int]
    right: list[list[int]]
    labels: Labels = field(default_factory=Labels)
    coordinates: Sequence[str] = ()
    checks: list[Check] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self.right = [list(column) for column in self.right]
        self._rows: dict[int, dict[int, int]] = {i: {} for i in range(len(self.right[0]))}
        for (i, k), entry in sorted(self.entries.items()):
            self._rows[i][k] = entry
        self._original = {i: tuple(row.values()) for i, row in self._rows.items()}
        self._eliminated: list[tuple[int, dict[int, int], list[int]]] = []

    def solve(self) -> list[list[int]] | None:
        """The unknowns, one list a right side; None where no position determines them all."""
        while pivot := explicit_coordinate(self.graph, self._rows):
            self._substitute(*pivot)
        x: list[dict[int, int]] = [{} for _ in self.right]
        while self._rows:
            chosen = self._smallest_set()
            if len(self._columns(chosen)) != len(chosen):
                return None
            self._solve_set(chosen, x)
        self.labels.step("Substitute back")
        for k, row, right in reversed(self._eliminated):
            for known, start in zip(x, right, strict=True):
                known[k] = self._less(start, row, known)
        solutions = [[known[k] for k in range(len(known))] for known in x]
        self.labels.solved(solutions)
        return solutions

    def _less(self, start: int, row: dict[int, int], known: dict[int, int]) -> int:
        for j, factor in row.items():
            start = self.graph.sub(start, self.graph.mul(factor, known[j]))
        return start

    # -- what a constraint gives outright ----------------------------------------------------

    def _substitute(self, i: int, k: int) -> None:
        graph = self.graph
        row = self._rows.pop(i)
        pivot = row.pop(k)
        inverse = graph.div(graph.one, pivot)
        self._step([i], [k])
        self.labels.pivot(pivot, inverse, i)
        coefficients = {j: graph.mul(inverse, entry) for j, entry in row.items()}
        for j, entry in coefficients.items():
            self._name(entry, "L", i, j)
        right = [graph.mul(inverse, column[i]) for column in self.right]
        for other, entries in self._rows.items():
            if k not in entries:
                continue
            factor = entries.pop(k)
            for j, entry in coefficients.items():
                before, product = entries.pop(j, graph.zero), graph.mul(factor, entry)
                changed = graph.sub(before, product)
                if not self._nothing(changed, before):
                    entries[j] = changed
                    self._name(changed, "Phi", other, j)
            for column, known in zip(self.right, right, strict=True):
                column[other] = graph.sub(column[other], graph.mul(factor, known))
            self.labels.sides(self.right, other)
        self._eliminated.append((k, coefficients, right))

    def _step(self, rows: Sequence[int], columns: Sequence[int]) -> None:
        if self.coordinates:
            unknowns = ", ".join(self.coordinates[k] for k in columns)
            self.labels.step(f"Solve {self.labels.titles(*rows)} for {unknowns}")

    def _name(self, value: int, stem: str, row: int, column: int) -> None:
        if self.coordinates:
            self.labels.add(value, f"{self.labels.of(stem, row)}_{self.coordinates[column]}")

    def _nothing(self, entry: int, before: int) -> bool:
        """Whether an entry is zero, or a number that only rounding has left of another."""
        number, was = self.graph.number(entry), self.graph.number(before)
        if number is None:
            return False
        return abs(number) <= ROUNDING * abs(was or 0.0)

    # -- loops -------------------------------------------------------------------------------

    def _smallest_set(self) -> tuple[int, ...]:
        """Rows with as many unknowns, as few of them as there are."""
        rows = tuple(self._rows)
        for size in range(1, LARGEST + 1 if len(rows) <= SEARCHED else 2):
            for chosen in combinations(rows, size):
                if len(self._columns(chosen)) <= size:
                    return chosen
        return rows

    def _columns(self, chosen: tuple[int, ...]) -> list[int]:
        """The unknowns of rows."""
        return sorted(set().union(*(self._rows[i] for i in chosen)))

    def _solve_set(self, chosen: tuple[int, ...], x: list[dict[int, int]]) -> None:
        """Solve the rows for their unknowns, and take these out of the other rows."""
        graph = self.graph
        columns = self._columns(chosen)
        self._step(chosen, columns)
        matrix = [[self._rows[i].get(k, graph.zero) for k in columns] for i in chosen]
        right = [[column[i] for i in chosen] for column in self.right]
        if len(chosen) <= LARGEST:
            solutions = self._by_adjugate(chosen, matrix, right)
        else:
            solutions = self._by_normal_equations(chosen, matrix, right)
        for names, values in zip(self.labels.solution, solutions, strict=False):
            for k, value in zip(columns, values, strict=True):
                self.labels.add(value, names[k])
        for i in chosen:
            del self._rows[i]
        for column, known, found in zip(self.right, x, solutions, strict=True):
            known |= dict(zip(columns, found, strict=True))
            for i, row in self._rows.items():
                for k in columns:
                    if k in row:
                        column[i] = graph.sub(column[i], graph.mul(row[k], known[k]))
        for row in self._rows.values():
            for k in columns:
                row.pop(k, None)

    def _by_adjugate(
        self, chosen: tuple[int, ...], a: list[list[int]], right: list[list[int]]
    ) -> list[list[int]]:
        graph, size = self.graph, len(chosen)
        minors = [[self._cofactor(a, i, k) for k in range(size)] for i in range(size)]
        det = graph.total([graph.mul(a[0][k], minors[0][k]) for k in range(size)])
        if graph.number(det) is None:
            reference = graph.one
            for i in chosen:
                squares = [graph.mul(entry, entry) for entry in self._original[i]]
                reference = graph.mul(reference, graph.total(squares))
            # Nothing has been squared to find det, so that it may be smaller than a pivot of
            # Φ_q Φ_qᵀ; and short arms make it so where nothing is singular.
            square = graph.mul(det, det)
            self.checks.append(Check(square, reference, max(chosen), SHARPER))
            self.labels.add(square, self.labels.of("det2", *chosen))
            self.labels.add(reference, self.labels.of("size", *chosen))
        inverse = graph.div(graph.one, det)
        self.labels.add(det, self.labels.of("det", *chosen))
        self.labels.add(inverse, self.labels.of("inverse_det", *chosen))
        return [
            [
                graph.mul(
                    inverse, graph.total([graph.mul(minors[i][k], r[i]) for i in range(size)])
                )
                for k in range(size)
            ]
            for r in right
        ]

    def _cofactor(self, a: list[list[int]], i: int, k: int) -> int:
        graph = self.graph
        rest = [[x for j, x in enumerate(row) if j != k] for n, row in enumerate(a) if n != i]
        if not rest:
            return graph.one
        if len(rest) == 1:
            minor = rest[0][0]
        else:
            (p, q), (r, s) = rest
            minor = graph.sub(graph.mul(p, s), graph.mul(q, r))
        return graph.neg(minor) if (i + k) % 2 else minor

    def _by_normal_equations(
        self, chosen: tuple[int, ...], a: list[list[int]], right: list[list[int]]
    ) -> list[list[int]]:
        """x = Aᵀ (A Aᵀ)⁻¹ r, whose pivots are positive in any position that is not singular."""
        graph, zero = self.graph, self.graph.zero
        entries: dict[tuple[int, int], int] = {}
        for i, one in enumerate(a):
            for j, other in enumerate(a[: i + 1]):
                pairs = enumerate(zip(one, other, strict=True))
                both = [k for k, pair in pairs if zero not in pair]
                if both or i == j:
                    terms = [graph.mul(one[k], other[k]) for k in both]
                    entries[i, j] = entries[j, i] = graph.total(terms)
        references = {i: entries[i, i] for i in range(len(a))}
        system = Elimination(graph, entries, right, references=references)
        solutions = []
        for mu in system.solve("schur"):
            sides = range(len(a[0]))
            solutions.append(
                [
                    graph.total([graph.mul(row[k], m) for row, m in zip(a, mu, strict=True)])
                    for k in sides
                ]
            )
        self.checks += [
            check._replace(constraint=chosen[check.constraint]) for check in system.checks
        ]
        return solutions
