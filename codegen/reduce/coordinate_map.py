"""All coordinates as functions of those that are kept: q = q(u, t), q̇ = T u̇ + ν, q̈ = T ü + γ.

Explicit coordinates, which one constraint determines, are substituted;
loops with a solution in closed form are solved (`closed_form_loops`). T, ν and γ follow from the
same eliminations.

Explicit coordinates, which one constraint determines: their formulas, and the constraints left.

Where ∂Φ_i/∂q_k is a number b, constraint i reads b q_k + f = 0 with an f that does not contain q_k,
and q_k = -f/b is a substitution. Substituted one after the other, those with the least fill-in
first, x and y of a pinned body and the angle of a guided one leave the equations, and the
constraints that close loops remain. The rates follow from the same elimination of Φ_q q̇ = ν and
Φ_q q̈ = γ. Every coordinate then is

    q = q(c, t),    q̇_k = Σ T_kj ċ_j + ν_k,    q̈_k = Σ T_kj c̈_j + γ_k

with the coordinates c that remain.
"""

from collections import Counter
from collections.abc import Iterable, Sequence, Set
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from codegen.lower.differentiation.program_tangents import differentiate
from codegen.lower.graph import Graph, substitute
from codegen.lower.linear.elimination_order import LEAST_PIVOT
from codegen.lower.linear.sparse_row_elimination import ROUNDING
from codegen.lower.lowered_scene import Lowered
from codegen.lower.module_tables import Description
from codegen.lower.poses_near_start import Poses
from codegen.lower.program import Op, dependencies
from codegen.reduce.closed_form_loops import Loop, find_loops


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
    kept: Set[int]  # columns that are kept in any case
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


_FAR = 0.16  # measured: of the largest ρ²; nearer to a dead centre no run returns to the angle
_MOSTLY = 0.5  # measured: share of positions; 36 suitable loops have 0.65 or more, another one 0
EVENT_KERNELS = (
    *("switching", "switching_rates", "gap_accelerations", "holds", "restitution"),
    *("peak_arguments", "samples", "clocks", "watched"),
)
"""Kernels that are repeated in the coordinates that are kept."""


