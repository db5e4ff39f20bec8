"""Variants of a scene: scenes that differ from it by one effect left out or one other fidelity."""

from dataclasses import dataclass
from pathlib import Path

from codegen.declare.returned_values import replaced_body
from codegen.declare.scene import Scene
from codegen.model import Model
from codegen.model.base import TRACKED
from codegen.model.bodies import FORMS
from codegen.model.fidelities import NONE
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes


@dataclass(frozen=True)
class Variant:
    """One change of a scene: of an effect, coupler, body or group of alternatives of that kind."""

    name: str
    kind: str
    word: str  # new fidelity: "none" leaves an effect out, "link" puts a massless joint for a body
    by_leaving_out: bool

    def of(self, scene: Scene) -> Scene:
        """The scene with this change."""
        if self.by_leaving_out:
            return scene.without(self.name)
        return scene.with_(fidelity={self.name: self.word})

    @property
    def title(self) -> str:
        """``gas``, or ``rod as link``."""
        return self.name if self.word == NONE else f"{self.name} as {self.word}"


def declared(model: str | Path | Model, scene: str | Scene | None) -> tuple[Model, Scene]:
    """The model and one scene of it, the first unless one is named; errors as of `build`."""
    read = read_model(model).model
    return read, valid_scenes(read, scene)[0]


def variants(model: Model, scene: Scene, *, fidelities: bool = True) -> tuple[Variant, ...]:
    """Each effect left out; then, with `fidelities`, each other fidelity where there are several.

    In a kinematic scene no effect acts, but a link may replace a body.
    """
    acting = {} if scene.analysis == "kinematics" else model.acting(scene)
    acting = {
        name: effect
        for name, effect in acting.items()
        if effect.kind != TRACKED and name in scene.effects
    }
    found = [Variant(name, effect.kind, NONE, True) for name, effect in acting.items()]
    if not fidelities:
        return tuple(found)
    how = dict(scene.fidelity)
    found += [
        Variant(name, effect.kind, word, False)
        for name, effect in acting.items()
        for word, form in model.fidelities.get(name, {}).items()
        if not isinstance(form, str) and form is not effect
    ]
    for name, bodies in model.couplers.items():
        taken = how.get(name, FORMS[0])
        if taken != FORMS[0] or any(body.name in scene.bodies for body in bodies):
            found += [Variant(name, "coupler", word, False) for word in FORMS if word != taken]
    replaced = (replaced_body(joint) for joint in model.joints.values())
    found += [
        Variant(name, "body", "link", True)
        for name in dict.fromkeys(body.name for body in replaced if body is not None)
        if name in scene.bodies and name not in model.couplers
    ]
    for group, choices in model.groups.items():
        taken = model.choice(group, how, scene.effects)
        found += [Variant(group, "alternatives", word, False) for word in choices if word != taken]
    return tuple(found)
