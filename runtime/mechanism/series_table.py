"""The series of a scene's results: one table of their names and columns.

A series has one name of its own, and is found by the calls of a result as well: ``force(strut)`` is
`strut.force`, ``power(gas)`` is `gas`. This is the only place that knows how these are written.
"""

from collections import Counter
from collections.abc import Iterable, Iterator
from functools import cached_property
from itertools import groupby, product
from typing import TYPE_CHECKING, NamedTuple

from codegen.errors import InputError, UnknownNameError
from codegen.object_display import listed
from codegen.readers.values import shown
from runtime.mechanism.table_rows import TRACKED, ReactionRow, unknown

if TYPE_CHECKING:
    from runtime.mechanism.module_tables import Description

QUANTITIES = (
    "force", "torque", "length", "angle", "rate", "deflection", "gap", "penetration", "potential",
)  # fmt: skip
"""Quantities of effects that a scene may name as outputs, ``force(strut)``."""
ENERGIES = ("kinetic", "potential", "total")
_EXERTED = ("force", "torque", "potential", "power", "work")  # of masses or forces
_BY_UNIT = {"N": "force", "N m": "torque"}
_DERIVED = {
    **dict.fromkeys(("ax", "ay", "az"), "acceleration"),
    **dict.fromkeys(("global_fx", "global_fy"), "global_reaction"),
}
"""Component of a point or joint → the output that has it."""
_NAMED = {
    **dict.fromkeys("qva", "coordinate"), "y": "state", "point": "tracked point",
    "energy": "energy", "mode": "condition", "share": "condition",
}  # fmt: skip
"""Word of a call → what it names, where that is no element."""


class UnnamedOutputError(UnknownNameError):
    """An output that a scene does not name, and that follows from its states."""


Call = tuple[str, str, str]
"""A method of `Result`, and its arguments: an element, coordinate or condition, and a component."""


class Series(NamedTuple):
    """A quantity over time: the column of an array that it is."""

    name: str  # its own
    # "coordinate", "velocity", "spin", of ω', "rotation", of A, "acceleration", "state", "rate of
    # state", "reaction", "effect", "point", "expression", "energy", "power", "nonconservative
    # power", "work", of simulations alone; "bookkeeping": the integral of a state, the rate of a
    # sampled value; a "residual"; or the "mode" or "share" of a condition
    kind: str
    array: str  # field of `Samples`, or "works", "spin" or "rotation"
    # of the array, (k, …); of a work that of its power; -1: the sum of all columns; of a spin three
    # times the column of e0, plus its axis; of a rotation nine times, plus the place of the entry
    column: int
    unit: str
    element: str  # body, state, joint, driver or effect to which it belongs; empty of energies
    component: str = ""  # of an element's reaction, or of an effect's quantity, as "fx", "x"
    quantity: str = ""  # of these the one of QUANTITIES of which it is a component; empty of others

    @property
    def heading(self) -> str:
        """The name of its column in a table."""
        if self.kind == "energy":
            return f"{self.name} energy"
        return f"{self.kind}({self.name})" if self.kind.endswith("power") else self.name


def quantity_of(row: ReactionRow) -> str:
    """The quantity that a row of an effect is a component of; empty for others."""
    word = row.component.partition(".")[0]
    return word if word in QUANTITIES else _BY_UNIT.get(row.unit, "")