class CoordinateMap:
    """The coordinates of a scene as functions of those that are kept."""

    def __init__(self, lowered: Lowered) -> None:
        self.lowered, self.scene, self.description = (
            lowered,
            lowered.independent,
            lowered.description,
        )
        scene, graph = self.scene, self.scene.graph
        self.graph = graph
        self.names = [str(q.name) for q in scene.equations.coordinates]
        self.rate_names = [str(q.rate.name) for q in scene.equations.coordinates]
        rates = enumerate(self.rate_names)
        self.accelerations = [graph.input("a", k, f"{name}_rate") for k, name in rates]
        # those without a pivot in M, but for masses, which are explicit in their laws; and states
        needed = {scene.columns[state.integral] for state in scene.equations.states}
        without = (k for k in range(scene.n) if scene.mass[k, k] == graph.zero)
        coordinates = scene.equations.coordinates
        needed |= {k for k in without if not coordinates[k].unit.startswith("kg")}
        self.own = {k: i for i, k in scene.massless}  # column → row of joints' own coordinates
        fixed = frozenset(fixed_at_start(self.description))
        self.explicit = ExplicitCoordinates(
            graph, scene.q, scene.phi, scene.jacobian, scene.nu, scene.gamma, fixed, needed
        )
        self.formulas = self.explicit.formulas()
        self.loops = self._loops()
        self.angles = [angle for loop in self.loops for angle in loop.angles]  # in closed form
        self.branching = [angle for angle in self.angles if angle.branch is not None]
        closed = {angle.column for angle in self.angles}
        solved = {i for loop in self.loops for i in loop.rows}
        # columns of the coordinates that are left
        self.kept = tuple(k for k in self.explicit.coordinates if k not in closed)
        # rows of the constraints between them
        self.closures = tuple(i for i in self.explicit.rows if i not in solved)
        self.stated = tuple(scene.stated[i] for i in self.closures)  # as constraints of the scene
        rows = (self.description.constraints[i] for i in self.stated)
        self.row_names = [f"{element}_{row}" for element, _, row in rows]
        self.slots = {k: slot for slot, k in enumerate(self.kept)}
        self.substitutes: dict[int, int] = {}  # value → its substitute in the kept coordinates
        self.slopes: dict[int, dict[int, int]] = {}  # column → its row of T, by kept columns
        self.bias: dict[int, int] = {}  # column → its γ
        self._substitute()
        self._differentiate()

    def substituted(self, values: Iterable[int]) -> list[int]:
        """Values of the scene, in the coordinates that are kept."""
        return substitute(self.graph, list(values), self.substitutes)

    # -- selection ---------------------------------------------------------------------------

    def _loops(self) -> list[Loop]:
        """Loops in closed form, of angles that enter all else by sine and cosine alone."""
        left, rows = self.explicit.coordinates, self.explicit.rows
        first = fixed_at_start(self.description)
        independent = [*(k for k in first if k in left), *(k for k in left if k not in first)]
        independent = independent[: max(len(left) - len(rows), 0)]
        values, poses = self._required(), Poses(self.lowered)
        nearby = poses.along_motion()

        def suits(square: int, size: int) -> bool:
            """Whether the angle is far from its dead centres in most positions near the start."""
            at = np.array([poses.values(self.graph, [square, size], q) for q in nearby])
            far = at[:, 0] > _FAR * np.fmax.reduce(at[:, 1]) if len(at) else np.ones(1)
            return bool(np.mean(far) >= _MOSTLY)

        angles = [k for k in left if k not in independent and self._is_periodic(k, values)]
        while True:
            phi = {i: row.value for i, row in rows.items()}
            declared = len(self.description.parameters)
            loops = find_loops(self.graph, self.scene.q, phi, angles, declared, self.own, suits)
            bare = set()
            for loop in loops:
                others = [row.value for i, row in rows.items() if i not in loop.rows]
                bare |= {k for k in loop.columns if not self._is_periodic(k, others)}
            if not bare:
                return loops
            angles = [k for k in angles if k not in bare]

    def _required(self) -> list[int]:
        """The values that the equations of motion and the events need, explicit ones substituted.

        Constraints are not among them: those that close a loop are solved for its angles.
        """
        scene, explicit, kernels = self.scene, self.explicit, self.lowered.kernels
        values = [*scene.forces]
        for name in (*EVENT_KERNELS, "accelerations"):
            if name in kernels and (name != "accelerations" or scene.frictions):
                values += [out.value for out in kernels[name].outputs]
        for row in explicit.rows.values():
            values += [row.nu, row.gamma, *row.entries.values()]
        for rates in explicit.rates().values():
            values += [rates.velocity, rates.acceleration, *rates.slopes.values()]
        given = {scene.q[k]: formula for k, formula in self.formulas.items()}
        return substitute(self.graph, values, given)

    def _is_periodic(self, k: int, values: list[int]) -> bool:
        """Whether a coordinate is an angle that enters the values by its sine and cosine alone."""
        if self.description.coordinates[k][2] != "rad":
            return False
        ends = {self.graph.function(op, self.scene.q[k]): None for op in (Op.SIN, Op.COS)}
        return self.scene.q[k] not in dependencies(self.graph.values, values, ends)

    # -- positions ---------------------------------------------------------------------------

    def _substitute(self) -> None:
        """The substitute of every coordinate."""
        graph, scene, substitutes = self.graph, self.scene, self.substitutes
        for k, slot in self.slots.items():
            substitutes[scene.q[k]] = graph.input("q", slot, self.names[k])
            substitutes[scene.v[k]] = graph.input("v", slot, self.rate_names[k])
        for angle in self.angles:
            s, c = substitute(graph, [angle.s, angle.c], substitutes)
            substitutes[graph.function(Op.SIN, scene.q[angle.column])] = s
            substitutes[graph.function(Op.COS, scene.q[angle.column])] = c
            substitutes[scene.q[angle.column]] = graph.function(Op.ATAN2, s, c)
        values = self.substituted(self.formulas.values())
        # An explicit angle that differs from a solved one by a constant keeps its sine and cosine.
        for k, formula in self.formulas.items():
            for op in (Op.SIN, Op.COS):
                end = graph.function(op, scene.q[k])
                (of_formula,) = substitute(graph, [end], {scene.q[k]: formula})
                (substitutes[end],) = self.substituted([of_formula])
        substitutes |= {scene.q[k]: value for k, value in zip(self.formulas, values, strict=True)}

    # -- rates -------------------------------------------------------------------------------

    def _differentiate(self) -> None:
        """The rates of every coordinate by those that are kept."""
        graph, scene = self.graph, self.scene
        known = {k: Rates({k: graph.one}, graph.zero, graph.zero) for k in self.kept}
        for loop in self.loops:
            known |= self._of_loop(loop, known)
        explicit = self.explicit.rates().items()
        rates = {k: combined(graph, one, known) for k, one in explicit if k not in known}
        rates |= known
        # Velocities first: γ contains them.
        velocities: dict[int, int] = {}
        for k, one in rates.items():
            slopes = self.substituted(one.slopes.values())
            self.slopes[k] = dict(zip(one.slopes, slopes, strict=True))
            pairs = self.slopes[k].items()
            terms = [graph.mul(slope, self.substitutes[scene.v[j]]) for j, slope in pairs]
            velocities[k] = graph.total([*terms, *self.substituted([one.velocity])])
        self.substitutes |= {scene.v[k]: value for k, value in velocities.items()}
        bias = self.substituted(rates[k].acceleration for k in rates)
        self.bias = dict(zip(rates, bias, strict=True))

    def _of_loop(self, loop: Loop, known: dict[int, Rates]) -> dict[int, Rates]:
        """Rates of a loop's angles, for which its rows are solved."""
        graph = self.graph
        columns = loop.columns
        matrix, right = [], []
        for i in loop.rows:
            row = self.explicit.rows[i]
            matrix.append([row.entries.get(k, graph.zero) for k in columns])
            others = {j: graph.neg(e) for j, e in row.entries.items() if j not in columns}
            right.append(combined(graph, Rates(others, row.nu, row.gamma), known))
        if len(columns) == 1:
            inverse = [[graph.div(graph.one, matrix[0][0])]]
        else:
            (a, b), (c, d) = matrix
            over = graph.div(graph.one, graph.sub(graph.mul(a, d), graph.mul(b, c)))
            inverse = [
                [graph.mul(over, d), graph.neg(graph.mul(over, b))],
                [graph.neg(graph.mul(over, c)), graph.mul(over, a)],
            ]
        rows = dict(enumerate(right))
        return {
            k: combined(graph, Rates(dict(enumerate(line)), graph.zero, graph.zero), rows)
            for k, line in zip(columns, inverse, strict=True)
        }


def fixed_at_start(description: Description) -> list[int]:
    """Columns of the coordinates whose start is fixed, those with a fixed velocity first."""
    fixed = {name for name, _, role in description.start if role == "fixed"}
    rates = [k for k, (_, rate, _) in enumerate(description.coordinates) if rate in fixed]
    positions = [k for k, (name, *_) in enumerate(description.coordinates) if name in fixed]
    return [*rates, *(k for k in positions if k not in rates)]
