"""What a modeller writes of a scene, read into its request, and the outputs that it asks for."""

import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from sympy import S

from codegen.declare.body import Body, Point
from codegen.declare.element import EXERTED, QUANTITIES, Effect, Reported, label
from codegen.declare.returned_values import effect_expressions, friction_law
from codegen.declare.scene import ANALYSES, Request, Scene
from codegen.declare.state import WatchedCondition, states_in
from codegen.declare.symbols import Velocity
from codegen.declare.value_reader import Names, Reader
from codegen.drawing import shapes
from codegen.errors import ModelError
from codegen.model.base import TRACKED, Declarations, Place, declares
from codegen.model.connections import Connections
from codegen.model.fidelities import Fidelities
from codegen.readers.values import KindError, entries, name_problem, nearest, shown

ALL = ("reactions", "energy", "powers")  # outputs of a scene that names none
GROUPS = (*ALL, "points", "works", *(f"{quantity}s" for quantity in QUANTITIES))
SINGLE = ("reaction", "power", "point", "work", *QUANTITIES)
ONE = re.compile(rf"({'|'.join(SINGLE)})\((\w+)\)\Z")
OF_ANALYSIS = {
    "dynamics": GROUPS,
    "equilibrium": tuple(group for group in GROUPS if group not in ("powers", "works")),
    "kinematics": ("points", *(f"{word}s" for word in QUANTITIES if word not in EXERTED)),
}
"""Analysis → the groups of outputs that a scene for it may have, which ``"all"`` means."""


@dataclass(frozen=True, eq=False)
class TrackedPoint(Effect):
    """A point of a body, r + A s', as an effect without a force that reports where it is."""

    kind = TRACKED
    name: str
    point: Point

    def reported(self, bodies: tuple[Body, ...]) -> Reported:
        """Its global coordinates, m, and their rates, m/s."""
        at = self.point
        return ("x", "m", at.x), ("y", "m", at.y), ("vx", "m/s", at.vx), ("vy", "m/s", at.vy)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """The point, with its path."""
        return (shapes.Trace(self.point),)

    def problems(self) -> list[str]:
        """A point of the ground does not move."""
        if self.point.body.fixed:
            return [f"{label(self)} is a point of the ground; give one of a body."]
        return []


class Outputs(Declarations):
    """Reads the outputs that a scene asks for."""

    @declares(TrackedPoint)
    def track(self, name: str, point: Place) -> TrackedPoint:
        """A point whose place a scene may ask for, by ``outputs=["point(NAME)"]`` or ``"points"``.

        Parameters
        ----------
        point
            A point of a body; a body means its centre of mass.
        """

    @property
    def points(self) -> frozenset[str]:
        """Names of the tracked points."""
        return frozenset(self._tracked())

    def _tracked(self) -> list[str]:
        """Names of the tracked points."""
        return [name for name, effect in self.effects.items() if effect.kind == TRACKED]

    def _output_points(
        self, outputs: tuple[str, ...] | None, bodies: Iterable[str]
    ) -> tuple[str, ...]:
        """Points that are outputs: all on the bodies that take part, or the named ones."""
        words, present = outputs or (), set(bodies)
        return tuple(
            name
            for name in self._tracked()
            if "points" in words or f"point({name})" in words
            if {body.name for body in self.effects[name].bodies} <= present
        )

    def _read_outputs(
        self, read: Reader, where: str, outputs: Any, analysis: Any
    ) -> tuple[str, ...] | None:
        """The words in a fixed order, each once; None for those of a scene that names none."""
        if outputs is None or (isinstance(outputs, str) and outputs == "default"):
            return None
        try:
            given = [outputs] if isinstance(outputs, str) else entries(outputs)
        except KindError:
            what = shown(outputs)
            read.note(
                f"{where}: outputs={what} is no list; write outputs=['energy', 'power(gas)']."
            )
            return None
        words = list[str]()
        for word in given:
            if isinstance(word, str) and word in ("all", "default"):
                words += OF_ANALYSIS.get(analysis, GROUPS) if word == "all" else ALL
            elif problem := self._output_problem(word):
                read.note(f"{where}: {problem}")
            else:
                words.append(str(word))
        order = (*GROUPS, *sorted(set(words) - set(GROUPS)))
        return tuple(word for word in order if word in words)

    def _output_problem(self, given: Any) -> str | None:
        word = given if isinstance(given, str) else shown(given)
        if word in GROUPS:
            return None
        match = ONE.match(word)
        points = self._tracked()
        acting = [n for n in (*self.joints, *self.drivers, *self.effects) if n not in points]
        if match is None:
            words = [f"{group}({n})" for group in ("reaction", "power", "work") for n in acting]
            words += [f"{quantity}({n})" for quantity in QUANTITIES for n in self.effects]
            words += [f"point({n})" for n in points]
            return f"no output {shown(given)}; {nearest(word, ('all', 'default', *GROUPS, *words))}"
        group, name = match.groups()
        if group == "point" and name not in points:
            hint = nearest(name, points) if points else "declare it with model.track(...)."
            return f"no output '{word}', as there is no tracked point '{name}'; {hint}"
        if group != "point" and name not in acting:
            return f"no output '{word}', as there is no '{name}'; {nearest(name, acting)}"
        return None


