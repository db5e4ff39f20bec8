"""The common state of a declaration: its elements, their names and the problems found."""

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import replace
from functools import partial, wraps
from inspect import isfunction
from pathlib import Path
from typing import Any, Self, TypeVar

import sympy

from codegen.declare import symbols as sy
from codegen.declare.body import Body, Point
from codegen.declare.connection import Connection
from codegen.declare.element import Constraint, Effect
from codegen.declare.name_rules_and_hints import name_problem, nearest
from codegen.declare.particle_and_ground import Ground, Particle
from codegen.declare.return_values.bodies import coordinates_of
from codegen.declare.return_values.constraints import own_coordinates
from codegen.declare.return_values.elements import bodies_of
from codegen.declare.scene import Scene
from codegen.declare.state import State
from codegen.declare.symbols import dotted
from codegen.declare.value_reader import Reader
from codegen.elements.registry import role
from codegen.errors import ModelError, NoAttributeError
from codegen.model.units_on_demand import UnitsOnDemand, units_of
from codegen.plain_values import is_a, one_line, plain_name, shown
from codegen.public_callables import DeclaredTable, error_boundary

Declared = TypeVar("Declared", bound=Constraint | Effect | Body)
Place = Point | Body  # a body means its centre of mass
Pair = tuple[Any, Any]
Ends = tuple[Point, Point]


def _marked(method: Callable[..., Any]) -> Callable[..., Any]:
    """The method of a model, which marks its answer where it notes problems."""

    @wraps(method)
    def call(model: Any, *arguments: Any, **words: Any) -> Any:
        before = len(model._read.problems)
        answer = method(model, *arguments, **words)
        if len(model._read.problems) > before and isinstance(answer, Constraint | Effect):
            vars(model)["noted"] |= {plain_name(answer.name)}
        return answer

    return call


TRACKED = "tracked point"  # kind of a point whose place is an output
TABLES: dict[str, type[Any]] = {
    "bodies": Body, "parameters": sy.ParameterDeclaration, "joints": Constraint,
    "drivers": Constraint, "effects": Effect, "scenes": Scene, "fidelities": dict, "groups": dict,
    "couplers": tuple, "states": State, "connections": Connection,
}  # fmt: skip
"""Attributes of a model that list what is declared, by name, and the kind of their entries."""


