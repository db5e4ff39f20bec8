"""The series of a scene's results: one table of their names, and the column that each is.

A series has one name of its own, and is found by others as well: ``force(strut)`` is `strut.force`,
``power(gas)`` is `gas`. This is the only place that knows how these names are written.
"""

from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from codegen.errors import InputError, UnknownNameError
from codegen.readers.values import shown
from runtime.mechanism.table_rows import TRACKED, ReactionRow, unknown

if TYPE_CHECKING:
    from runtime.mechanism.module_tables import Description

QUANTITIES = (
    "force", "torque", "length", "angle", "rate", "deflection", "gap", "penetration", "potential",
)  # fmt: skip
"""Quantities of effects that a scene may name as outputs, ``force(strut)``."""
ENERGIES = ("kinetic", "potential", "total")
PARTS = ("whole", "nonconservative")
POINT = "x", "y", "vx", "vy"  # components of a tracked point
KINDS = {
    "coordinate": "coordinates", "velocity": "velocities", "acceleration": "accelerations",
    "state": "states", "rate of state": "rates of states", "reaction": "reactions",
    "effect": "quantities of effects", "point": "points", "energy": "energies", "power": "powers",
}  # fmt: skip
"""Kind of a series → its plural, of those that messages list."""
_BY_UNIT = {"N": "force", "N m": "torque"}
_LISTED = 24  # layout: names of a kind that a message lists


class Series(NamedTuple):
    """A quantity over time: the column of an array that it is."""

    name: str  # its own
    # one of KINDS; or "bookkeeping": the integral of a state, the rate of a sampled value; or
    # "nonconservative power"; or "work", which results of simulations alone have
    kind: str
    array: str  # field of `Samples`, or "works"
    column: int  # of the array, (k, …); of a work that of its power; -1: the sum of all columns
    unit: str
    element: str  # body, state, joint, driver or effect to which it belongs; empty of energies
    component: str = ""  # of an element's reactions and quantities, as "fx", "force", "rate.x"
    quantity: str = ""  # of these the one of QUANTITIES of which it is a component; empty of others


def quantity_of(row: ReactionRow) -> str:
    """The quantity that a row of an effect is a component of; empty for others."""
    word = row.component.partition(".")[0]
    return word if word in QUANTITIES else _BY_UNIT.get(row.unit, "")


