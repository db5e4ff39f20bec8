"""The rows of a generated module's tables, each found by its name."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any, NamedTuple, Protocol, SupportsIndex, TypeVar, overload

import numpy as np

from codegen.errors import UnknownNameError
from codegen.object_display import html_table
from codegen.readers.values import shown

NEXT_PIECE = "next piece of its function of time"
"""What happens where a function of time has another formula, as events name it."""


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

    def __repr__(self) -> str:
        """The rows below the names of their columns."""
        fields, rows = self._columns()
        texts = [fields, *([f"{x:g}" if isinstance(x, float) else str(x) for x in r] for r in rows)]
        widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
        lines = ("  ".join(map(str.ljust, text, widths)).rstrip() for text in texts)
        return "\n".join(lines) if rows else "no rows"

    def _repr_html_(self) -> str:
        """The rows as a table, for notebooks."""
        return html_table(*self._columns()) or "<p>no rows</p>"

    def _columns(self) -> tuple[tuple[str, ...], list[tuple[object, ...]]]:
        """Names of the columns in which something stands, and the rows, which are named tuples."""
        rows: list[Any] = [*self]
        fields = rows[0]._fields if rows else ()
        used = [k for k in range(len(fields)) if any(row[k] not in ("", None) for row in rows)]
        return tuple(fields[k] for k in used), [tuple(row[k] for k in used) for row in rows]

    @overload
    def __getitem__(self, item: SupportsIndex | str) -> RowT: ...
    @overload
    def __getitem__(self, item: slice) -> tuple[RowT, ...]: ...
    def __getitem__(self, item: SupportsIndex | str | slice) -> RowT | tuple[RowT, ...]:
        """Row by position or name."""
        place = item if isinstance(item, int | np.integer | slice) else self.index(item)
        try:
            return super().__getitem__(place)
        except IndexError:
            raise UnknownNameError(unknown("row", item, self.names)) from None

    def index(self, item: object, *bounds: SupportsIndex) -> int:
        """Position of a row, or of the row of that name."""
        rows: tuple[Any, ...] = self.names if isinstance(item, str) else tuple(self)
        try:
            return rows.index(item, *bounds)
        except (ValueError, AttributeError):  # a number of SymPy's compares itself with no row
            raise UnknownNameError(unknown("name", item, self.names)) from None


class Coordinate(NamedTuple):
    """A generalized coordinate, the name of its velocity, and its unit."""

    name: str
    velocity: str
    unit: str
    state_unit: str | None = None  # of the velocity, where that is a state

    @property
    def is_angle(self) -> bool:
        """Whether it is measured in rad."""
        return self.unit == "rad"

    @property
    def is_length(self) -> bool:
        """True for a position in metres."""
        return self.unit == "m"

    @property
    def is_counted(self) -> bool:
        """Whether a joint in space counts it, an angle or a slide."""
        return self.name.endswith((".angle", ".slide"))

    @property
    def is_state(self) -> bool:
        """Whether it is the integral of a state, which is its velocity."""
        return self.state_unit is not None

    @property
    def velocity_unit(self) -> str:
        """Unit of its velocity."""
        return f"{self.unit}/s" if self.state_unit is None else self.state_unit or "1"

    @property
    def acceleration_unit(self) -> str:
        """Unit of its acceleration."""
        return f"{self.unit}/s^2" if self.state_unit is None else f"{self.state_unit or 1}/s"


class State(NamedTuple):
    """A state of first order or a sampled value: the velocity of the coordinate `column`."""

    name: str
    column: int
    unit: str
    nominal: float


class Watched(NamedTuple):
    """A condition that a run watches, what it does to its target, and the scene that follows."""

    name: str
    action: str
    target: str
    scene: str

    @property
    def reconnects(self) -> bool:
        """Whether a joint is released or engages."""
        return self.action in {"release", "engage"}


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


MASS_LAW = "mass law"  # kind of the equations of masses that vary, which push nothing
COUNTED = {
    "revolute in space": ("angle", "rate"),
    "translational in space": ("slide", "speed"),
    "cylindrical": ("angle", "rate", "slide", "speed"),
}
"""Kind of a joint → letters of what it may count."""
TRACKED = "tracked point"  # kind of a point whose place is an output; it stands among the effects


class Effect(NamedTuple):
    """Something that acts on the bodies: gravity, a force, a spring, a driver."""

    name: str
    kind: str


class Power(NamedTuple):
    """A power on the machine, of an effect or a driver."""

    # the source, ``power(NAME)`` or ``work(NAME)``
    name: str
    # an "effect" or "driver"; the "nonconservative" forces of an effect that has a potential;
    # "power": of all its forces; "work": the same to be integrated
    kind: str

    @property
    def source(self) -> str:
        """The effect or driver."""
        return self.name.removeprefix(f"{self.kind}(").removesuffix(")")


class Switch(NamedTuple):
    """A condition on which an effect depends; it holds where its function is positive."""

    name: str
    condition: str
    # "friction": a slip that may stay zero; "contact": the gap of a rigid contact; "clutch": the
    # slip of a freewheel, which is never negative; at g = 0 a
    # "closed condition" holds, of a "balanced condition" the mean of both sides, and of a "mixed
    # condition" or "mixed friction" each condition as it is written
    kind: str = "condition"

    @property
    def sticks(self) -> bool:
        """Whether it is the slip of a friction that sticks."""
        return self.kind.endswith("friction")

    @property
    def one_way(self) -> bool:
        """Whether it is the slip of a freewheel."""
        return self.kind == "clutch"

    @property
    def title(self) -> str:
        """`effect: condition`, as events name it."""
        return f"{self.name}: {self.condition}"


class RigidContact(NamedTuple):
    """A rigid contact and the number of its switch."""

    name: str
    switch: int


class ReactionRow(NamedTuple):
    """One component of what a joint or driver transmits; an expression has no components."""

    element: str
    component: str
    unit: str

    @property
    def name(self) -> str:
        """`element.component`, or the name of an expression."""
        return f"{self.element}.{self.component}".removesuffix(".")


class TimeFunction(NamedTuple):
    """An explicit function of time, as operations; see `codegen.lower.module_tables`.

    A row is (operation, rows that it takes ...); ("const", number), ("p", slot) or ("t",); or
    ("table", row, (knots, coefficients), derivative, periodic[, beyond]), undefined beyond its ends
    unless it says "extrapolate".
    """

    name: str  # of the element
    role: str  # "law", "effect", or "place": where a rate belongs to it, which a jump has not
    watched: tuple[int, ...]  # rows that may bend sharply
    rows: tuple[tuple[Any, ...], ...]
    # of a place: (s, f) of the scalars that it is in and the forces along these, rows that begin
    # with ("q", slot) and ("v", slot), the last of these ds/dt, too
    along: tuple[tuple[tuple[Any, ...], tuple[Any, ...]], ...] = ()

    @property
    def title(self) -> str:
        """As events name it."""
        return f"{self.name}: {NEXT_PIECE}"


class TableRange(NamedTuple):
    """A table that is undefined beyond its ends, and what it is taken at, as operations."""

    name: str  # of the element
    table: str
    at: str
    low: float
    high: float
    rows: tuple[tuple[Any, ...], ...]  # as of a `TimeFunction`, with ("q", slot) and ("v", slot)


class StartValue(NamedTuple):
    """A start value of a coordinate or velocity."""

    name: str
    value: float
    role: str  # "fixed", "guess", or "neutral": that of the neutral pose, if not zero


def unknown(what: str, name: object, names: Iterable[str]) -> str:
    """Sentence saying that a name does not exist, with the nearest that do."""
    names = tuple(names)
    near = get_close_matches(name, names, n=3, cutoff=0.5) if isinstance(name, str) else []
    if near:
        return f"There is no {what} {shown(name)}; nearest: {' or '.join(near)}."
    listed = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
    return f"There is no {what} {shown(name)}; there are: {listed or 'none'}."
