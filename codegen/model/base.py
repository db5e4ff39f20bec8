"""The common state of a declaration: its elements, their names and the problems found."""

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import MISSING, Field, fields, replace
from functools import wraps
from inspect import isfunction, signature
from pathlib import Path
from types import MappingProxyType, NoneType, SimpleNamespace
from typing import Any, Literal, Self, TypeVar, get_args, get_origin

import sympy

from codegen.declare import symbols as sy
from codegen.declare.body import Bodies, Body, Ground, Particle, Point
from codegen.declare.element import Constraint, Effect, label
from codegen.declare.element_fields import Condition, Quantity
from codegen.declare.returned_values import own_coordinates
from codegen.declare.scene import Scene
from codegen.declare.space_body import SpaceBody, SpacePoint
from codegen.declare.state import Connection, State
from codegen.declare.symbols import dotted
from codegen.declare.value_reader import Reader, acting_while
from codegen.elements.registry import role
from codegen.readers.calls import declaring
from codegen.readers.values import name_problem, shown

Declared = TypeVar("Declared", bound=Constraint | Effect | Body)
Method = TypeVar("Method", bound=Callable[..., Any])
Place = Point | Body  # a body means its centre of mass
Pair = tuple[Any, Any]
Ends = tuple[Point, Point]


def _plain_text(value: Any) -> Any:
    """A text of numpy's as one of Python's; all else as it is."""
    return str(value) if isinstance(value, str) else value


def _marked(method: Callable[..., Any]) -> Callable[..., Any]:
    """The method of a model, which marks its element where it notes problems."""

    @wraps(method)
    def call(model: Any, *arguments: Any, **words: Any) -> Any:
        problems = model._read.problems
        before = len(problems)
        given = {word: _plain_text(value) for word, value in words.items()}
        element = method(model, *map(_plain_text, arguments), **given)
        if len(problems) > before and isinstance(element, Constraint | Effect):
            model.noted |= {str(element.name)}  # it may be a list
        return element

    return call


def shown_element(value: object) -> str:
    """A value in a message: an element by its kind and name."""
    return label(value) if isinstance(value, Constraint | Effect) else shown(value)


def declares(cls: type[Any], **renamed: str) -> Callable[[Method], Method]:
    """A decorator of a method without a body, which declares an element of the class.

    The fields of the class say how the arguments of their names are read; `renamed` has the fields
    whose arguments have other names.
    """

    def decorate(method: Method) -> Method:
        about = signature(method)

        @wraps(method)
        def declare(model: "Declarations", *arguments: Any, **words: Any) -> Any:
            given = about.bind(model, *arguments, **words)
            given.apply_defaults()
            del given.arguments["self"]
            return model._declare(model._element(cls, renamed, **given.arguments))

        return declare  # type: ignore[return-value]

    return decorate


TRACKED = "tracked point"  # kind of a point whose place is an output


