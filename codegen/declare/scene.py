"""Scenes: the bodies, effects and drivers of a machine that take part in a question."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple, Protocol

import sympy

from codegen.declare.state import WatchedCondition
from codegen.declare.symbols import Coordinate, ResultSeries, Velocity, dotted, kinds
from codegen.errors import SceneError
from codegen.object_display import html_of, listed
from codegen.readers.calls import declaring_class, named_attributes
from codegen.readers.values import KindError, plain_number, shown

Analysis = Literal["dynamics", "kinematics", "equilibrium"]
ANALYSES = ("dynamics", "kinematics", "equilibrium")
Pairs = tuple[tuple[str, float], ...]


class ExpressionOutput(NamedTuple):
    """A series that a scene computes by an expression."""

    name: str
    expression: sympy.Expr  # of coordinates, velocities, states, parameters, t, and series
    unit: str  # of SI; empty where it is not known

    @property
    def series(self) -> list[ResultSeries]:
        """The series of results in it."""
        return kinds(self.expression, ResultSeries)

    @property
    def owners(self) -> set[str]:
        """Names of the bodies, states and elements to which something in it, or it, belongs."""
        places = kinds(self.expression, Coordinate, Velocity)
        series = {self.name.partition(".")[0], *(s.owner for s in self.series)}
        return series | {s.name.rpartition("_")[0] for s in places}


@dataclass(frozen=True, kw_only=True)
class Choices:
    """The fields that a scene shares with its request."""

    effects: tuple[str, ...] = ()
    drivers: tuple[str, ...] = ()
    fidelity: tuple[tuple[str, str], ...] = ()
    start: Pairs = ()
    guess: Pairs = ()
    parameters: Pairs = ()
    frozen: bool = False
    analysis: Analysis = "dynamics"
    outputs: tuple[str, ...] | None = None
    expressions: tuple[ExpressionOutput, ...] = ()
    until: tuple[WatchedCondition, ...] = ()
    unknown: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Request(Choices):
    """The request of a scene, by name and unresolved; an extension builds on it.

    `without` names bodies, joints, effects and drivers that do not take part; `fidelity` may name
    groups of alternatives too. `connected` are the joints that act of those that come and go;
    None: those at the start of a run.
    """

    without: tuple[str, ...] = ()
    connected: tuple[str, ...] | None = None

    def extended(self, by: "Request", explicit: frozenset[str]) -> "Request":
        """The request, overridden by that of an extension.

        `explicit`: keywords that the extension states, and mappings that it states as empty.
        """

        def both(key: str) -> tuple[Any, ...]:
            return (*getattr(self, key), *getattr(by, key))

        taken = {*by.effects, *by.drivers}
        gone = (n for n in self.without if n not in taken)
        changes: dict[str, Any] = {"without": tuple(dict.fromkeys((*gone, *by.without)))}
        changes |= {k: tuple(dict.fromkeys(both(k))) for k in ("effects", "drivers")}
        for key in ("fidelity", "start", "guess", "parameters"):
            changes[key] = tuple(dict(both(key)).items())
        changes["until"] = tuple({one.name: one for one in both("until")}.values())
        stated = {*explicit, *(("expressions",) if "outputs" in explicit else ())}
        return replace(self, **changes | {name: getattr(by, name) for name in stated})


def name_of(element: Any) -> str:
    """The name of an element that is given by its name or as an object; else what was given.

    Coordinates, velocities and states have the names of results, such as ``crank.phi``.
    """
    if isinstance(element, Coordinate | Velocity):
        return dotted(element)
    name = element if isinstance(element, str) else getattr(element, "name", None)
    return str(name) if isinstance(name, str) else shown(element)


def written(value: Any) -> str:
    """A keyword's value in the comment that says how a scene was varied: names and numbers."""
    if value is None or isinstance(value, bool):
        return str(value)
    if isinstance(value, str) or isinstance(getattr(value, "name", None), str):
        return repr(name_of(value))
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{written(k)}: {written(v)}' for k, v in value.items())}}}"
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(written, value))}]"
    try:
        return repr(plain_number(value))
    except KindError:
        return shown(value)


class Owner(Protocol):
    """The model that declared a scene, and can vary it."""

    @property
    def name(self) -> str:
        """Of the machine."""

    @property
    def points(self) -> tuple[str, ...]:
        """Names of the tracked points, which stand among the effects of a scene."""

    def reconnected(self, scene: "Scene", connected: tuple[str, ...]) -> "Scene":
        """The scene in which other joints act of those that come and go."""

    def varied(self, scene: "Scene", *, out: Any, taken: Any, **changes: Any) -> "Scene":
        """The scene with elements out and in, and other words changed."""


