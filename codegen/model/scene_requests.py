"""The request of a scene, read from a modeller's arguments: elements, fidelities, outputs.

An element is declared once; each scene takes it as finely as its question needs.
"""

import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, cast

from sympy import S, Tuple

from codegen.declare.body import Bodies, Point
from codegen.declare.element import EXERTED, QUANTITIES, Effect, Reported, label
from codegen.declare.returned_values import (
    effect_expressions,
    friction_law,
    own_coordinates,
    statement_of,
)
from codegen.declare.scene import ANALYSES, Request, Scene, name_of
from codegen.declare.state import WatchedCondition, states_in
from codegen.declare.symbols import Coordinate, Parameter, Velocity, dotted, kinds
from codegen.declare.value_reader import Names, Reader
from codegen.drawing import shapes
from codegen.errors import ModelError
from codegen.model.base import TRACKED, Place, declares
from codegen.model.bodies import FORMS, MovingBodies
from codegen.model.connections import Connections
from codegen.model.expression_outputs import ExpressionOutputs
from codegen.readers.values import KindError, entries, name_problem, nearest, shown

NONE = "none"  # the fidelity of an effect that a scene does without

ALL = ("reactions", "energy", "powers")  # outputs of a scene that names none
DEFAULT = "default"  # the word for these; of powers those that make a balance with the energies
DERIVED = ("accelerations", "global_reactions")  # of points; in global axes
GROUPS = (*ALL, "points", "works", *(f"{quantity}s" for quantity in QUANTITIES), *DERIVED)
OF_POINTS = ("point", "acceleration")
SINGLE = (*OF_POINTS, "reaction", "global_reaction", "power", "work", *QUANTITIES)
ONE = re.compile(rf"({'|'.join(SINGLE)})\((\w+)\)\Z")
OF_ANALYSIS = {
    "dynamics": GROUPS,
    "equilibrium": tuple(g for g in GROUPS if g not in ("powers", "works", "accelerations")),
    "kinematics": tuple(f"{w}s" for w in (*OF_POINTS, *QUANTITIES) if w not in EXERTED),
}
"""Analysis → the groups of outputs that a scene for it may have, which ``"all"`` means."""


@dataclass(frozen=True, eq=False)
class TrackedPoint(Effect):
    """A point of a body, r + A s', as an effect without a force that reports where it is."""

    kind = TRACKED
    name: str
    point: Point

    def reported(self, bodies: Bodies) -> Reported:
        """Its global coordinates, m, and their rates, m/s; `derived` has the accelerations."""
        at = self.point
        places = tuple((c, "m", r) for c, r in zip("xyz", at.position, strict=False))
        return *places, *((f"v{c}", "m/s", v) for c, v in zip("xyz", at.velocity, strict=False))

    def shapes(self) -> shapes.Shapes:
        """The point, with its path."""
        return (shapes.Trace(self.point),)

    def problems(self) -> list[str]:
        """A point of the ground does not move."""
        if self.point.body.fixed:
            return [f"{label(self)} is a point of the ground; give one of a body."]
        return []


DEFAULTS = {"frozen": False, "analysis": "dynamics", "outputs": None}
"""Keywords of a scene that an extension inherits unless it names them."""