class SeriesTable:
    """The series of all results of a scene; `Description.series` has the scene's.

    Every lookup raises an InputError with the nearest names, the calls that there are, or the
    output that the scene would have to name.
    """

    def __init__(self, description: "Description") -> None:
        self.description, self.title = description, description.title
        found = [*_motion(description), *_exerted(description), *_energetic(description)]
        self.rows = tuple(row for row, _ in found)
        found += [*_residuals(), *_conditions(description)]
        self._every = [row for row, _ in found]  # those of residuals and conditions, too
        # several calls may mean one series; the first says best what it is
        self._by_call = {call: row for row, calls in found for call in calls}

    def __iter__(self) -> Iterator[Series]:
        return iter(self.rows)

    def of_kind(self, *kinds: str) -> list[Series]:
        """The series of some kinds, in the order of the scene's tables."""
        return [row for row in self._every if row.kind in kinds]

    @cached_property
    def _by_name(self) -> dict[str, Series]:
        """Series by the names of columns and their own; a source of power has no other's name."""
        named = {row.heading: row for row in self._every if row.kind not in ("mode", "share")}
        rows = [row for row in reversed(self.rows) if row.kind != "nonconservative power"]
        return named | {row.name: row for row in sorted(rows, key=lambda row: row.kind != "power")}

    def get(self, name: str) -> Series | None:
        """The series of any name; None where the scene has none of it."""
        return self._by_name.get(name) or self._by_call.get(self._call_of(name))

    def find(self, name: str) -> Series:
        """The series of any name; InputError where the scene has none of it."""
        self._require_texts(name)
        row, (word, of, _) = self.get(name), self._call_of(name)
        if row is not None:
            return row
        if counting := self.description.suggest_counting(name):
            raise InputError(counting)
        if word in (*QUANTITIES, "power", "work") or (word == "energy" and of in ENERGIES):
            raise self._refusal(word, of, "")
        text = f"{self.title}: {self.unknown(name)}"
        owner, _, part = name.partition(".")
        for output in ("point", "reaction"):
            refusal = self._refusal(output, owner, part)
            if isinstance(refusal, UnnamedOutputError) or owner == "ground":
                raise refusal
        raise (UnnamedOutputError if owner in self._quiet else UnknownNameError)(text)

    @property
    def _quiet(self) -> set[str]:
        """What may have series that the scene does not name; a kinematic one leaves effects out."""
        about, all_idle = self.description, self.description.analysis == "kinematics"
        idle = (row.name for row in about.left_out if all_idle or row.kind == TRACKED)
        return {*about.effects.names, *idle, *(row.element for row in about.constraints)}

    def call(self, word: str, name: str, component: str = "") -> Series:
        """The series that a method of `Result` gives; InputError where the scene has none of it."""
        self._require_texts(name, component)
        found = self._by_call.get((word, name, component))
        if found is None:
            raise self._refusal(word, name, component)
        return found

    def _call_of(self, name: str) -> Call:
        """What a name asks for: ``force(strut)`` and `strut.force` are one call."""
        word, _, rest = name.partition("(")
        if rest.endswith(")"):
            return word, rest[:-1], ""
        element, _, quantity = name.partition(".")
        known = element in self.description.effects.names
        return (quantity, element, "") if known else ("energy", name.removesuffix(" energy"), "")

    def unknown(self, name: str) -> str:
        """Sentences saying that a series does not exist: the nearest names; without any, all."""
        known = [r for r in self.rows if r.kind not in ("bookkeeping", "nonconservative power")]
        text = unknown("series", name, [row.name for row in known])
        kinds = groupby(known, lambda row: row.kind)
        lists = "; ".join(f"{kind} {listed(row.name for row in rows)}" for kind, rows in kinds)
        return text if "nearest" in text else f"There is no series {name!r}; there are: {lists}."

    def _refusal(self, word: str, name: str, component: str) -> InputError:
        """What to say of a call that is none: the output to ask for, or the calls there are."""
        about, ways = self.description, dict[Series, Call]()
        if word in ("q", "v", "a") and (counting := about.suggest_counting(name)):
            return InputError(counting)
        joints = dict.fromkeys(row.element for row in about.constraints)
        output = "reaction" if word in QUANTITIES and name in joints else word
        acting = [one for one in about.effects.names if one not in about.tracked]
        able: dict[str, Iterable[str]] = {  # what may have the output, if the scene asks for it
            **dict.fromkeys(QUANTITIES, acting), "reaction": joints, "energy": ENERGIES,
            **dict.fromkeys(("power", "work"), (*acting, *about.drivers)),
            "point": [row.name for row in about.left_out if row.kind == TRACKED],
        }  # fmt: skip
        calls = [call for call in self._by_call if call[:2] == (word, name)]
        if component in _DERIVED and calls:
            return UnnamedOutputError(about.suggest_output(f"{_DERIVED[component]}({name})"))
        if name == "ground" and about.has_masses and not calls:
            return InputError(about.suggest_output("shaking"))
        if name in able.get(output, ()) and not (calls and component not in ("", "whole")):
            written = output if word == "energy" else f"{output}({name})"
            exerted = word in _EXERTED and about.analysis == "kinematics"
            if exerted or (word == "energy" and not about.has_masses):
                return InputError(about.need_masses(written))
            whole = word == "power" and component != "nonconservative"  # none by default
            named = about.outputs or () if whole else about.asked
            asked = {output, f"{output}s", written} & {*named}
            if not asked or word == "work":
                refusal = InputError if word == "work" else UnnamedOutputError
                return refusal(about.suggest_output(written))
        kind = f"{component} power" if component == "nonconservative" else word
        kind = _NAMED.get(word, f"{kind} of")
        what = f"There is no {kind} {name!r}"
        if calls:
            wanting = f"no {word} {component!r}" if component else f"several components of {word}"
            what = f"'{name}' has {wanting}"
        elif word not in ("mode", "share"):
            for call, row in self._by_call.items():
                if call[1] == name:
                    ways.setdefault(row, call)
            calls = [*ways.values()]
        if calls:
            texts = (f"{of}({', '.join(map(repr, filter(None, rest)))})" for of, *rest in calls)
            return InputError(f"{self.title}: {what}; ask for {', '.join(texts)}.")
        if word in (*QUANTITIES, "power", "work") and name in about.left_out.names:
            return (UnnamedOutputError if name in self._quiet else InputError)(
                f"{self.title}: '{name}' does not act in this scene; load "
                f"scene.with_({name!r}, outputs={about.outputs_with(f'{output}({name})')})."
            )
        known = [call[1] for call in self._by_call if call[0] == word]
        names = dict.fromkeys(one for one in (*known, *able.get(output, ())) if one != name)
        return InputError(f"{self.title}: {unknown(kind, name, names)}")

    def _require_texts(self, *names: object) -> None:
        """Refuse names that are no texts."""
        for name in names:
            if not isinstance(name, str):
                raise InputError(
                    f"{self.title}: {shown(name)} is no name; a name is a text, such as "
                    f"{self.description.coordinates.names[0]!r} of a coordinate."
                )


