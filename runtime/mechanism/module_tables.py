"""The tables of a generated module, typed: the only place that knows its layout."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from enum import IntEnum
from functools import cached_property
from types import ModuleType
from typing import Any, get_args, get_origin

import numpy as np
import numpy.typing as npt

from codegen.parameter_conditions import ConditionRow, ProfileRow
from runtime.core.kinds import Boundary, TablePart
from runtime.mechanism.series_table import SeriesTable
from runtime.mechanism.spins import spin_places
from runtime.mechanism.table_rows import (
    COUNTED,
    TRACKED,
    Constraint,
    Coordinate,
    Effect,
    Parameter,
    Power,
    ReactionRow,
    RigidContact,
    StartValue,
    State,
    Switch,
    Table,
    TableRange,
    TimeFunction,
    Watched,
)

Indices = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False, repr=False)
class Description:
    """The literals of a generated module, and what follows from them, found once."""

    generator: str
    model: str
    scene: str
    sources: tuple[tuple[str, str], ...]
    bodies: tuple[str, ...]
    coordinates: Table[Coordinate]
    constraints: Table[Constraint]
    parameters: Table[Parameter]
    constants: tuple[str, ...]
    effects: Table[Effect]
    left_out: Table[Effect]
    drivers: tuple[str, ...]
    switches: Table[Switch]
    reactions: Table[ReactionRow]
    powers: Table[Power]
    start: Table[StartValue]
    jacobian_rows: Indices
    jacobian_columns: Indices
    independent_jacobian_rows: Indices  # of the rows without redundant ones, if there are any
    independent_jacobian_columns: Indices
    mass_rows: Indices
    mass_columns: Indices
    operations: tuple[tuple[str, int], ...]
    has_masses: bool
    analysis: str = "dynamics"
    unused: tuple[str, ...] = ()  # parameters on which nothing depends that takes part
    outputs: tuple[str, ...] | None = None  # named in addition to the motion; None: "default"
    # constraints whose multipliers are answered; None: all
    recovered: tuple[int, ...] | None = None
    redundant: tuple[int, ...] = ()  # constraints in whose places no independent row stands
    free: int = 0  # number of vectors that `free_multipliers` writes
    kernels: frozenset[str] = frozenset()  # what the module defines, its kernels among it
    rigid: Table[RigidContact] = field(default=Table())
    stiction: tuple[int, ...] = ()
    shares: tuple[int, ...] = ()  # switches of which the share of both modes stands in `p`
    weak_pivot: float = 0.0  # part of its reference below which a pivot is weak; 0: none is watched
    time_functions: tuple[TimeFunction, ...] = ()
    table_ranges: tuple[TableRange, ...] = ()
    # (element, kind, exponent) of functions of the position that may peak within a step; of a kink
    # the kind of place and the function besides
    peaks: tuple[tuple[Any, ...], ...] = ()
    conditions: tuple[ConditionRow, ...] = ()  # on parameters, judged before each run
    profiles: tuple[ProfileRow, ...] = ()
    states: Table[State] = field(default=Table())
    sampled: tuple[str, ...] = ()  # states that clocks renew
    triggers: tuple[int, ...] = ()  # of each the condition that renews it, -1: a clock
    watched: Table[Watched] = field(default=Table())  # conditions that a run watches
    # (joints, scene that follows) of several joints that may come or go at one instant
    together: tuple[tuple[tuple[str, ...], str], ...] = ()
    controllers: tuple[str, ...] = ()  # those among them whose samples a run brings
    # effects whose values are sought: parameters, whose values a run gives as weights
    unknown: tuple[str, ...] = ()
    turning: tuple[tuple[str, int], ...] = ()  # (body in space, column of its e0)
    # (joint, column of e0 of body i, -1: ground, vector, column of body j, vector) that they share
    facing: tuple[tuple[Any, ...], ...] = ()

    @cached_property
    def title(self) -> str:
        """`model/scene`, as messages name it."""
        return f"{self.model}/{self.scene}"

    @cached_property
    def followers(self) -> dict[str, frozenset[str]]:
        """Scene in which a run may go on → the joints that come or go for it at one instant."""
        alone = {row.scene: frozenset({row.target}) for row in self.watched if row.reconnects}
        return alone | {scene: frozenset(joints) for joints, scene in self.together}

    @cached_property
    def series(self) -> SeriesTable:
        """The series of the scene's results: of each name its column, unit and kind."""
        return SeriesTable(self)

    @cached_property
    def parameter_slots(self) -> int:
        """Length of `p`: parameters and the constants behind them."""
        return len(self.parameters) + len(self.constants)

    def need_masses(self, asked: str, instead: str = "") -> str:
        """Sentences on what needs masses and forces, in a scene without, and how to have it."""
        if self.analysis == "kinematics":
            return (
                f"{self.title}: {asked} needs masses and forces, which a scene with "
                f"analysis='kinematics' leaves out. Load scene.with_(analysis='dynamics'){instead}."
            )
        return (
            f"{self.title}: {asked} needs masses, and this scene has a body without. Give every "
            f"body a mass and an inertia{instead}."
        )

    @cached_property
    def asked(self) -> tuple[str, ...]:
        """The outputs that the scene names, in addition to the motion."""
        named = ("default",) if self.outputs is None else self.outputs
        default = ("reactions", "energy", "powers") if "default" in named else ()
        return tuple(dict.fromkeys((*default, *(word for word in named if word != "default"))))

    def suggest_output(self, output: str) -> str:
        """Sentence on an output that the scene does not ask for, and how to have it."""
        outputs = self.outputs_with(output)
        return (
            f"{self.title} does not compute {output}, which its outputs do not name; declare the "
            f"scene with outputs={outputs}, or load scene.with_(outputs={outputs})."
        )

    def outputs_with(self, output: str) -> str:
        """The list of the scene's outputs and one more; `...` stands for an expression."""
        named = ("default",) if self.outputs is None else self.outputs
        kept = [f"{row.name!r}: ..." for row in self.reactions if not row.component]
        expressions = [f"{{{', '.join(kept)}}}"] if kept else []
        return f"[{', '.join([*map(repr, named), *expressions, repr(output)])}]"

    def suggest_counting(self, name: str) -> str:
        """The same of a coordinate or rate that a joint may count; empty of any other name."""
        owner, _, letter = name.rpartition(".")
        letter = {"phi": "angle", "omega": "rate"}.get(letter, letter)  # as in the plane
        kinds, asked = {row.element: row.kind for row in self.constraints}, f"{owner}.{letter}"
        may = letter in COUNTED.get(kinds.get(owner, ""), ()) and asked not in self.startable
        return self.suggest_output(asked) if may else ""

    @cached_property
    def tracked(self) -> tuple[str, ...]:
        """Points that are outputs."""
        return tuple(row.name for row in self.effects if row.kind == TRACKED)

    @cached_property
    def mass_diagonal(self) -> npt.NDArray[np.int64]:
        """Of each non-zero of M its coordinate on the diagonal, else -1; shape (nm,)."""
        on_it = self.mass_rows == self.mass_columns
        return np.where(on_it, self.mass_rows, -1).astype(np.int64)

    @cached_property
    def boundaries(self) -> npt.NDArray[np.int64]:
        """Of each switch what holds where its function stays at zero, a `Boundary`.

        Friction that neither slips nor keeps anything at rest exerts the mean of both directions.
        """
        numbers = zip(self.switches, self._numbers_of_switches(Boundary), strict=True)
        balanced = int(Boundary.BALANCED)
        return np.array([(row.sticks and balanced) | n for row, n in numbers], np.int64)

    @cached_property
    def table_parts(self) -> tuple[int, ...]:
        """Of each switch what it says of a table, a `TablePart`."""
        return tuple(self._numbers_of_switches(TablePart))

    def _numbers_of_switches(self, kinds: type[IntEnum]) -> list[int]:
        """Of each switch the number that the first word of its kind means, 0 if none."""
        numbers = {one.name.lower(): int(one) for one in kinds}
        return [numbers.get(row.kind.partition(" ")[0], 0) for row in self.switches]

    @cached_property
    def work_rows(self) -> dict[str, int]:
        """Effect or driver → the row of the power of which its work is the integral."""
        return {row.source: k for k, row in enumerate(self.powers) if row.kind == "work"}

    @cached_property
    def balanced_rows(self) -> int:
        """Number of the first powers, which with the energies make a balance; -1: not all."""
        balanced = sum(row.kind not in ("power", "work") for row in self.powers)
        return balanced if self.has_masses and {"energy", "powers"} <= {*self.asked} else -1

    @cached_property
    def whole_powers(self) -> dict[str, int]:
        """Effect or driver → the row of the power of all that it exerts."""
        rows = enumerate(self.powers)
        return {row.source: k for k, row in rows if row.kind != "nonconservative"}

    @cached_property
    def driver_rows(self) -> npt.NDArray[np.bool_]:
        """True for constraints of drivers, shape (m,)."""
        return np.array([row.element in self.drivers for row in self.constraints], dtype=np.bool_)

    @cached_property
    def friction_limits(self) -> tuple[tuple[int, int, int], ...]:
        """(switch, row of its force, row of its limit) of the frictions that report a limit."""
        rows = {(row.element, row.component): i for i, row in enumerate(self.reactions)}
        return tuple(
            (k, rows[row.name, part], rows[row.name, "limit"])
            for k, row in enumerate(self.switches)
            for part in ("force", "torque")
            if row.sticks and {(row.name, part), (row.name, "limit")} <= rows.keys()
        )

    @cached_property
    def superposes(self) -> bool:
        """Whether forces that keep functions at zero add up: no friction beside them follows."""
        rubbing = sum(row.kind == "friction" for row in self.effects)
        return not self.shares and (not self.stiction or rubbing < 2)

    @cached_property
    def is_length(self) -> npt.NDArray[np.bool_]:
        """True for coordinates that are lengths, shape (n,); the typical size of others is 1."""
        return np.array([row.is_length for row in self.coordinates], dtype=np.bool_)

    @cached_property
    def is_angle(self) -> npt.NDArray[np.bool_]:
        """True for coordinates in rad, shape (n,)."""
        return np.array([row.is_angle for row in self.coordinates], dtype=np.bool_)

    @cached_property
    def state_columns(self) -> tuple[int, ...]:
        """Columns of the states with rates of their own."""
        return tuple(row.column for row in self.states if row.name not in self.sampled)

    @cached_property
    def sampled_columns(self) -> tuple[int, ...]:
        """Columns of the values that clocks renew."""
        return tuple(self.states[name].column for name in self.sampled)

    @cached_property
    def positions(self) -> tuple[Coordinate, ...]:
        """The coordinates without the integrals of states, which only bookkeeping has."""
        return tuple(row for row in self.coordinates if not row.is_state)

    @cached_property
    def variables(self) -> tuple[str, ...]:
        """Names of all that is integrated: coordinates, velocities, and states."""
        rates = (row.velocity for row in self.positions)
        return (*(row.name for row in self.positions), *rates, *self.states.names)

    @cached_property
    def spins(self) -> dict[str, tuple[int, int]]:
        """Component of ω' of a body in space, "rod.omega_x" → column of its e0, and axis."""
        return spin_places(self.turning)

    @property
    def startable(self) -> tuple[str, ...]:
        """Names of all that may have a start value: what is integrated, and components of ω'."""
        return (*self.variables, *self.spins)

    @cached_property
    def neutral(self) -> npt.NDArray[np.float64]:
        """The neutral pose, in which no body is turned, shape (n,)."""
        values = {row.name: row.value for row in self.start if row.role == "neutral"}
        return np.array([values.get(row.name, 0.0) for row in self.coordinates])