class Declarations:
    """All that has been declared, by name; a name stands for one thing only."""

    name: str
    token: object
    ground: Ground
    bodies: dict[str, Body]
    parameters: dict[str, sy.ParameterDeclaration]
    joints: dict[str, Constraint]
    drivers: dict[str, Constraint]
    effects: dict[str, Effect]
    fidelities: dict[str, dict[str, Effect | str]]
    groups: dict[str, dict[str, tuple[str, ...]]]
    scenes: dict[str, Scene]
    couplers: dict[str, tuple[Body, ...]]
    states: dict[str, State]
    connections: dict[str, Connection]
    files: tuple[Path, ...]
    noted: frozenset[str]
    """Elements that hold stand-ins for what was noted; no more is said of them."""

    def __init_subclass__(cls) -> None:
        """Let the public methods fail with errors of ours, and mark elements with stand-ins."""
        super().__init_subclass__()
        for word, method in list(vars(cls).items()):
            if isfunction(method) and not word.startswith("_"):
                setattr(cls, word, error_boundary(_marked(method), "model"))

    def __init__(self, name: str) -> None:
        token = object()
        fixed = {"name": name, "token": token, "ground": Ground("ground", None, None, token)}
        vars(self).update(fixed, files=(), noted=frozenset())
        vars(self).update({table: DeclaredTable(f"model.{table}") for table in TABLES})
        self._read = Reader()
        self._note = self._read.note
        self._kinds: dict[str, str] = {"ground": "body"}
        if problem := name_problem("model", name):
            self._note(problem)

    def __repr__(self) -> str:
        return f"Model({shown(self.name)})"

    def __setattr__(self, word: str, value: object) -> None:
        """Refuse to replace what is declared."""
        self._keep(word, "set")
        super().__setattr__(word, value)

    def __delattr__(self, word: str) -> None:
        """Refuse to forget what is declared."""
        self._keep(word, "deleted")
        super().__delattr__(word)

    def __getattr__(self, word: str) -> Any:
        """Refuse a word that is none, with those that are like it."""
        hint = nearest(word, (w for w in dir(type(self)) if not w.startswith("_")))
        raise NoAttributeError(f"a model has no {one_line(word)!r}; {hint}")

    def _keep(self, word: str, verb: str) -> None:
        ours = (cls for cls in type(self).__mro__ if cls.__module__.startswith("codegen."))
        bare = type(self).__module__.startswith("codegen.model.")  # and no subclass with its own
        known = bare or any(word in vars(of) for of in (self, *ours))
        if known and not word.startswith("_"):
            raise NoAttributeError(
                f"model {shown(self.name)}: {word!r} cannot be {verb}; declare with the methods of "
                "the model, and a machine of another name as another model."
            )

    def _put(self, table: str, name: str, entry: object) -> None:
        vars(self)[table].declare(name, entry)

    @partial(error_boundary, owner="model")
    def altered(self, **tables: Any) -> Self:
        """A copy with other entries in some tables."""
        copied = copy(self)
        for table, entries in tables.items():
            kind = TABLES.get(table)
            if (
                kind is None
                or not isinstance(entries, Mapping)
                or not all(is_a(n, str) and is_a(entry, kind) for n, entry in entries.items())
            ):
                raise ModelError(
                    f"model.altered: {one_line(table)}={shown(entries)}; give mappings of the "
                    f"tables {', '.join(TABLES)}, each from names to entries of its kind."
                )
            vars(copied)[table] = DeclaredTable(f"model.{table}", entries)
        return copied

    @property
    def problems(self) -> tuple[str, ...]:
        """Problems of the declaration so far, one sentence each."""
        return tuple(self._read.problems)

    @property
    def labels(self) -> dict[sympy.Basic, str]:
        """Condition → what its events are called."""
        return dict(self._read.labels)

    @property
    def symbols(self) -> list[tuple[str, frozenset[sympy.Symbol]]]:
        """The symbols of the values that were given, each with its place in the declaration."""
        return self._read.symbols

    @property
    def defaults(self) -> dict[sympy.Symbol, float]:
        """Parameter → its default value."""
        return {p.symbol: p.value for p in self.parameters.values()}

    @property
    def elements(self) -> dict[str, Body | Constraint | Effect | State]:
        """All bodies, joints, effects, drivers and states by name."""
        return {**self.bodies, **self.joints, **self.effects, **self.drivers, **self.states}

    def _value(self, value: Any, unit: str, where: str, sign: sy.SignRule = "") -> Any:
        """An expression in `unit`; a parameter that stands alone obeys the sign rule henceforth."""
        read = self._read.value(value, unit, where)
        if sign and isinstance(read, sy.Parameter) and read.name in self.parameters:
            declared = self.parameters[read.name]
            if declared.sign != "positive":
                self._put("parameters", declared.name, replace(declared, sign=sign))
        return read

    def _optional(self, value: Any, unit: str, where: str, sign: sy.SignRule = "") -> Any:
        """The same of a value that may be left out, None."""
        return None if value is None else self._value(value, unit, where, sign)

    @partial(error_boundary, owner="model")
    def kind(self, name: str) -> str:
        """The role of a declared name: ``"body"``, ``"joint"``, ``"driver"`` and so on."""
        return self._kinds.get(name, "element")

    def _claim(self, kind: str, name: object) -> bool:
        if problem := name_problem(kind, name):
            self._note(problem)
            return False
        assert isinstance(name, str)
        if name in self._kinds:
            self._note(
                f"{kind} '{name}': the name is already that of a {self._kinds[name]}; "
                "give every element its own name."
            )
            return False
        self._kinds[name] = kind
        return True

    def _declare(self, element: Declared) -> Declared:
        """Declare an element among those of its role."""
        word, table = "effect", "effects"
        if isinstance(element, Body):
            word, table = "particle" if isinstance(element, Particle) else "body", "bodies"
        elif element.kind == TRACKED:
            word = TRACKED
        elif isinstance(element, Constraint):
            word = "driver" if role(element.kind) == "driver" else "joint"
            table = f"{word}s"
        name = plain_name(element.name)
        if self._claim(word, name):
            self._put(table, name, element)
        return element

    def _point(self, name: str, place: Any) -> Point:
        point = place.at(0, 0) if is_a(place, Body) else place
        if not is_a(point, Point) or not is_a(point.body, Body):
            what = shown(place)
            self._note(f"'{name}': {what} is neither a point nor a body; write body.at(x, y).")
            point = self.ground.at(0, 0)
        where = f"point of '{name}' on body '{point.body.name}'"
        before = self.problems
        sx, sy = (self._read.value(s, "m", where) for s in (point.sx, point.sy))
        self._note_speeds(where, sx, sy)
        if not (point.body.turns or sx == sy == 0):
            if self.problems == before:  # else the place is not the modeller's
                self._note(
                    f"{where} is ({sx}, {sy}) m off it, and a particle has no extent; write "
                    f"{point.body.name}.at(0, 0), or use a body."
                )
            sx = sy = sympy.S.Zero
        return Point(point.body, sx, sy)

    def _note_speeds(self, where: str, *place: sympy.Expr) -> None:
        """Note the velocities on which a place depends."""
        for speed in sy.kinds(sympy.Tuple(*place), sy.Velocity):
            self._note(
                f"{where} depends on the velocity {speed.name}; a place is an expression of t, "
                "coordinates and parameters."
            )

    def _body(self, where: str, body: Any, advice: str) -> Body:
        """A body, where a point means nothing."""
        if is_a(body, Body):
            return body
        at_point = is_a(body, Point) and is_a(body.body, Body)
        label = f"Point of '{body.body.name}'" if at_point else shown(body)
        self._note(f"{where}: {label} is no body; {advice}")
        return self.ground

    def _own_body(self, where: str, word: str, body: Any) -> Body | None:
        """A declared body of this model, or None, which stands in for anything else as well."""
        if body is None:
            return None
        if not is_a(body, Body):
            self._note(f"{where}: {word}={shown(body)} is no body; give one, or leave it out.")
        elif body.fixed:
            self._note(f"{where}: {word} is the ground, which always takes part; give a body.")
        elif self.bodies.get(body.name) is not body:
            self._note(f"{where}: {word} is body '{body.name}', which is not of this model.")
        else:
            return body
        return None

    def _pair(self, name: str, i: Any, j: Any) -> Ends:
        return self._point(name, i), self._point(name, j)

    def _coordinates(self) -> tuple[sy.Coordinate, ...]:
        """Those of all bodies, and those that joints bring."""
        of_bodies = (q for body in self.bodies.values() for q in coordinates_of(body))
        of_joints = (q for joint in self.joints.values() for q in own_coordinates(joint))
        return (*of_bodies, *of_joints)

    def _units(self) -> Mapping[str, str]:
        """Name of a coordinate, velocity or state (``"crank.phi"``) → its SI unit."""
        of_bodies = (q for body in self.bodies.values() for q in coordinates_of(body))
        return UnitsOnDemand(units_of(of_bodies), self._other_units)

    def _other_units(self) -> dict[str, str]:
        of_joints = (q for joint in self.joints.values() for q in own_coordinates(joint))
        return units_of(of_joints) | {dotted(s.symbol): s.unit for s in self.states.values()}

    def _bodies_in(self, *expressions: Any) -> tuple[Body, ...]:
        symbols = (s for e in expressions for s in sy.kinds(e, sy.Coordinate, sy.Velocity))
        owners = {s.name.rpartition("_")[0] for s in symbols}
        for name in owners & {*self.joints}:
            owners |= {body.name for body in bodies_of(self.joints[name])}
        return tuple(body for name, body in self.bodies.items() if name in owners)
