"""The scenes of a model that are built: chosen by name or given, checked, with other defaults.

Their variants differ by one effect left out, one other fidelity, or effects of sought values.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

from sympy import S

from codegen.check.declaration import check_model
from codegen.check.scene import check_scene
from codegen.declare.returned_values import measures_of, replaced_body
from codegen.declare.scene import Scene
from codegen.errors import ModelError, ParameterError, SceneError
from codegen.model import Model
from codegen.model.base import TRACKED
from codegen.model.bodies import FORMS
from codegen.model.scene_requests import DEFAULT, NONE
from codegen.readers.quantities import UnitError, finite_in_unit
from codegen.readers.values import nearest, one_line, shown
from codegen.reading.model_file import read_model


def with_settings(model: Model, settings: Mapping[str, float | str]) -> Model:
    """A copy of the model with the other defaults of ``--set``, which hold in every scene."""
    problems = []
    parameters = dict(model.parameters)
    for name, value in settings.items():
        if name not in model.parameters:
            problems.append(
                f"model '{model.name}' has no parameter '{name}'; {nearest(name, model.parameters)}"
            )
            continue
        try:
            number = finite_in_unit(value, model.parameters[name].unit)
        except UnitError as misfit:
            problems.append(f"parameter '{name}': {misfit}")
            continue
        if number is None:
            what = shown(value)
            problems.append(f"parameter '{name}' is {what}; give a finite number.")
        elif problem := model.parameters[name].problem(number):
            problems.append(problem)
        else:
            parameters[name] = replace(model.parameters[name], value=number)
    if problems:
        raise ParameterError(problems)
    scenes = {name: without_overridden(scene, settings) for name, scene in model.scenes.items()}
    altered: Model = model.altered(parameters=parameters, scenes=scenes)
    return altered


def without_overridden(scene: Scene, settings: Mapping[str, float | str]) -> Scene:
    """The scene without its own values of the overridden parameters."""
    kept = tuple(pair for pair in scene.parameters if pair[0] not in settings)
    return replace(scene, parameters=kept)


def valid_scenes(model: Model, names: str | Scene | Sequence[str | Scene] | None) -> list[Scene]:
    """The checked scenes to build: ``default`` with all effects and drivers if none is declared.

    Scenes that follow from others as joints come and go are left out where nobody names them and
    something is wrong: no run may ever come there.
    """
    problems = check_model(model)
    if problems:
        raise ModelError(problems)
    if not model.scenes:
        model = model.altered(scenes={})
        model.scene("default", effects=model.effects, drivers=model.drivers)
    chosen = (
        (names,) if isinstance(names, str | Scene) else model.scenes if names is None else names
    )
    by_name = [name for name in chosen if isinstance(name, str)]
    given = [scene for scene in chosen if isinstance(scene, Scene)]
    variants = [model.recompose(scene) for scene in given]
    missing = [
        f"model '{model.name}' has no scene '{one_line(name)}'; {nearest(name, model.scenes)}"
        for name in by_name
        if name not in model.scenes
    ]
    missing += [one_line(problem, 2000) for scene in variants for problem in scene.problems]
    if missing:
        raise SceneError(missing)
    scenes = [scene for name, scene in model.scenes.items() if name in by_name]
    scenes += [scene for scene in variants if scene not in scenes]
    found = [(s, check_scene(model, s)) for s in scenes]
    asked = [own for s, own in found if names is not None or not s.follows]
    if any(asked):
        raise ModelError(dict.fromkeys(chain.from_iterable(asked)))
    return [s for s, own in found if not own]


def scene_seeking(model: Model, scene: Scene, unknown: Sequence[str]) -> Scene:
    """The scene in which the values of effects are sought, with them among its outputs."""
    acting, bodies = model.acting(scene), tuple(model.bodies[name] for name in scene.bodies)
    sought = {n: e.exerting(S.One) for n, e in acting.items() if hasattr(e, "exerting")}
    found = [name for name, effect in sought.items() if effect is not None]
    problems = [
        f"scene '{scene.name}': '{name}' is no torque, line force, motor or force of one component "
        f"that acts, and has no value that could be sought; {nearest(name, found)}"
        for name in unknown
        if name not in found
    ]
    if problems:
        raise SceneError(problems)
    outputs = [*((DEFAULT,) if scene.outputs is None else scene.outputs), *scene.counted]
    outputs += [f"reaction({name})" for name in scene.drivers]
    for name in unknown:
        quantities = {one.quantity for one in measures_of(sought[name], bodies) or ()}
        outputs += [f"{word}({name})" for word in ("force", "torque") if word in quantities]
    request = replace(scene.request, unknown=tuple(unknown), frozen=False, outputs=tuple(outputs))
    return replace(
        scene, name=f"{scene.name}_unknown_{'_'.join(unknown)}", request=request, owner=None,
        root=scene.root or scene, expression=f"{model.name}.scene({scene.name!r}), unknown",
    )  # fmt: skip


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
