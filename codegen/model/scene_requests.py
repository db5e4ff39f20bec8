"""Arguments of a scene as its request: what it names, and the values that it sets."""

from typing import Any

from sympy import S

from codegen.declare.name_rules_and_hints import name_problem
from codegen.declare.scene import ANALYSES, Request
from codegen.declare.value_reader import Names, Reader
from codegen.declare.watched_conditions import WatchedCondition
from codegen.model.requested_outputs import Outputs
from codegen.model.scene_parts import SceneParts

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