class SeriesTable:
    """The series of all results of a scene; `Description.series` has the scene's.

    Every lookup raises an InputError with the nearest names, the names that there are, or the
    output that the scene would have to name.
    """

    def __init__(self, description: "Description") -> None:
        self.description, self.title = description, description.title
        self.rows = (*_motion(description), *_exerted(description), *_energetic(description))

    def __iter__(self) -> Iterator[Series]:
        return iter(self.rows)

    def of_kind(self, *kinds: str) -> list[Series]:
        """The series of some kinds, in the order of the scene's tables."""
        return [row for row in self.rows if row.kind in kinds]

    @cached_property
    def names(self) -> dict[str, list[str]]:
        """Plural of a kind → own names of its series, of the kinds that there are."""
        found = {plural: [row.name for row in self.of_kind(k)] for k, plural in KINDS.items()}
        return {plural: names for plural, names in found.items() if names}

    @cached_property
    def _by_name(self) -> dict[str, Series]:
        """Series by their own names and all others."""
        powers = self.of_kind("power")
        found = {f"power({row.element})": row for row in powers}
        for element, quantity in self._components:
            if whole := self._component(element, quantity):
                found[f"{quantity}({element})"] = whole
                if whole.kind == "effect":
                    found[f"{element}.{quantity}"] = whole
        others = [row for row in self.rows if not row.kind.endswith("power")]
        return found | {row.name: row for row in (*powers, *reversed(others))}

    @cached_property
    def _components(self) -> dict[tuple[str, str], dict[str, Series]]:
        """Element and quantity → its components by name."""
        found = dict[tuple[str, str], dict[str, Series]]()
        for row in self.of_kind("reaction", "effect", "point"):
            found.setdefault((row.element, row.quantity), {})[row.component] = row
        return found

    def _component(self, element: str, quantity: str, component: str = "") -> Series | None:
        """A component of a quantity; unless named the whole, or the only one."""
        found = self._components.get((element, quantity), {})
        if component:
            return found.get(f"{quantity}.{component}", found.get(component))
        return found.get(quantity) or (next(iter(found.values())) if len(found) == 1 else None)

    def get(self, name: str) -> Series | None:
        """The series of any name; None where the scene has none of it."""
        return self._by_name.get(name)

    def find(self, name: str) -> Series:
        """The series of any name; InputError where the scene has none of it."""
        self._require_texts(name)
        if name in self._by_name:
            return self._by_name[name]
        owner, _, component = name.partition(".")
        if owner in self.description.effects.names and component in QUANTITIES:
            return self.of_effect(component, owner)
        if name in ENERGIES:
            return self.energy(name)
        word, _, rest = name.partition("(")
        if rest.endswith(")") and word in QUANTITIES:
            return self.of_effect(word, rest[:-1])
        if rest.endswith(")") and word in ("power", "work"):
            return self.power(rest[:-1]) if word == "power" else self.work(rest[:-1])
        raise UnknownNameError(f"{self.title}: {self.unknown(name)}")

    def unknown(self, name: str) -> str:
        """Sentences saying that a series does not exist: the nearest names; without any, all."""
        text = unknown("series", name, [one for names in self.names.values() for one in names])
        if "nearest" in text:
            return text
        lists = []
        for plural, names in self.names.items():
            more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
            lists.append(f"{plural} {', '.join(names[:_LISTED])}{more}")
        return f"There is no series {name!r}. There are: {'; '.join(lists)}."

    def coordinate(self, name: str, *, velocity: bool) -> int:
        """The column of a coordinate, by its name; or by that of its `velocity` as well."""
        self._require_texts(name)
        for column, row in enumerate(self.description.coordinates):
            if name == row.name or (velocity and name == row.velocity):
                return column
            if name == row.velocity:
                word, letter = ("state", "y") if row.is_state else ("velocity", "v")
                raise InputError(
                    f"{self.title}: There is no coordinate {name!r}: it is a {word}; "
                    f"ask for {letter}({name!r})."
                )
        rows = self.description.positions
        names = [row.name for row in rows] + [row.velocity for row in rows if velocity]
        raise self._unknown("coordinate", name, names)

    def state(self, name: str) -> Series:
        """A state of first order, a sampled value or a latch."""
        self._require_texts(name)
        if name not in self.description.states.names:
            raise self._unknown("state", name, self.description.states.names)
        return next(row for row in self.of_kind("state") if row.name == name)

    def point(self, name: str, component: str) -> Series:
        """A component of a tracked point."""
        self._require_texts(name, component)
        tracked, left_out = self.description.tracked, self.description.left_out
        if name in tracked:
            if component not in POINT:
                raise self._unknown(f"component of {name}", component, POINT)
            return self._by_name[f"{name}.{component}"]
        if name in left_out.names and left_out[name].kind == TRACKED:
            raise InputError(self.description.suggest_output(f"point({name})"))
        raise self._unknown("tracked point", name, tracked)

    def reaction(self, joint: str, component: str) -> Series:
        """A component of what a joint or driver transmits."""
        self._require_texts(joint, component)
        description, rows = self.description, self.of_kind("reaction", "effect")
        if joint in description.tracked:
            raise InputError(
                f"{self.title}: '{joint}' is a tracked point and transmits nothing; "
                f"ask for point({joint!r})."
            )
        of_joint = {row.component: row for row in rows if row.element == joint}
        if component in of_joint:
            return of_joint[component]
        if of_joint:
            raise InputError(
                f"{self.title}: joint {joint} has no reaction {component!r}; "
                f"it has {', '.join(of_joint)}."
            )
        joints = {row.element for row in description.constraints}
        if joint in joints | {*description.effects.names}:
            self._require_output("reaction", joint)
        raise self._unknown("reaction of", joint, dict.fromkeys(row.element for row in rows))

    def energy(self, part: str) -> Series:
        """An energy, one of ENERGIES."""
        self._require_texts(part)
        if part not in ENERGIES:
            raise InputError(unknown("energy", part, ENERGIES))
        if not self.description.has_masses:
            raise InputError(self.description.need_masses("energy"))
        self._require_output("energy")
        return _energy(part)

    def power(self, source: str, part: str = "whole") -> Series:
        """The power of an effect or driver: of all that it exerts, or of the nonconservative."""
        self._require_texts(source, part)
        if part not in PARTS:
            raise self._unknown("part of a power", part, PARTS)
        rows = {row.element: row for row in self.of_kind("power")}
        if part != "whole":  # of an effect without a potential the same
            undivided = self.description.powers.names
            rows = {name: row for name, row in rows.items() if name in undivided}
            rows |= {row.element: row for row in self.of_kind("nonconservative power")}
        if source in rows:
            return rows[source]
        if source in self._sources:
            self._require_output("power", source)
            if part == "nonconservative":
                raise InputError(
                    f"{self.title}: '{source}' has no forces without a potential; "
                    f"power({source!r}) is that of its potential."
                )
            raise InputError(self.description.suggest_output(f"power({source})"))
        raise self._unknown("power of", source, self._sources)

    def work(self, source: str) -> Series:
        """The work of an effect or driver, which results of simulations have."""
        self._require_texts(source)
        works = {row.element: row for row in self.of_kind("work")}
        if source in works:
            return works[source]
        if source in self._sources:
            raise InputError(self.description.suggest_output(f"work({source})"))
        raise self._unknown("work of", source, works or self._sources)

    @property
    def _sources(self) -> tuple[str, ...]:
        """Effects and drivers, which may have power and do work."""
        return (*self._acting, *self.description.drivers)

    @property
    def _acting(self) -> list[str]:
        tracked = self.description.tracked
        return [name for name in self.description.effects.names if name not in tracked]

    def of_effect(self, quantity: str, effect: str, component: str = "") -> Series:
        """A quantity of an effect; of a joint or driver its reaction, if it is a force."""
        self._require_texts(quantity, effect, component)
        found = self._component(effect, quantity, component)
        if found is not None:
            return found
        description = self.description
        every = [r for r in self.of_kind("reaction", "effect", "point") if r.element == effect]
        if names := [row.component for row in every if row.quantity == quantity]:
            names = [name.removeprefix(f"{quantity}.") for name in names]
            ways = ", ".join(f"{quantity}({effect!r}, {name!r})" for name in names)
            several = f"several components of {quantity}"
            what = f"no {quantity} {component!r}" if component else several
            raise InputError(f"{self.title}: {effect} has {what}; ask for {ways}.")
        if effect in {row.element for row in description.constraints}:
            self._require_output("reaction", effect)
            others = ", ".join(f"reaction({effect!r}, {row.component!r})" for row in every)
            raise InputError(
                f"{self.title}: '{effect}' is a joint or driver"
                + (f"; ask for {others}." if others else ", and transmits none.")
            )
        if effect in self._acting:
            outputs = {*(description.outputs or ())}
            if not outputs & {f"{quantity}s", f"{quantity}({effect})"}:
                raise InputError(description.suggest_output(f"{quantity}({effect})"))
            known = dict.fromkeys(row.quantity for row in every if row.quantity)
            has = f"it has {', '.join(known)}" if known else "and the scene asks for nothing of it"
            raise InputError(f"{self.title}: '{effect}' has no {quantity}; {has}.")
        if effect in description.left_out.names:
            raise InputError(
                f"{self.title}: '{effect}' does not act in this scene; load "
                f"scene.with_({effect!r}, outputs=['default', '{quantity}({effect})'])."
            )
        raise self._unknown(f"{quantity} of", effect, self._acting)

    def switch(self, condition: str) -> int:
        """The column of a switching condition, by its title, or by its effect if that has one."""
        self._require_texts(condition)
        switches = self.description.switches
        titles = [row.title for row in switches]
        if condition in titles:
            return titles.index(condition)
        of_effect = [k for k, row in enumerate(switches) if row.name == condition]
        if len(of_effect) == 1:
            return of_effect[0]
        raise self._unknown("condition", condition, titles)

    def _require_texts(self, *names: object) -> None:
        """Refuse names that are no texts."""
        for name in names:
            if not isinstance(name, str):
                raise InputError(
                    f"{self.title}: {shown(name)} is no name; a name is a text, such as "
                    f"{self.description.coordinates.names[0]!r} of a coordinate."
                )

    def _require_output(self, output: str, *element: str) -> None:
        """Refuse an output that the scene was declared without."""
        if self.description.leaves_out(output, *element):
            named = f"{output}({element[0]})" if element else output
            raise InputError(self.description.suggest_output(named))

    def _unknown(self, kind: str, name: str, names: Iterable[str]) -> InputError:
        return InputError(f"{self.title}: {unknown(kind, name, names)}")