class SceneRequests(MovingBodies, Connections, ExpressionOutputs):
    """What a modeller writes of a scene, read into its request, and what follows from it."""

    def alternatives(
        self, name: str, choices: Mapping[str, Iterable[Any]], default: str | None = None
    ) -> str:
        """Elements that stand for one another, of which a scene takes one choice; returns `name`.

        Example: a follower that is held to its cam or may leave it. Each choice names the bodies,
        joints, effects and drivers that only it has. A scene with ``fidelity={name: choice}`` has
        the effects and drivers of this choice, and nothing of the others. A scene that names no
        choice has the bodies and joints of the default.

        Parameters
        ----------
        choices
            Choice, a word → elements, by name or by the objects that their declarations returned.
        default
            The first choice unless given.
        """
        where = f"alternatives '{name}'"
        known = self.elements
        read: dict[str, tuple[str, ...]] = {}
        like = "{'held': ['joint'], 'free': ['contact']}"
        for choice, elements in self._read.mapping(choices, "choices", like, where).items():
            if not isinstance(choice, str):
                self._note(f"{where}: choice {shown(choice)} is no word.")
            word = str(choice)
            names = self._read.names(elements, "elements", f"{where}, {word}", known)
            for missing in (n for n in names if n not in known):
                self._note(f"{where}, {word}: there is no '{missing}'; {nearest(missing, known)}")
            read[word] = tuple(n for n in names if n in known)
        if len(read) < 2:
            self._note(f"{where}: {len(read)} choice is no choice; give at least two.")
        if default is not None and str(default) not in read:
            self._note(f"{where}: no choice {shown(default)}; {nearest(str(default), read)}")
            default = None
        if self._claim("group of alternatives", name) and read:
            chosen = default or next(iter(read))
            self.groups[name] = {chosen: read[chosen]} | read
        return name

    def acting(self, scene: Scene) -> dict[str, Effect]:
        """Name → the effects of a scene, in the fidelity that it asks for, and rates of states."""
        how = dict(scene.fidelity)
        effects = {name: self._form(name, how) for name in scene.effects}
        for name in scene.unknown:  # which `scene_seeking` has found to be of one value
            effects[name] = cast(Any, effects[name]).exerting(Parameter(name, real=True))
        return effects | {name: self.states[name].effect for name in scene.states}

    def _form(self, name: str, how: Mapping[str, str]) -> Effect:
        """An effect in the fidelity that it is taken in."""
        form = self.fidelities.get(name, {}).get(how.get(name, ""))
        return self.effects[name] if form is None or isinstance(form, str) else form

    def _read_fidelities(
        self, read: Reader, where: str, fidelity: Any, couplers: Any
    ) -> tuple[tuple[str, str], ...]:
        """The fidelities that a scene names; impossible ones are noted as problems."""
        fidelities: dict[str, str] = {}
        for key, form in read.mapping(couplers, "couplers", "{'rod': 'link'}", where).items():
            name = name_of(key)
            if name in self.couplers:
                fidelities[name] = read.choice(form, FORMS, f"{where}, coupler '{name}'")
            else:
                read.note(f"{where}: there is no coupler '{name}'; {nearest(name, self.couplers)}")
        for key, word in read.mapping(fidelity, "fidelity", "{'rub': 'sticking'}", where).items():
            name = name_of(key)
            if problem := self._fidelity_problem(name, word, fidelities.get(name, word)):
                read.note(f"{where}: {problem}")
            else:
                fidelities[name] = word
        return tuple(fidelities.items())

    def _fidelity_problem(self, name: str, word: Any, named: Any) -> str | None:
        """Why an element cannot be taken as `word`; `named`: its form among the couplers."""
        if not isinstance(word, str):
            return (
                f"'{name}' with the fidelity {shown(word)}; a scene takes one at a time: "
                "give one word, or declare a scene for each."
            )
        if named != word:
            return f"'{name}' is asked for as '{named}' and as '{word}'; give one fidelity."
        if name in self.couplers:
            choices: Mapping[str, Any] = dict.fromkeys(FORMS)
        elif name in self.groups:
            choices = self.groups[name]
        elif name in self.effects:
            choices = self.fidelities.get(name, {}) | {NONE: ()}
            if len(choices) == 1 and word != NONE:
                return (
                    f"{self.effects[name].kind} '{name}' has one fidelity only, so it cannot be "
                    f"taken as '{word}'; leave fidelity= out."
                )
        else:
            hint = nearest(name, self.fidelities | self.groups | dict.fromkeys(self.couplers))
            return f"nothing called '{name}' has fidelities; {hint}"
        if word not in choices:
            return f"'{name}' cannot be taken as '{word}'; {nearest(word, choices)}"
        lacking = choices[word]
        return f"'{name}' as '{word}' {lacking}" if isinstance(lacking, str) else None

    def choice(self, group: str, how: Mapping[str, str], effects: Iterable[str]) -> str:
        """The alternative of a scene, by its fidelities `how` or by the effects that it names."""
        choices = self.groups[group]
        named = [word for word, names in choices.items() if {*effects}.intersection(names)]
        return how.get(group) or (named[0] if len(named) == 1 else next(iter(choices)))

    def _group_members(
        self, read: Reader, where: str, how: dict[str, str], effects: tuple[str, ...]
    ) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Elements that the choices of groups bring, and those that they leave out."""
        included: list[str] = []
        excluded: list[str] = []
        for group, choices in self.groups.items():
            choice = self.choice(group, how, effects)
            members = choices[choice]
            others = [n for names in choices.values() for n in names if n not in members]
            if clash := [n for n in others if n in effects]:
                read.note(
                    f"{where}: '{clash[0]}' acts only in another choice of '{group}' than "
                    f"'{choice}', which the scene takes; give fidelity={{'{group}': ...}} and "
                    "leave the other's effects out."
                )
            included += [n for n in members if n not in self.joints] if group in how else ()
            excluded += others
        return tuple(included), tuple(excluded)

    @declares(TrackedPoint)
    def track(self, name: str, point: Place) -> TrackedPoint:
        """A point whose place a scene may ask for, by ``outputs=["point(NAME)"]`` or ``"points"``.

        It may bear the name of a joint: ``C.x`` is the point's and ``C.fx`` the joint's, and scenes
        that leave out or take in ``C`` mean the joint.

        Parameters
        ----------
        point
            A point of a body; a body means its centre of mass.
        """

    @property
    def points(self) -> tuple[str, ...]:
        """Names of the tracked points."""
        return tuple(name for name, effect in self.effects.items() if effect.kind == TRACKED)

    def _output_points(self, request: Request, bodies: Iterable[str]) -> tuple[str, ...]:
        """Points that are outputs: all on the bodies that take part, or the named ones."""
        asked, present = {*(request.outputs or ())}, set(bodies)
        asked.update(owner for one in request.expressions for owner in one.owners)
        return tuple(
            name
            for name in self.points
            if asked & {name, *(f"{w}{of}" for w in OF_POINTS for of in ("s", f"({name})"))}
            if {body.name for body in self.effects[name].bodies} <= present
        )

    def _read_outputs(
        self, read: Reader, where: str, outputs: Any, analysis: Any
    ) -> tuple[str, ...] | None:
        """The words in a fixed order, each once; None for those of a scene that names none."""
        if outputs is None:
            return None
        try:
            given = [outputs] if isinstance(outputs, str | Mapping) else entries(outputs)
        except KindError:
            what = shown(outputs)
            read.note(
                f"{where}: outputs={what} is no list; write outputs=['energy', 'power(gas)']."
            )
            return None
        words = list[str]()
        given = [name_of(w) if isinstance(w, Coordinate | Velocity) else w for w in given]
        for word in (one for one in given if not isinstance(one, Mapping)):  # of expressions
            if isinstance(word, str) and word in ("all", DEFAULT):
                words += OF_ANALYSIS.get(analysis, GROUPS) if word == "all" else (DEFAULT,)
            elif problem := self._output_problem(word):
                read.note(f"{where}: {problem}")
            else:
                words.append(str(word))
        if words == [DEFAULT] or isinstance(outputs, Mapping):
            return None
        order = (DEFAULT, *GROUPS, *sorted({*words} - {DEFAULT, *GROUPS}))
        return tuple(word for word in order if word in words)

    def _output_problem(self, given: Any) -> str | None:
        word = given if isinstance(given, str) else shown(given)
        if word == "global_reactions" and self.in_space:
            return "reactions in space are in global axes; ask for 'reactions'."
        if word in (*GROUPS, "shaking") or word in self._countable:
            return None
        match = ONE.match(word)
        points = self.points
        acting = [*self.joints, *self.drivers, *(n for n in self.effects if n not in points)]
        if match is None:
            words = [f"{group}({n})" for group in SINGLE[2:6] for n in acting]
            words += [f"{quantity}({n})" for quantity in QUANTITIES for n in self.effects]
            words += [*(f"{word}({n})" for word in OF_POINTS for n in points), *self._countable]
            return f"no output {shown(given)}; {nearest(word, ('all', DEFAULT, *GROUPS, *words))}"
        group, name = match.groups()
        if group in OF_POINTS and name not in points:
            hint = nearest(name, points) if points else "declare it with model.track(...)."
            return f"no output '{word}', as there is no tracked point '{name}'; {hint}"
        if group not in OF_POINTS and name not in acting:
            return f"no output '{word}', as there is no '{name}'; {nearest(name, acting)}"
        return None

    @property
    def _countable(self) -> dict[str, str]:
        """Names of all that joints in space may count, and of its rates → the coordinate."""
        joints = (joint for joint in self.joints.values() if hasattr(joint, "countable"))
        own = (q for joint in joints for q in own_coordinates(joint))
        return {dotted(s): dotted(q) for q in own for s in (q, q.rate)}

    def _rubbing_in(
        self, effects: Iterable[str], joints: set[str], how: Mapping[str, str]
    ) -> set[str]:
        """The frictions among effects, as a scene takes them, that rub in these joints."""
        found = set()
        for name in ({*effects} & {*self.effects}) if joints else ():
            with suppress(ModelError):  # reported by `build`
                law = friction_law(self._form(name, how))
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
        laws = (law for body in bodies for _, law in body.laws)  # of masses
        found |= states_in(*(one.indicator for one in scene.until), *indicators, *laws)
        pending = found & {*self.states}
        while pending:
            parts = (e for name in pending for e in self.states[name].expressions)
            pending = {*states_in(*parts)} - found
            found |= pending
        return tuple(name for name in self.states if name in found - {*scene.request.without})

    def _counting(self, scene: Scene) -> Scene:
        """The scene with the coordinates of joints in space that something in it asks for."""
        known, bodies = self._countable, tuple(self.bodies[name] for name in scene.bodies)
        if not known:
            return scene
        expressions: list[Any] = [*self._connecting(scene), *(u.indicator for u in scene.until)]
        expressions += [one.expression for one in scene.expressions]
        expressions += [e for name in scene.states for e in self.states[name].expressions]
        for effect in self.acting(scene).values():
            with suppress(ModelError):  # reported by `build`
                expressions += effect_expressions(effect, bodies)
        acting = self._present(scene.bodies, scene.inactive_joints, self.joints)
        for one in [(self.joints | self.drivers)[name] for name in (*acting, *scene.drivers)]:
            with suppress(ModelError):
                expressions += (*(statement := statement_of(one)).phi, *statement.bindings.values())
        symbols = kinds(Tuple(*expressions), Coordinate, Velocity)
        words = scene.outputs or ()
        asked = {*map(dotted, symbols), *words, *(n for n, _ in (*scene.start, *scene.guess))}
        counted = dict.fromkeys(q for name, q in known.items() if name in asked)
        kept = tuple(word for word in words if word not in known)
        outputs = None if kept == (DEFAULT,) or scene.outputs is None else kept
        return replace(scene, counted=tuple(counted), outputs=outputs)

    def _read_request(
        self, read: Reader, where: str, effects: Names, drivers: Names, **words: Any
    ) -> tuple[Request, frozenset[str]]:
        """The request of a scene, and what of an inherited one its explicit keywords replace."""
        roles, quantities = self._roles(), (self.unit_of, self._quantities)
        named = {**self.effects_alone, **self.states}
        explicit = {key: words[key] for key in DEFAULTS if words[key] is not None}
        chosen = DEFAULTS | explicit
        request = Request(
            effects=read.elements(effects, named, "effect", where, roles),
            drivers=read.elements(drivers, self.drivers, "driver", where, roles),
            without=read.elements(words["without"], self.elements, "body or joint", where),
            fidelity=self._read_fidelities(read, where, words["fidelity"], words["couplers"]),
            start=read.states(words["start"], *quantities, "start", where),
            guess=read.states(words["guess"], *quantities, "guess", where),
            parameters=read.overrides(words["parameters"], self.parameters, where),
            frozen=read.flag(chosen["frozen"], f"{where}: frozen"),
            analysis=read.choice(chosen["analysis"], ANALYSES, f"{where}, analysis"),
            outputs=self._read_outputs(read, where, chosen["outputs"], chosen["analysis"]),
            expressions=tuple(self._read_expressions(read, where, chosen["outputs"])),
            until=self._read_until(read, where, words.get("until")),
        )
        emptied = {k for k in ("start", "guess", "parameters", "until") if words.get(k) == {}}
        return request, frozenset(explicit) | emptied

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
        gravity = f"declare it, as Model(..., gravity=(0, {'0, ' * self.in_space}-9.81)) does."
        return (
            {"gravity": gravity}
            | dict.fromkeys(self.bodies, f"it is a body, {always}")
            | dict.fromkeys(self.joints, f"it is a joint, {always}")
            | dict.fromkeys(self.drivers, "it is a driver; name it in drivers=.")
            | dict.fromkeys(self.effects_alone, "it is an effect; name it in effects=.")
        )