@named_attributes
@declaring_class("scene")
@dataclass(frozen=True, kw_only=True)
class Scene(Choices):
    """The elements that are compiled together, by name.

    Attributes
    ----------
    name
        An identifier.
    bodies
        The bodies that take part, in the order of their declaration.
    effects, drivers
        The effects and drivers that act; joints act where all their bodies take part.
    inactive_joints
        Joints that do not act although their bodies take part.
    states
        The states that take part, of first order or sampled.
    counted
        The coordinates of joints in space that something in it asks for, ``"A.angle"``.
    connected
        Of the joints that come and go in a run, those that act.
    fidelity
        Effect or coupler → its fidelity, if it has several and the scene chooses one.
    start
        Coordinate or velocity (``"crank.phi"``, ``"crank.omega"``) → value that must hold.
    guess
        The same → value from which assembly starts.
    parameters
        Parameter → value in this scene instead of the declared one.
    frozen
        Whether the parameters are folded into the code as numbers.
    analysis
        ``"kinematics"`` compiles no mass and no force, ``"equilibrium"`` nothing that only a motion
        needs.
    outputs
        The outputs computed in addition to the motion; None means those of ``"default"``.
    expressions
        Outputs that are expressions.
    until
        The conditions that end a run.
    unknown
        Effects whose values inverse dynamics seeks in place of those of drivers.
    request, owner
        The request that the scene resolves, and the model that declared it.
    expression, root, problems
        For a scene varied by `without` and `with_`: its expression, the declared scene, its faults.
    """

    name: str
    bodies: tuple[str, ...]
    inactive_joints: tuple[str, ...]
    states: tuple[str, ...] = ()
    counted: tuple[str, ...] = ()
    connected: tuple[str, ...] = ()
    request: Request = field(default=Request(), repr=False, compare=False)
    owner: Owner | None = field(default=None, repr=False, compare=False)
    expression: str = field(default="", repr=False, compare=False)
    root: "Scene | None" = field(default=None, repr=False, compare=False)
    problems: tuple[str, ...] = field(default=(), repr=False, compare=False)

    @property
    def follows(self) -> bool:
        """Whether a run comes into it from another scene, where joints come or go."""
        return self.request.connected is not None

    def without(self, *elements: Any) -> "Scene":
        """The scene with effects, drivers, joints or bodies left out, by name or object.

        The new scene is not declared; ``build`` and ``load`` accept it and report its problems.
        """
        return self._owner().varied(self, out=elements, taken=())

    def with_(self, *elements: Any, fidelity: Any = None, **changes: Any) -> "Scene":
        """The scene with further effects or drivers, or with bodies and joints restored.

        Parameters
        ----------
        fidelity
            A word, the fidelity of all these elements; or a mapping from any elements to
            fidelities.
        changes
            ``start``, ``guess``, ``parameters``, ``frozen``, ``analysis`` and ``outputs``, as in
            `Model.scene`.
        """
        words = fidelity
        if elements and fidelity is not None and not isinstance(fidelity, Mapping):
            words = {name_of(e): fidelity for e in elements}
        return self._owner().varied(self, out=(), taken=elements, fidelity=words, **changes)

    def _owner(self) -> Owner:
        if self.owner is None:
            raise SceneError(f"scene '{self.name}' belongs to no model, so it cannot be varied.")
        return self.owner

    @property
    def _points(self) -> tuple[str, ...]:
        return self.owner.points if self.owner else ()

    def __repr__(self) -> str:
        """Name, analysis, and what acts."""
        machine = f" of {self.owner.name}" if self.owner else ""
        acting = listed(e for e in self.effects if e not in self._points)
        acts = f"effects {acting}; drivers {listed(self.drivers)}"
        return f"Scene '{self.name}'{machine}, {self.analysis}: {acts}"

    def _repr_html_(self) -> str:
        """The scene read aloud, for notebooks."""
        return html_of(str(self))

    def __str__(self) -> str:
        """The scene read aloud, as a test plan."""
        machine = f" of {self.owner.name}" if self.owner else ""
        how = dict(self.fidelity)
        points = self._points
        named = (e for e in self.effects if e not in points)
        acting = [f"{e} ({how[e]})" if e in how else e for e in named]
        forms = [f"{name} as {word}" for name, word in how.items() if name not in self.effects]
        before, acts = self.root or self, {*self.effects, *self.drivers}
        gone = [n for n in (*before.effects, *before.drivers) if n not in acts]
        outputs = ("reactions", "energy", "powers") if self.outputs is None else self.outputs
        outputs += tuple(one.name for one in self.expressions)
        rows = {
            "bodies": self.bodies or ["none"],
            "acting": acting or ["nothing"],
            "driven by": self.drivers or ["nothing"],
            "points": [e for e in self.effects if e in points],
            "taken": forms,
            "left out": dict.fromkeys((*gone, *self.request.without)),
            "start": _values(self.start),
            "near": _values(self.guess),
            "parameters": _values(self.parameters),
        }
        lines = [f"  {word:<11} {', '.join(row)}" for word, row in rows.items() if row]
        lines += ["  parameters are fixed"] if self.frozen else []
        lines.append(f"  reported    {', '.join(outputs) or 'the motion alone'}")
        return "\n".join((f"{self.name}: {self.analysis}{machine}", *lines))


def _values(pairs: Pairs) -> list[str]:
    return [f"{name} = {value:g}" for name, value in pairs]