def describe(module: ModuleType) -> Description:
    """Read the literals of a loaded generated module, each called as its field in capitals."""
    kinds: dict[str, Any] = {one.name: one.type for one in fields(Description)}
    names = {name: name.upper() for name in kinds}
    literals = {k: getattr(module, name) for k, name in names.items() if hasattr(module, name)}
    for name, kind in kinds.items():
        row = (*get_args(kind), None)[0]
        if hasattr(row, "_fields") and row is not TimeFunction:
            make = Table if get_origin(kind) is Table else tuple
            literals[name] = make(row(*entry) for entry in literals.get(name, ()))
        elif kind == Indices:
            literals[name] = np.array(literals.get(name, ()), dtype=np.int64)
    literals["coordinates"] = _with_units_of_states(literals["coordinates"], literals["states"])
    for name in ("stiction", "shares"):
        literals[name] = tuple(switch for _, switch in literals.get(name, ()))
    literals["time_functions"] = tuple(
        TimeFunction(*function[:3], *_programs_with_tables(module, function[3:]))
        for function in literals.get("time_functions", ())
    )
    return Description(
        **literals, has_masses=hasattr(module, "mass"), kernels=frozenset(vars(module))
    )


def _with_units_of_states(coordinates: Table[Coordinate], states: Table[State]) -> Any:
    """The coordinates, those whose rates are states with their units."""
    units = {row.column: row.unit for row in states}
    return Table(
        row._replace(unit=f"{units[k] or 1} s", state_unit=units[k]) if k in units else row
        for k, row in enumerate(coordinates)
    )


def _programs_with_tables(module: ModuleType, programs: tuple[Any, ...]) -> Iterator[Any]:
    """The rows of an explicit function of time, and those of what it moves, two and two."""
    first, *others = (tuple(_row_with_table(module, row) for row in rows) for rows in programs)
    yield first
    yield tuple(zip(others[::2], others[1::2], strict=True))


def _row_with_table(module: ModuleType, row: tuple[Any, ...]) -> tuple[Any, ...]:
    """A row of an explicit function of time, with the numbers of the table that it names."""
    if row[0] != "table":
        return row
    name, at, stem, *rest = row
    table = getattr(module, f"{stem}_KNOTS"), getattr(module, f"{stem}_ROWS")
    return name, at, table, *rest
