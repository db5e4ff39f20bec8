"""The scenes of a model that are built: chosen by name or given, checked, with other defaults."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from codegen.check.declaration import check_model, check_scene
from codegen.declare.scene import Scene
from codegen.errors import ModelError, ParameterError, SceneError
from codegen.model import Model
from codegen.readers.names import nearest
from codegen.readers.values import finite_float, one_line, shown


def with_settings(model: Model, settings: Mapping[str, float]) -> Model:
    """A copy of the model with the other defaults of ``--set``, which hold in every scene."""
    problems = []
    parameters = dict(model.parameters)
    for name, value in settings.items():
        if name not in model.parameters:
            problems.append(
                f"model '{model.name}' has no parameter '{name}'; {nearest(name, model.parameters)}"
            )
        elif (number := finite_float(value)) is None:
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


def without_overridden(scene: Scene, settings: Mapping[str, float]) -> Scene:
    """The scene without its own values of the overridden parameters."""
    kept = tuple(pair for pair in scene.parameters if pair[0] not in settings)
    return replace(scene, parameters=kept)


def valid_scenes(model: Model, names: str | Scene | Sequence[str | Scene] | None) -> list[Scene]:
    """The checked scenes to build: ``default`` with all effects and drivers if none is declared."""
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
    problems = [problem for s in scenes for problem in check_scene(model, s)]
    if problems:
        raise ModelError(problems)
    return scenes