Found = Iterator[tuple[Series, list[Call]]]
"""Series, each with the calls that mean it."""


def _motion(description: "Description") -> Found:
    """Coordinates, velocities, accelerations, and states with their rates."""
    table = [*enumerate(description.coordinates)]
    places = [(k, row, row.name.rpartition(".")[0]) for k, row in table if not row.is_state]
    for kind, word, names, unit in (
        ("coordinate", "q", ("name",), "unit"),
        ("velocity", "v", ("velocity", "name"), "velocity_unit"),
        ("acceleration", "a", ("name", "velocity"), "acceleration_unit"),
    ):
        for k, row, body in places:
            called = [getattr(row, name) for name in names]
            own = f"a({row.name})" if word == "a" else called[0]
            calls = [(word, name, "") for name in called]
            yield Series(own, kind, word, k, getattr(row, unit), body), calls
    for name, (first, axis) in description.spins.items():
        body = name.rpartition(".")[0]
        yield Series(name, "spin", "spin", 3 * first + axis, "rad/s", body), [("v", name, "")]
    for body, first in description.turning:
        for k, (a, b) in enumerate(product("xyz", repeat=2)):
            name = f"{body}.A{a}{b}"
            yield Series(name, "rotation", "rotation", 9 * first + k, "1", body), []
    for name, k, unit, _ in description.states:
        yield Series(name, "state", "v", k, unit or "1", name), [("y", name, ""), ("v", name, "")]
    for k, row in table:
        if row.is_state:
            kind = "bookkeeping" if row.velocity in description.sampled else "rate of state"
            name, of = f"a({row.velocity})", row.velocity
            yield Series(name, kind, "a", k, row.acceleration_unit, of), [("a", of, "")]
            yield Series(row.name, "bookkeeping", "q", k, row.unit, of), []


def _exerted(description: "Description") -> Found:
    """Reactions, quantities of effects, and places of points."""
    effects, tracked = {*description.effects.names}, {*description.tracked}
    count = Counter((quantity_of(row), row.element) for row in description.reactions)
    for k, row in enumerate(description.reactions):
        of, quantity = row.element, quantity_of(row)
        part = row.component.removeprefix(quantity).removeprefix(".")
        reaction, own = ("reaction", of, row.component), [(quantity, of, part)]
        if count[quantity, of] == 1:  # the only component is the whole
            own.insert(0, (quantity, of, ""))
        if not row.component:
            kind, calls = "expression", []
        elif of in tracked and row.unit in ("m", "m/s", "m/s^2"):  # a joint may bear its name
            kind, part, calls = "point", row.component, [("point", of, row.component)]
        elif of in effects - tracked:
            kind, calls = "effect", [*own, reaction]
        else:
            kind, part, calls = "reaction", row.component, [reaction, *own]
        yield Series(row.name, kind, "reaction", k, row.unit, of, part, quantity), calls


def _energetic(description: "Description") -> Found:
    """Powers, works and energies."""
    undivided = description.powers.names  # without forces of a potential
    for name, k in description.whole_powers.items():
        parts = ["", "whole", "nonconservative"][: 2 + (name in undivided)]
        yield Series(name, "power", "power", k, "W", name), [("power", name, x) for x in parts]
    for k, (name, kind) in enumerate(description.powers):
        if kind == "nonconservative":
            row = Series(name, "nonconservative power", "power", k, "W", name)
            yield row, [("power", name, "nonconservative")]
    for name, k in description.work_rows.items():
        yield Series(f"work({name})", "work", "works", k, "J", name), [("work", name, "")]
    if description.has_masses and "energy" in description.asked:
        for part, column in zip(ENERGIES, (0, 1, -1), strict=True):
            yield Series(part, "energy", "energy", column, "J", ""), [("energy", part, "")]


def _residuals() -> Found:
    """Residuals of constraints and of their rates, which have no unit."""
    for column, word in enumerate(("constraint", "velocity")):
        yield Series(f"{word} residual", "residual", "residual", column, "", ""), []


def _conditions(description: "Description") -> Found:
    """Modes and shares of conditions, which tables of series leave out."""
    effects = [row.name for row in description.switches]
    for k, row in enumerate(description.switches):
        names = [row.title, row.name] if effects.count(row.name) == 1 else [row.title]
        for word, array in (("mode", "modes"), ("share", "share")):
            yield Series(row.title, word, array, k, "1", row.name), [(word, n, "") for n in names]
