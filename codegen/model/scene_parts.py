"""The parts of a scene that follow from others: its states, and what goes with an absent joint."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Any

from codegen.declare.returned_terms import effect_expressions, friction_law
from codegen.declare.scene import Request, Scene
from codegen.declare.state import states_in
from codegen.declare.symbols import Velocity
from codegen.declare.value_reader import Names
from codegen.errors import ModelError
from codegen.model.connections import Connections
from codegen.model.fidelities import Fidelities


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
