"""Explicit coordinates, which one constraint determines: their formulas, and the constraints left.

Where ∂Φ_i/∂q_k is a number b, constraint i reads b q_k + f = 0 with an f that does not contain q_k,
and q_k = -f/b is a substitution. Substituted one after the other, those with the least fill-in
first, x and y of a pinned body and the angle of a guided one leave the equations, and the
constraints that close loops remain. The rates follow from the same elimination of Φ_q q̇ = ν and
Φ_q q̈ = γ. Every coordinate then is

    q = q(c, t),    q̇_k = Σ T_kj ċ_j + ν_k,    q̈_k = Σ T_kj c̈_j + γ_k

with the coordinates c that remain.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from codegen.lower.differentiation.program_tangents import differentiate
from codegen.lower.graph import Graph
from codegen.lower.linear.elimination_order import LEAST_PIVOT
from codegen.lower.linear.sparse_row_elimination import ROUNDING
from codegen.lower.program import dependencies
from codegen.lower.substitution import substitute


class Rates(NamedTuple):
    """q̇ = Σ slopes · ċ + velocity, q̈ = Σ slopes · c̈ + acceleration."""

    slopes: dict[int, int]
    velocity: int
    acceleration: int


@dataclass
class Row:
    """A constraint in the course of the substitution."""

    value: int
    entries: dict[int, int]
    nu: int
    gamma: int


@dataclass
class ExplicitCoordinates:
    """The constraints of a scene, its explicit coordinates substituted."""

    graph: Graph
    q: Sequence[int]  # the inputs that are the coordinates
    phi: Sequence[int]  # Φ
    entries: dict[tuple[int, int], int]  # structural non-zeros of Φ_q by (row, column)
    nu: Sequence[int]  # ν
    gamma: Sequence[int]  # γ
    preferred: frozenset[int]  # columns that are kept where there is a choice
    kept: frozenset[int]  # columns that are kept in any case
    rows: dict[int, Row] = field(default_factory=dict, init=False)
    # column → formula and rates, in the coordinates that remained when it was substituted
    substitutions: dict[int, tuple[int, Rates]] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        for i, value in enumerate(self.phi):
            self.rows[i] = Row(value, {}, self.nu[i], self.gamma[i])
        for (i, k), entry in self.entries.items():
            self.rows[i].entries[k] = entry
        while pivot := self._pivot():
            self._substitute(*pivot)

    @property
    def coordinates(self) -> list[int]:
        """Columns of the coordinates that remain."""
        return [k for k in range(len(self.q)) if k not in self.substitutions]

    def _pivot(self) -> tuple[int, int] | None:
        """Row and column of the pivot with the least fill-in."""
        counts = Counter(k for row in self.rows.values() for k in row.entries)
        candidates = []
        for i, row in self.rows.items():
            sizes = {k: abs(self.graph.number(entry) or 0.0) for k, entry in row.entries.items()}
            least = LEAST_PIVOT * max(sizes.values(), default=0.0)
            candidates += [
                (k in self.preferred, (len(sizes) - 1) * (counts[k] - 1), len(sizes), i, k)
                for k, size in sizes.items()
                if size > 0.0 and size >= least and k not in self.kept and self._is_affine(row, k)
            ]
        return min(candidates)[3:] if candidates else None

    def _is_affine(self, row: Row, k: int) -> bool:
        """Whether the derivative of the constraint itself is that in its Jacobian."""
        (slope,) = differentiate(self.graph, [row.value], {self.q[k]: self.graph.one})
        return self.graph.number(slope) == self.graph.number(row.entries[k])

    def _substitute(self, i: int, k: int) -> None:
        graph, row = self.graph, self.rows.pop(i)
        inverse = graph.neg(graph.div(graph.one, row.entries.pop(k)))
        (rest,) = substitute(graph, [row.value], {self.q[k]: graph.zero})
        formula = graph.mul(inverse, rest)
        rates = Rates(
            {j: graph.mul(inverse, entry) for j, entry in row.entries.items()},
            graph.neg(graph.mul(inverse, row.nu)),
            graph.neg(graph.mul(inverse, row.gamma)),
        )
        self.substitutions[k] = formula, rates
        for other in (row for row in self.rows.values() if k in row.entries):
            (other.value,) = substitute(graph, [other.value], {self.q[k]: formula})
            factor = other.entries.pop(k)
            for j, slope in rates.slopes.items():
                before, product = other.entries.pop(j, graph.zero), graph.mul(factor, slope)
                changed = graph.add(before, product)
                number, was = graph.number(changed), graph.number(before)
                if number is None or abs(number) > ROUNDING * abs(was or 0.0):
                    other.entries[j] = changed
            other.nu = graph.sub(other.nu, graph.mul(factor, rates.velocity))
            other.gamma = graph.sub(other.gamma, graph.mul(factor, rates.acceleration))

    # -- in the coordinates that remain -------------------------------------------------------

    def formulas(self) -> dict[int, int]:
        """Column of each explicit coordinate → its formula in those that remain."""
        known: dict[int, int] = {}
        for column, (formula, _) in reversed(self.substitutions.items()):
            reachable = dependencies(self.graph.values, [formula])
            inner = {self.q[k]: value for k, value in known.items() if self.q[k] in reachable}
            (known[column],) = substitute(self.graph, [formula], inner)
        return known

    def rates(self) -> dict[int, Rates]:
        """Column of every coordinate → its rates by those of the coordinates that remain."""
        graph = self.graph
        known = {k: Rates({k: graph.one}, graph.zero, graph.zero) for k in self.coordinates}
        for column, (_, rates) in reversed(self.substitutions.items()):
            known[column] = combined(graph, rates, known)
        return known


def combined(graph: Graph, rates: Rates, known: dict[int, Rates]) -> Rates:
    """Rates by other rates, with these substituted."""
    slopes: dict[int, int] = {}
    velocity, acceleration = rates.velocity, rates.acceleration
    for j, factor in rates.slopes.items():
        for k, slope in known[j].slopes.items():
            slopes[k] = graph.add(slopes.get(k, graph.zero), graph.mul(factor, slope))
        velocity = graph.add(velocity, graph.mul(factor, known[j].velocity))
        acceleration = graph.add(acceleration, graph.mul(factor, known[j].acceleration))
    return Rates(
        {k: slope for k, slope in slopes.items() if slope != graph.zero}, velocity, acceleration
    )
