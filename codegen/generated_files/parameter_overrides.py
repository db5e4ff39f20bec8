"""Parameter overrides: other defaults for one build, ``--set NAME=VALUE``."""

from collections.abc import Mapping
from copy import copy
from dataclasses import replace

from codegen.declare.names import nearest
from codegen.declare.scene import Scene
from codegen.errors import ParameterError
from codegen.model import Model


def with_settings(model: Model, settings: Mapping[str, float]) -> Model:
    """A copy of the model with other defaults, which hold in every scene."""
    problems = []
    changed = copy(model)
    changed.parameters = dict(model.parameters)
    for name, value in settings.items():
        if name not in model.parameters:
            problems.append(
                f"model '{model.name}' has no parameter '{name}'; {nearest(name, model.parameters)}"
            )
        elif problem := model.parameters[name].problem(value):
            problems.append(problem)
        else:
            changed.parameters[name] = replace(model.parameters[name], value=value)
    if problems:
        raise ParameterError(problems)
    changed.scenes = {
        name: without_overridden(scene, settings) for name, scene in model.scenes.items()
    }
    return changed


def without_overridden(scene: Scene, settings: Mapping[str, float]) -> Scene:
    """The scene without its own values of the overridden parameters."""
    kept = tuple(pair for pair in scene.parameters if pair[0] not in settings)
    return replace(scene, parameters=kept)