class Declarations:
    """All that has been declared, by name; a name stands for one thing only."""

    in_space = False
    _ground_class: type[Body] = Ground

    def __init_subclass__(cls) -> None:
        """Let the public methods fail with errors of ours, and mark elements with stand-ins."""
        super().__init_subclass__()
        for word, method in list(vars(cls).items()):
            if isfunction(method) and not word.startswith("_"):
                setattr(cls, word, declaring("model")(_marked(method)))

    def __init__(self, name: str) -> None:
        self.name = name
        self.token = object()
        self.ground: Body = self._ground_class("ground", None, None, self.token)
        self.bodies: dict[str, Body] = {}
        self.parameters: dict[str, sy.ParameterDeclaration] = {}
        self.joints: dict[str, Constraint] = {}
        self.drivers: dict[str, Constraint] = {}
        self.effects: dict[str, Effect] = {}
        self.fidelities: dict[str, dict[str, Effect | str]] = {}
        self.groups: dict[str, dict[str, tuple[str, ...]]] = {}
        self.scenes: dict[str, Scene] = {}
        self.couplers: dict[str, Bodies] = {}
        self.states: dict[str, State] = {}
        self.connections: dict[str, Connection] = {}
        self.files: tuple[Path, ...] = ()
        self.noted: frozenset[str] = frozenset()  # hold stand-ins; no more is said of them
        self._read = Reader()
        self._note = self._read.note
        self._kinds: dict[str, str] = {"ground": "body"}
        if problem := name_problem("model", name):
            self._note(problem)

    def __repr__(self) -> str:
        return f"Model({self.name!r})"

    def altered(self, **tables: Any) -> Self:
        """A copy with other entries in some tables."""
        copied = copy(self)
        vars(copied).update({table: dict(entries) for table, entries in tables.items()})
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

    @property
    def effects_alone(self) -> dict[str, Effect]:
        """The effects, without points that bear the name of a joint."""
        return {name: one for name, one in self.effects.items() if name not in self.joints}

    def _value(self, value: Any, unit: str, where: str, sign: sy.SignRule = "") -> Any:
        """An expression in `unit`; a parameter that stands alone obeys the sign rule henceforth."""
        read = self._read.value(value, unit, where)
        if sign:
            self._bind(read, sign)
        return read

    def _bind(self, value: sympy.Expr, sign: sy.SignRule) -> None:
        """Let a parameter that stands alone obey the sign rule, too."""
        declared = self.parameters.get(value.name) if isinstance(value, sy.Parameter) else None
        if declared is not None and declared.sign != "positive":
            self.parameters[declared.name] = replace(declared, sign=sign)

    def _note_violated(self, where: str, *conditions: Condition) -> None:
        """Note what numbers violate, whatever the parameters."""
        for condition in conditions:
            for problem in condition.problems(where, {}) if condition.known else ():
                self._note(problem)

    def kind(self, name: str) -> str:
        """The role of a declared name: ``"body"``, ``"joint"``, ``"driver"`` and so on."""
        return self._kinds.get(name, "element")

    def _claim(self, kind: str, name: object) -> bool:
        if problem := name_problem(kind, name):
            self._note(problem)
            return False
        assert isinstance(name, str)
        known = self._kinds.get(name)
        shared = {known, kind} == {"joint", TRACKED}  # a pin and its point; each is declared once
        if known and not (
            shared and name not in (self.joints if kind == "joint" else self.effects)
        ):
            article = "an" if known[0] in "aeiou" else "a"
            self._note(
                f"{kind} '{name}': the name is already that of {article} {known}; "
                "give every element its own name."
            )
            return False
        self._kinds[name] = "joint" if shared else kind
        return True

    def _declare(self, element: Declared) -> Declared:
        """Declare an element among those of its role."""
        table: dict[str, Any] = self.effects
        word = "effect"
        if isinstance(element, Body):
            word, table = "particle" if isinstance(element, Particle) else "body", self.bodies
        elif element.kind == TRACKED:
            word = TRACKED
        elif isinstance(element, Constraint):
            is_driver = role(element.kind) == "driver"
            word, table = ("driver", self.drivers) if is_driver else ("joint", self.joints)
        self._put(word, table, element.name, element)
        return element

    def _put(self, kind: str, table: dict[str, Any], name: Any, declared: Any) -> None:
        """Put what is declared into its table, also under a wrong name, which others may use."""
        if self._claim(kind, name):
            table[name] = declared
        elif isinstance(name, str):
            self.noted |= {name}
            if not name_problem(kind, name):
                table.setdefault(name, declared)

    def _element(
        self, cls: type[Any], renamed: Mapping[str, str] = MappingProxyType({}), /, *,
        where: str = "", **given: Any,
    ) -> Any:  # fmt: skip
        """An element of the class, each field read from the argument of its name, or `renamed`.

        `where` is what the modeller wrote, if not the kind and the name of the class. Of what is
        not given, `joints` and `connections` are those of the model, `on` the bodies in the
        expressions.
        """
        where, read = where or f"{cls.kind} '{given['name']}'", SimpleNamespace()
        when = self._read.condition(given.get("when"), where, given.get("label", ""))
        for one in fields(cls):
            word = renamed.get(one.name, one.name)
            if word in given:
                value = self._field(one, word, given[word], where, read)
                if when is not None and one.metadata.get("gated"):
                    several = isinstance(value, tuple)
                    parts = (acting_while(x, when) for x in (value if several else (value,)))
                    value = tuple(parts) if several else next(parts)
            elif one.name in ("joints", "connections"):
                value = getattr(self, one.name)  # as it will be, with those declared later
            elif one.name == "on":
                given_so_far = vars(read).values()
                value = self._bodies_in(*(v for v in given_so_far if isinstance(v, sympy.Basic)))
            else:
                value = self.ground if one.default is MISSING else one.default
            setattr(read, one.name, value)
        return cls(**vars(read))

    def _field(
        self, one: Field[Any], word: str, value: Any, where: str, before: SimpleNamespace
    ) -> Any:
        """The value of a field, by its type; `before`: the fields before it."""
        if quantity := one.metadata.get("quantity"):
            return self._quantity(quantity, one, word, value, where, before)
        if one.type in (Point, SpacePoint):
            return self._point(before.name, value)
        if one.type is bool:
            return self._read.flag(value, f"{where}: {word}")
        if get_origin(one.type) is Literal:
            return self._read.choice(value, get_args(one.type), f"{where}, {word}")
        if one.type in (Body, SpaceBody, Body | None):
            if value is None and one.metadata.get("ground"):
                return self.ground
            is_left_out = value is None and NoneType in get_args(one.type)
            return None if is_left_out else self._body(f"{where}, {word}", value)
        return value

    def _quantity(
        self, read: Quantity, one: Field[Any], word: str, value: Any, where: str, before: Any
    ) -> Any:
        """One value, or as many as it has units; None where the type of the field has it."""
        unit, place = read.unit_of(before), f"{word} of {where}"
        if value is None and NoneType in get_args(one.type):
            return None
        if isinstance(unit, tuple):
            return self._read.vector(value, unit, place, word)
        if read.function_of and callable(value) and not isinstance(value, sympy.Basic):
            return self._read.result_of(value, read.function_of(before), unit, place)
        if read.is_law:
            self._note(
                f"{where}: {word}={shown(value)} is no function; write {word}=lambda s, rate: ..., "
                "or give an expression as actuator=."
            )
            return None
        return self._value(value, unit, place, read.binds)

    def _point(self, name: str, place: Any) -> Point:
        point = Point(place, 0, 0) if isinstance(place, Body) else place
        if not isinstance(point, Point) or not isinstance(point.body, Body):
            what = shown_element(place)
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

    def _body(self, where: str, body: Any) -> Body:
        """A body, where a point means nothing."""
        if isinstance(body, Body):
            return body
        what = f"Point of '{body.body.name}'" if isinstance(body, Point) else shown_element(body)
        self._note(f"{where}: {what} is no body; give a body as a whole.")
        return self.ground

    def _coordinates(self) -> tuple[sy.Coordinate, ...]:
        """Those of all bodies, and those that joints bring."""
        of_bodies = (q for body in self.bodies.values() for q in body.coordinates)
        of_joints = (q for joint in self.joints.values() for q in own_coordinates(joint))
        return (*of_bodies, *of_joints)

    def unit_of(self, name: str) -> str | None:
        """SI unit of a coordinate, velocity or state (``"crank.phi"``); None where it is none."""
        if name in self.states:
            return self.states[name].unit
        owner = name.rpartition(".")[0]
        own = own_coordinates(self.joints[owner]) if owner in self.joints else ()
        if owner in self.bodies:
            own = self.bodies[owner].coordinates
        wrong = "" if owner in self.noted else None  # of something of a wrong name
        return {dotted(s): s.unit for q in own for s in (q, q.rate)}.get(name, wrong)

    def _quantities(self) -> list[str]:
        """Names of all coordinates, velocities and states."""
        return [*(dotted(s) for q in self._coordinates() for s in (q, q.rate)), *self.states]

    def _bodies_in(self, *expressions: Any) -> Bodies:
        owners = {name for one in expressions for name in sy.owners(one)}
        for name in owners & {*self.joints}:
            owners |= {body.name for body in self.joints[name].bodies}
        return tuple(body for name, body in self.bodies.items() if name in owners)