def _motion(description: "Description") -> Iterator[Series]:
    """Coordinates, velocities, accelerations, and states with their rates."""
    table = [*enumerate(description.coordinates)]
    places = [(k, row, row.name.rpartition(".")[0]) for k, row in table if not row.is_state]
    for k, row, body in places:
        yield Series(row.name, "coordinate", "q", k, row.unit, body)
    for k, row, body in places:
        yield Series(row.velocity, "velocity", "v", k, row.velocity_unit, body)
    for k, row, body in places:
        yield Series(f"a({row.name})", "acceleration", "a", k, row.acceleration_unit, body)
    for state in description.states:
        yield Series(state.name, "state", "v", state.column, state.unit or "1", state.name)
    for k, row in table:
        if row.is_state:
            kind = "bookkeeping" if row.velocity in description.sampled else "rate of state"
            name, of = f"a({row.velocity})", row.velocity
            yield Series(name, kind, "a", k, row.acceleration_unit, of)
            yield Series(row.name, "bookkeeping", "q", k, row.unit, of)


def _exerted(description: "Description") -> Iterator[Series]:
    """Reactions, quantities of effects, and places of points."""
    effects, tracked = {*description.effects.names}, {*description.tracked}
    for k, row in enumerate(description.reactions):
        kind = "effect" if row.element in effects else "reaction"
        kind = "point" if row.element in tracked else kind
        own = row.element, row.component, quantity_of(row)
        yield Series(row.name, kind, "reaction", k, row.unit, *own)


def _energetic(description: "Description") -> Iterator[Series]:
    """Powers, works and energies."""
    for name, k in description.whole_powers.items():
        yield Series(name, "power", "power", k, "W", name)
    for k, row in enumerate(description.powers):
        if row.kind == "nonconservative":
            yield Series(row.name, "nonconservative power", "power", k, "W", row.name)
    for name, k in description.work_rows.items():
        yield Series(f"work({name})", "work", "works", k, "J", name)
    if description.has_masses and not description.leaves_out("energy"):
        yield from map(_energy, ENERGIES)


def _energy(part: str) -> Series:
    column = -1 if part == "total" else ENERGIES.index(part)
    return Series(part, "energy", "energy", column, "J", "")
