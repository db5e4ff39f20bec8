"""An assembled state of a machine, and the findings about it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from codegen.errors import UnknownNameError
from codegen.object_display import html_of, html_table, listed, with_unit, without_rounding
from codegen.readers.calls import checked_class, named_attributes
from runtime.core.arrays import Vector
from runtime.integrate.problem import Discrete
from runtime.mechanism.spins import SPINS, spins
from runtime.mechanism.table_rows import Coordinate, Table, unknown


class DiscreteState(NamedTuple):
    """Samples that wait for their delay, and conditions that hold, by the names of a scene."""

    scene: str
    sampled: tuple[str, ...]  # values that clocks or conditions renew; a latch stands there twice
    clocks: Vector  # period and delay of each of them, s, (count, 2)
    watched: tuple[tuple[str, ...], ...]  # name, action and target of each condition
    stand: Discrete


class Moved(NamedTuple):
    """A coordinate or velocity that assembly moved from its start value."""

    name: str
    asked: float
    reached: float
    unit: str

    @property
    def by(self) -> float:
        """reached - asked."""
        return self.reached - self.asked


class Redundant(NamedTuple):
    """A constraint that follows from others: its name and joint, and the joints of those."""

    name: str
    element: str
    follows_from: tuple[str, ...]

    def __str__(self) -> str:
        """The finding as a sentence."""
        origin = f"follows from {', '.join(self.follows_from)}" if self.follows_from else "is empty"
        return f"Constraint {self.name} is redundant and consistent: it {origin}."


@named_attributes
@checked_class
@dataclass(frozen=True)
class State:
    """A state of a machine at time t in s: coordinates q and velocities v, shape (n,) each.

    `sampled` says whether clocks have renewed the values that are due at t; if not, a run that
    starts there renews them. `discrete` has samples that wait for their delay, and the conditions
    that hold; None where nothing is sampled or watched, or where that is unknown. `scene` names the
    scene whose joints act, empty where that is unknown.
    """

    t: float
    q: Vector
    v: Vector
    coordinates: Table[Coordinate] = field(default=Table(), repr=False)
    sampled: bool = field(default=False, repr=False)
    discrete: DiscreteState | None = field(default=None, repr=False)
    scene: str = field(default="", repr=False)

    def __getitem__(self, name: str) -> float:
        """Value of a coordinate or velocity by name."""
        return value_of(self, name)

    def __repr__(self) -> str:
        """The instant, and the values by name with their units."""
        if not self.coordinates:
            return f"State(t={self.t!r}, q={self.q!r}, v={self.v!r})"
        places = [row for row in self.coordinates if not row.is_state]
        values = [f"{row.name} = {with_unit(self[row.name], row.unit)}" for row in places]
        rates = ((row.velocity, row.velocity_unit) for row in self.coordinates)
        values += [f"{name} = {self[name]:.6g} {unit}".rstrip() for name, unit in rates]
        return f"State at t = {self.t:.9g} s: {', '.join(values)}"


def value_of(state: "State | Assembly", name: str) -> float:
    """A coordinate, a velocity, a component of ω' or a state of first order, by name."""
    for index, row in enumerate(state.coordinates):
        if type(name) is str and name in row[:2]:
            return float(state.q[index] if name == row.name else state.v[index])
    body, _, letter = str(name).rpartition(".")
    first = next((k for k, row in enumerate(state.coordinates) if row.name == f"{body}.e0"), None)
    if first is not None and letter in SPINS:
        p = slice(first, first + 4)
        return float(spins(state.q[p], state.v[p])[SPINS.index(letter)])
    names = [text for row in state.coordinates for text in (row.name, row.velocity)[row.is_state :]]
    raise UnknownNameError(unknown("coordinate, velocity or state", name, names))


@named_attributes
@checked_class
@dataclass(frozen=True)
class Assembly:
    """An assembled state at time t.

    Attributes
    ----------
    q, v
        Coordinates and velocities, shape (n,).
    residual, velocity_residual
        The largest Phi, and Phi_q v - nu, among the rows of each joint or driver.
    moved
        Coordinates and velocities that assembly moved away from their start values.
    singular
        Constraints that are dependent at this position only, as at a dead centre.
    redundant
        Constraints that follow from others at every position; the machine runs with them.
    not_unique
        Joints and drivers whose reactions are therefore not unique.
    independent
        Indices of the other constraints, shape (rank,).
    note
        Sentences on bodies that are far from their guesses, and on loops that are the mirror image.
    """

    t: float
    q: Vector
    v: Vector
    residual: Mapping[str, float]
    velocity_residual: Mapping[str, float]
    moved: tuple[Moved, ...]
    degrees_of_freedom: int
    singular: tuple[str, ...] = ()
    redundant: tuple[Redundant, ...] = ()
    not_unique: tuple[str, ...] = ()
    independent: tuple[int, ...] = ()
    coordinates: Table[Coordinate] = field(default=Table(), repr=False)
    note: str = ""

    def __getitem__(self, name: str) -> float:
        """Value of a coordinate or velocity by name."""
        return value_of(self, name)

    def __repr__(self) -> str:
        """The report, and the positions and velocities."""
        q_shown, v_shown = without_rounding(self.q), without_rounding(self.v)
        state = [*zip(self.coordinates, q_shown, v_shown, strict=False)]
        q = (f"{row.name} = {with_unit(x, row.unit)}" for row, x, _ in state if not row.is_state)
        v, y = (
            [f"{r.velocity} = {x:.6g} {r.velocity_unit}" for r, _, x in state if r.is_state is kind]
            for kind in (False, True)
        )
        return f"{self}\n  q  {listed(q)}\n  v  {listed(v)}" + (f"\n  y  {listed(y)}" if y else "")

    def _repr_html_(self) -> str:
        """The report with a table of positions and velocities, for notebooks."""
        rows = (
            (row.name, q, row.unit, row.velocity, v, row.velocity_unit)
            for row, q, v in zip(
                self.coordinates, without_rounding(self.q), without_rounding(self.v), strict=False
            )
            if not row.is_state
        )
        head = ("coordinate", "value", "unit", "velocity", "value", "unit")
        return html_of(self._with_states, html_table(head, rows))

    @property
    def _with_states(self) -> str:
        return "\n".join(x for x in repr(self).splitlines() if x[:5] not in ("  q  ", "  v  "))

    @property
    def is_determined(self) -> bool:
        """Whether joints and drivers leave nothing to integrate: no freedom and no state."""
        return self.degrees_of_freedom == 0 and not any(row.is_state for row in self.coordinates)

    def __str__(self) -> str:
        """The report as text."""
        worst = max(self.residual.values(), default=0.0)
        worst_rate = max(self.velocity_residual.values(), default=0.0)
        states = sum(row.is_state for row in self.coordinates)
        freedom = f"{self.degrees_of_freedom}{f', states: {states}' if states else ''}"
        head = f"Assembled at t = {self.t:g} s, degrees of freedom: {freedom}; "
        lines = [f"{head}largest residual {worst:.1e}, of velocities {worst_rate:.1e}."]
        lines += [
            f"  {row.name} moved from {row.asked:.6g} to {with_unit(row.reached, row.unit)}"
            for row in self.moved
        ]
        lines += [f"  {self.note}"] if self.note else []
        if self.singular:
            lines.append(f"  Singular position: {', '.join(self.singular)} have no hold here.")
        lines += [f"  {row}" for row in self.redundant]
        if self.not_unique:
            lines.append(f"  Not unique: the reactions of {', '.join(self.not_unique)}.")
        return "\n".join(lines)
