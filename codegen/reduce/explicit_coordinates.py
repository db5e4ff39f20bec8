"""Coordinates that a constraint gives outright: which, by which formula, and what is left.

Where ∂Φ_i/∂q_k is a number b, constraint i reads b q_k + f = 0 with an f that q_k is not in, and
q_k = -f/b is a substitution. One after the other, those that fill in least first, they take a
pinned body's x and y and a guided body's angle out of the equations, and leave what closes loops.
The rates follow by the same elimination of Φ_q q̇ = ν and Φ_q q̈ = γ. Every coordinate then is

    q = q(c, t),    q̇_k = Σ T_kj ċ_j + ν_k,    q̈_k = Σ T_kj c̈_j + γ_k

of the coordinates c that are left.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from codegen.lower.differentiation.tangent import differentiate
from codegen.lower.graph import Graph
from codegen.lower.linear.pivots import LEAST_PIVOT
from codegen.lower.linear.square_systems import ROUNDING
from codegen.lower.substitution import reached, rebuilt


@dataclass(frozen=True)
class Rates:
    """q̇ = Σ slopes · ċ + velocity, q̈ = Σ slopes · c̈ + acceleration."""

    slopes: dict[int, int]
    velocity: int
    acceleration: int


@dataclass
class Row:
    """A constraint while others are put into it."""

    value: int
    entries: dict[int, int]
    nu: int
    gamma: int


@dataclass(frozen=True)
class Given:
    """A coordinate by its formula, in those that were left when it was found."""

    column: int
    formula: int
    rates: Rates


@dataclass
class Outright:
    """The constraints of a scene, and what they give outright.

    Parameters
    ----------
    q
        The inputs that are the coordinates.
    phi, entries, nu, gamma
        Φ, the structural non-zeros of Φ_q by (row, column), ν and γ.
    held
        Columns that are rather kept than given.
    left
        Columns that are kept in any case.
    """

    graph: Graph
    q: Sequence[int]
    phi: Sequence[int]
    entries: dict[tuple[int, int], int]
    nu: Sequence[int]
    gamma: Sequence[int]
    held: frozenset[int]
    left: frozenset[int]
    rows: dict[int, Row] = field(default_factory=dict, init=False)
    given: list[Given] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        for i, value in enumerate(self.phi):
            self.rows[i] = Row(value, {}, self.nu[i], self.gamma[i])
        for (i, k), entry in self.entries.items():
            self.rows[i].entries[k] = entry
        while pivot := self._pivot():
            self._take_out(*pivot)

    @property
    def coordinates(self) -> list[int]:
        """Columns of those that are left."""
        gone = {one.column for one in self.given}
        return [k for k in range(len(self.q)) if k not in gone]

    def _pivot(self) -> tuple[int, int] | None:
        """The row and column that fill in least."""
        counts: dict[int, int] = {}
        for row in self.rows.values():
            for k in row.entries:
                counts[k] = counts.get(k, 0) + 1
        found = []
        for i, row in self.rows.items():
            sizes = {k: abs(self.graph.number(entry) or 0.0) for k, entry in row.entries.items()}
            least = LEAST_PIVOT * max(sizes.values(), default=0.0)
            found += [
                (k in self.held, (len(sizes) - 1) * (counts[k] - 1), len(sizes), i, k)
                for k, size in sizes.items()
                if size > 0.0 and size >= least and k not in self.left and self._affine(row, k)
            ]
        return min(found)[3:] if found else None

    def _affine(self, row: Row, k: int) -> bool:
        """Whether the constraint itself has the slope that its Jacobian says."""
        (slope,) = differentiate(self.graph, [row.value], {self.q[k]: self.graph.one})
        return self.graph.number(slope) == self.graph.number(row.entries[k])

    def _take_out(self, i: int, k: int) -> None:
        graph = self.graph
        row = self.rows.pop(i)
        inverse = graph.neg(graph.div(graph.one, row.entries.pop(k)))
        (rest,) = rebuilt(graph, [row.value], {self.q[k]: graph.zero})
        formula = graph.mul(inverse, rest)
        rates = Rates(
            {j: graph.mul(inverse, entry) for j, entry in row.entries.items()},
            graph.neg(graph.mul(inverse, row.nu)),
            graph.neg(graph.mul(inverse, row.gamma)),
        )
        self.given.append(Given(k, formula, rates))
        for other in self.rows.values():
            if k in other.entries:
                self._put_in(other, k, formula, rates)

    def _put_in(self, row: Row, k: int, formula: int, rates: Rates) -> None:
        graph = self.graph
        (row.value,) = rebuilt(graph, [row.value], {self.q[k]: formula})
        factor = row.entries.pop(k)
        for j, slope in rates.slopes.items():
            before, product = row.entries.pop(j, graph.zero), graph.mul(factor, slope)
            changed = graph.add(before, product)
            number, was = graph.number(changed), graph.number(before)
            if number is None or abs(number) > ROUNDING * abs(was or 0.0):
                row.entries[j] = changed
        row.nu = graph.sub(row.nu, graph.mul(factor, rates.velocity))
        row.gamma = graph.sub(row.gamma, graph.mul(factor, rates.acceleration))

    # -- in terms of what is left ------------------------------------------------------------

    def formulas(self) -> dict[int, int]:
        """Column of each given coordinate → its formula in those that are left."""
        known: dict[int, int] = {}
        for one in reversed(self.given):
            met = reached(self.graph, [one.formula])
            inner = {self.q[k]: value for k, value in known.items() if self.q[k] in met}
            (known[one.column],) = rebuilt(self.graph, [one.formula], inner)
        return known

    def rates(self) -> dict[int, Rates]:
        """Column of every coordinate → its rates by those of the coordinates that are left."""
        graph = self.graph
        known = {k: Rates({k: graph.one}, graph.zero, graph.zero) for k in self.coordinates}
        for one in reversed(self.given):
            known[one.column] = combined(graph, one.rates, known)
        return known


def combined(graph: Graph, rates: Rates, known: dict[int, Rates]) -> Rates:
    """Rates by others, with those in their place."""
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
