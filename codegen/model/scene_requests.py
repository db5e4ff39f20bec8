"""Arguments of a scene as its request, and the parts of a scene that follow from others."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Any

from sympy import S

from codegen.declare.returned_terms import effect_expressions, friction_law
from codegen.declare.scene import ANALYSES, Request, Scene
from codegen.declare.state import states_in
from codegen.declare.symbols import Velocity
from codegen.declare.value_reader import Names, Reader
from codegen.declare.watched_conditions import WatchedCondition
from codegen.errors import ModelError
from codegen.model.connections import Connections
from codegen.model.fidelities import Fidelities
from codegen.model.requested_outputs import Outputs
from codegen.readers.names import name_problem


class SceneParts(Fidelities, Connections):
    """What takes part in a scene because of what else does."""

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

    @staticmethod
    def _values_without(request: Request, joints: set[str], effects: set[str]) -> dict[str, Any]:
        """Outputs and start values but for those of joints and effects that do not act."""
        outputs, gone = request.outputs, joints | effects
        if outputs is not None and gone:
            outputs = tuple(w for w in outputs if w.partition("(")[2].rstrip(")") not in gone)
        start = tuple(pair for pair in request.start if pair[0].rpartition(".")[0] not in joints)
        return {"outputs": outputs, "start": start}

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


DEFAULTS = {"frozen": False, "analysis": "dynamics", "outputs": None}
"""Keywords of a scene that an extension inherits unless it names them."""


class SceneRequests(SceneParts, Outputs):
    """What a modeller writes of a scene, read into its request."""

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