DEFAULTS = {"frozen": False, "analysis": "dynamics", "outputs": None}
"""Keywords of a scene that an extension inherits unless it names them."""


class SceneRequests(Outputs, Fidelities, Connections):
    """What a modeller writes of a scene, read into its request, and what follows from it."""

    def _rubbing_in(
        self, effects: Iterable[str], joints: set[str], how: Mapping[str, str]
    ) -> set[str]:
        """The frictions among effects, as a scene takes them, that rub in these joints."""
        found = set()
        for name in ({*effects} & {*self.effects}) if joints else ():
            form = self.fidelities.get(name, {}).get(how.get(name, ""))
            effect = self.effects[name] if form is None or isinstance(form, str) else form
            with suppress(ModelError):  # reported by `build`
                law = friction_law(effect)
                found |= {name} if law and law.joint in joints else set()
        return found

    def _states_of(self, scene: Scene, named: tuple[str, ...]) -> tuple[str, ...]:
        """The states that are `named` or that something which acts contains."""
        if scene.analysis != "dynamics":
            return ()
        bodies = tuple(self.bodies[name] for name in scene.bodies)
        found = {name for name in named if name in self.states}
        for effect in self.acting(scene).values():
            with suppress(ModelError):  # reported by `build`
                found |= states_in(*effect_expressions(effect, bodies))
        changes = (self.connections[name] for name in self._present(scene.bodies, ()))
        indicators = [e for one in changes for e in (one.released, one.engaged) if e is not None]
        found |= states_in(*(one.indicator for one in scene.until), *indicators)
        pending = found & {*self.states}
        while pending:
            parts = (e for name in pending for e in self.states[name].expressions)
            pending = {*states_in(*parts)} - found
            found |= pending
        return tuple(name for name in self.states if name in found - {*scene.request.without})

    def _with_names_of_states(self, effects: Names) -> Any:
        """The list of effects, a state by its name instead of its symbol."""
        symbols = {s.symbol: name for name, s in self.states.items()}
        if not symbols or not isinstance(effects, tuple | list):
            return effects
        return [symbols.get(e, e) if isinstance(e, Velocity) else e for e in effects]

    def _read_request(
        self, read: Reader, where: str, effects: Names, drivers: Names, **words: Any
    ) -> tuple[Request, frozenset[str]]:
        """The request of a scene, and its explicit keywords among those with a default."""
        units, roles, named = self._units(), self._roles(), self._with_names_of_states(effects)
        explicit = {key: words[key] for key in DEFAULTS if words[key] is not None}
        chosen = DEFAULTS | explicit
        request = Request(
            effects=read.elements(named, {**self.effects, **self.states}, "effect", where, roles),
            drivers=read.elements(drivers, self.drivers, "driver", where, roles),
            without=read.elements(words["without"], self.elements, "body or joint", where),
            fidelity=self._read_fidelities(read, where, words["fidelity"], words["couplers"]),
            start=read.states(words["start"], units, "start", where),
            guess=read.states(words["guess"], units, "guess", where),
            parameters=read.overrides(words["parameters"], self.parameters, where),
            frozen=read.flag(chosen["frozen"], f"{where}: frozen"),
            analysis=read.choice(chosen["analysis"], ANALYSES, f"{where}, analysis"),
            outputs=self._read_outputs(read, where, chosen["outputs"], chosen["analysis"]),
            until=self._read_until(read, where, words.get("until")),
        )
        return request, frozenset(explicit)

    def _read_until(self, read: Reader, where: str, until: Any) -> tuple[WatchedCondition, ...]:
        """The conditions that end a run, each with a name that nothing else has."""
        read_conditions = []
        for key, when in read.mapping(until, "until", "{'landed': ball.y < 0}", where).items():
            place = f"{where}, until"
            if problem := name_problem("condition", key):
                read.note(f"{place}: {problem}")
                continue
            if key in self._kinds:
                read.note(f"{place}: '{key}' is the name of a {self._kinds[key]}; give another.")
            if when is None:
                read.note(f"{place}: '{key}' is None; give a condition, such as ball.y < 0.")
                continue
            indicator = read.gated(S.One, "", f"{place}, '{key}'", when)
            read_conditions.append(WatchedCondition(key, indicator, "until"))
        return tuple(read_conditions)

    def _roles(self) -> dict[str, str]:
        """What a name that stands in the wrong list of a scene stands for."""
        always = "which takes part unless without= names it; leave it out of the list."
        gravity = "declare it, as Model(..., gravity=(0, -9.81)) does."
        return (
            {"gravity": gravity}
            | dict.fromkeys(self.bodies, f"it is a body, {always}")
            | dict.fromkeys(self.joints, f"it is a joint, {always}")
            | dict.fromkeys(self.drivers, "it is a driver; name it in drivers=.")
            | dict.fromkeys(self.effects, "it is an effect; name it in effects=.")
        )
