"""The tables of a generated module, typed: the only place that knows its layout."""

from collections.abc import Iterable
from difflib import get_close_matches
from types import ModuleType
from typing import Any, NamedTuple, Protocol, SupportsIndex, TypeVar, get_args, get_origin, overload

import numpy as np
import numpy.typing as npt

from codegen.errors import UnknownNameError
from codegen.parameter_conditions import ConditionRow, ProfileRow
from codegen.plain_values import shown
from runtime.core.modes_and_event_kinds import Boundary

Indices = npt.NDArray[np.int64]


class Row(Protocol):
    """A line of a table, which is found by its name."""

    @property
    def name(self) -> str: ...  # noqa: D102


RowT = TypeVar("RowT", bound=Row)


class Table(tuple[RowT, ...]):
    """A tuple of named rows; a row is found by its position or by its name."""

    __slots__ = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The names, in order."""
        return tuple(row.name for row in self)

    def __contains__(self, item: object) -> bool:
        """Whether a row, or a row of that name, is here."""
        return item in self.names if isinstance(item, str) else super().__contains__(item)

    @overload
    def __getitem__(self, item: SupportsIndex | str) -> RowT: ...
    @overload
    def __getitem__(self, item: slice) -> tuple[RowT, ...]: ...
    def __getitem__(self, item: SupportsIndex | str | slice) -> RowT | tuple[RowT, ...]:
        """Row by position or name."""
        if isinstance(item, int | np.integer | slice):
            return super().__getitem__(item)
        return super().__getitem__(self.index(item))

    def index(self, item: object, *bounds: SupportsIndex) -> int:
        """Position of a row, or of the row of that name."""
        if isinstance(item, str):
            try:
                return self.names.index(item, *bounds)
            except ValueError:
                raise UnknownNameError(unknown("name", item, self.names)) from None
        try:
            return super().index(item, *bounds)
        except Exception as error:
            raise UnknownNameError(unknown("name", item, self.names)) from error


class Coordinate(NamedTuple):
    """A generalized coordinate, the name of its velocity, and its unit."""

    name: str
    velocity: str
    unit: str

    @property
    def is_angle(self) -> bool:
        """Whether it is measured in rad."""
        return self.unit == "rad"

    @property
    def is_length(self) -> bool:
        """True for a position in metres."""
        return self.unit == "m"

    @property
    def velocity_unit(self) -> str:
        """Unit of its velocity."""
        return f"{self.unit}/s"

    @property
    def acceleration_unit(self) -> str:
        """Unit of its acceleration."""
        return f"{self.unit}/s^2"


class Constraint(NamedTuple):
    """One scalar equation of a joint or a driver."""

    element: str
    kind: str
    row: str

    @property
    def name(self) -> str:
        """`element.row`."""
        return f"{self.element}.{self.row}"


class Parameter(NamedTuple):
    """A declared parameter; `sign` is "", "positive" or "nonnegative"."""

    name: str
    default: float
    unit: str
    sign: str


class Effect(NamedTuple):
    """Something that acts on the bodies: gravity, a force, a spring, a driver."""

    name: str
    kind: str


class Switch(NamedTuple):
    """A condition on which an effect depends; it holds where its function is positive."""

    name: str
    condition: str
    # "friction": a slip that may stay zero; "contact": the gap of a rigid contact; at g = 0 a
    # "closed condition" holds, and of a "balanced condition" the mean of both sides
    kind: str = "condition"

    @property
    def title(self) -> str:
        """`effect: condition`, as events name it."""
        return f"{self.name}: {self.condition}"


class RigidContact(NamedTuple):
    """A rigid contact and the number of its switch."""

    name: str
    switch: int


class ReactionRow(NamedTuple):
    """One component of what a joint or driver transmits."""

    element: str
    component: str
    unit: str

    @property
    def name(self) -> str:
        """`element.component`."""
        return f"{self.element}.{self.component}"


class TimeFunction(NamedTuple):
    """An explicit function of time, as operations; see `codegen.lower.time_programs`.

    A row is (operation, rows that it takes ...); ("const", number), ("p", slot) or ("t",); or
    ("table", row, (knots, coefficients), derivative, periodic).
    """

    name: str  # of the element
    role: str  # "law" or "effect"
    watched: tuple[int, ...]  # rows that may bend sharply
    rows: tuple[tuple[Any, ...], ...]

    @property
    def title(self) -> str:
        """As events name it."""
        return f"{self.name}: next piece of its function of time"


class StartValue(NamedTuple):
    """A start value of a coordinate or velocity."""

    name: str
    value: float
    role: str  # "fixed", "guess", or "neutral": that of the neutral pose, if not zero


class Description(NamedTuple):
    """The literals of a generated module."""

    generator: str
    model: str
    scene: str
    formulation: str
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
    # whose power is reported; of kind "work", ``work(NAME)``, it is there to be integrated
    powers: Table[Effect]
    start: Table[StartValue]
    jacobian_rows: Indices
    jacobian_columns: Indices
    mass_rows: Indices
    mass_columns: Indices
    operations: tuple[tuple[str, int], ...]
    has_masses: bool
    analysis: str = "dynamics"
    unused: tuple[str, ...] = ()  # parameters on which nothing depends that takes part
    outputs: tuple[str, ...] | None = None  # named in addition to the motion; None: all
    # constraints whose multipliers are answered; None: all
    recovered: tuple[int, ...] | None = None
    kernels: frozenset[str] = frozenset()  # what the module defines, its kernels among it
    rigid: Table[RigidContact] = Table()
    stiction: tuple[int, ...] = ()
    weak_pivot: float = 0.0  # part of its reference below which a pivot is weak; 0: none is watched
    time_functions: tuple[TimeFunction, ...] = ()
    conditions: tuple[ConditionRow, ...] = ()  # on parameters, judged before each run
    profiles: tuple[ProfileRow, ...] = ()

    @property
    def title(self) -> str:
        """`model/scene`, as messages name it."""
        return f"{self.model}/{self.scene}"

    def suggest_output(self, output: str) -> str:
        """Sentence on an output that the scene does not ask for, and how to have it."""
        before = ("reactions", "energy", "powers") if self.outputs is None else self.outputs
        outputs = ", ".join(map(repr, (*before, output)))
        return (
            f"{self.title} does not compute {output}, which its outputs do not name; declare the "
            f"scene with outputs=[{outputs}], or load scene.with_(outputs=[{outputs}])."
        )

    def leaves_out(self, output: str, *elements: str) -> bool:
        """Whether a scene that names its outputs names neither `output` nor those of elements."""
        if self.outputs is None or f"{output}s" in self.outputs or output in self.outputs:
            return False
        return not any(f"{output}({element})" in self.outputs for element in elements)

    @property
    def tracked(self) -> tuple[str, ...]:
        """Points whose paths are reported."""
        return tuple(row.name for row in self.effects if row.kind == "tracked point")

    @property
    def boundaries(self) -> npt.NDArray[np.int64]:
        """Of each switch what holds where its function stays at zero, a `Boundary`."""
        words = {"closed condition": Boundary.CLOSED, "balanced condition": Boundary.BALANCED}
        return np.array([words.get(row.kind, Boundary.OPEN) for row in self.switches], np.int64)

    @property
    def work_rows(self) -> dict[str, int]:
        """Effect or driver → the row of the power of which its work is the integral."""
        rows = enumerate(self.powers)
        return {row.name[len("work(") : -1]: k for k, row in rows if row.kind == "work"}

    @property
    def balanced_rows(self) -> int:
        """Number of the first powers, which with the energies make a balance; -1: not all."""
        outputs = self.outputs
        known = outputs is None or {"energy", "powers"} <= {*outputs}
        return len(self.powers) - len(self.work_rows) if known and self.has_masses else -1

    @property
    def driver_rows(self) -> npt.NDArray[np.bool_]:
        """True for constraints of drivers, shape (m,)."""
        return np.array([row.element in self.drivers for row in self.constraints], dtype=np.bool_)

    @property
    def friction_limits(self) -> tuple[tuple[int, int, int], ...]:
        """(switch, row of its force, row of its limit) of the frictions that report a limit."""
        rows = {(row.element, row.component): i for i, row in enumerate(self.reactions)}
        return tuple(
            (k, rows[row.name, part], rows[row.name, "limit"])
            for k, row in enumerate(self.switches)
            for part in ("force", "torque")
            if row.kind == "friction" and {(row.name, part), (row.name, "limit")} <= rows.keys()
        )

    @property
    def is_length(self) -> npt.NDArray[np.bool_]:
        """True for coordinates that are lengths, shape (n,); the typical size of others is 1."""
        return np.array([row.is_length for row in self.coordinates], dtype=np.bool_)

    @property
    def neutral(self) -> npt.NDArray[np.float64]:
        """The neutral pose, in which no body is turned, shape (n,)."""
        values = {row.name: row.value for row in self.start if row.role == "neutral"}
        return np.array([values.get(row.name, 0.0) for row in self.coordinates])


def describe(module: ModuleType) -> Description:
    """Read the literals of a loaded generated module, each called as its field in capitals."""
    fields = {name: name.upper() for name in Description._fields}
    literals = {k: getattr(module, name) for k, name in fields.items() if hasattr(module, name)}
    kinds: dict[str, Any] = Description.__annotations__
    for name, kind in kinds.items():
        if get_origin(kind) is Table:
            (row,) = get_args(kind)
            literals[name] = Table(row(*entry) for entry in literals.get(name, ()))
        elif kind == Indices:
            literals[name] = np.array(literals.get(name, ()), dtype=np.int64)
    literals["conditions"] = tuple(map(ConditionRow._make, literals.get("conditions", ())))
    literals["profiles"] = tuple(map(ProfileRow._make, literals.get("profiles", ())))
    literals["stiction"] = tuple(switch for _, switch in literals.get("stiction", ()))
    literals["time_functions"] = tuple(
        TimeFunction(name, role, watched, tuple(_row_with_table(module, row) for row in rows))
        for name, role, watched, rows in literals.get("time_functions", ())
    )
    return Description(
        **literals, has_masses=hasattr(module, "mass"), kernels=frozenset(vars(module))
    )


def _row_with_table(module: ModuleType, row: tuple[Any, ...]) -> tuple[Any, ...]:
    """A row of an explicit function of time, with the numbers of the table that it names."""
    if row[0] != "table":
        return row
    name, at, stem, order, periodic = row
    table = getattr(module, f"{stem}_KNOTS"), getattr(module, f"{stem}_ROWS")
    return name, at, table, order, periodic


def unknown(what: str, name: object, names: Iterable[str]) -> str:
    """Sentence saying that a name does not exist, with the nearest that do."""
    names = tuple(names)
    near = get_close_matches(name, names, n=3, cutoff=0.5) if isinstance(name, str) else []
    if near:
        return f"There is no {what} {shown(name)}; nearest: {', '.join(near)}."
    listed = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
    return f"There is no {what} {shown(name)}; there are: {listed or 'none'}."
