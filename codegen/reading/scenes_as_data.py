"""Scenes from data and as data: what `Model.scene` takes, in names, numbers and texts."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from codegen.declare.scene import Request, Scene
from codegen.declare.symbols import dotted, t
from codegen.errors import SceneError
from codegen.model import Model
from codegen.readers.quantities import UnitError, number_in, read_condition
from codegen.readers.values import nearest
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes

_VALUES = ("start", "guess", "parameters")


def scene_of_data(model: str | Path, data: Mapping[str, Any]) -> tuple[Model, Scene]:
    """The model of a file, and a scene that `data` declares in the words of `Model.scene`.

    It stands in place of a scene of the same name that the model declares. Conditions are texts,
    ``"ball.y < 0"``, and values numbers or texts with units.

    Raises SceneError or ModelError: all problems at once.
    """
    declared, problems = read_model(model).model, list[str]()
    words = dict(data)
    name = words.pop("name")
    where = f"scene '{name}'"
    if name in declared.scenes:
        if words.get("extends") == name:
            problems.append(f"{where}: it extends itself; give it another name.")
        others = {key: scene for key, scene in declared.scenes.items() if key != name}
        declared = declared.altered(scenes=others)
    of_parameters = {key: row.unit for key, row in declared.parameters.items()}
    for word in _VALUES:
        unit_of = of_parameters.get if word == "parameters" else declared.unit_of
        values = words.get(word, {})
        words[word] = {
            key: _number(value, unit_of(key) or "", f"{where}, {word}, {key}", problems)
            for key, value in values.items()
        }
    words["until"] = _conditions(declared, words.get("until", {}), where, problems)
    if problems:
        raise SceneError(problems)
    declared.scene(name, **words)
    return declared, valid_scenes(declared, name)[0]


def _number(value: Any, unit: str, where: str, problems: list[str]) -> Any:
    if not isinstance(value, str):
        return value
    try:
        return number_in(value, unit)
    except UnitError as error:
        problems.append(f"{where}: {error}")
        return 1.0


def _conditions(
    model: Model, texts: Mapping[str, str], where: str, problems: list[str]
) -> dict[str, Any]:  # fmt: skip
    """The conditions of a scene as expressions of its coordinates, velocities, states and time."""
    symbols: dict[str, Any] = {dotted(q): q for q in model._coordinates()}
    symbols |= {dotted(q.rate): q.rate for q in model._coordinates()}
    symbols |= {dotted(state.symbol): state.symbol for state in model.states.values()}
    symbols["t"] = t
    found = {}
    for name, text in texts.items():
        place = f"{where}, until, {name}"
        try:
            condition = read_condition(text)
            if condition.series not in symbols:
                hint = nearest(condition.series, symbols)
                problems.append(f"{place}: '{condition.series}' is no position or velocity; {hint}")
                continue
            unit = "s" if condition.series == "t" else model.unit_of(condition.series)
            value = number_in(condition.value, unit or "")
        except UnitError as error:
            problems.append(f"{place}: {error}")
            continue
        side = symbols[condition.series]
        found[name] = side < value if condition.sign == "<" else side > value
    return found


def data_of_scene(scene: Scene) -> dict[str, Any]:
    """A declared scene as data, with all that it extends; SceneError where it is more than data."""
    request = scene.request
    if request == Request() and (scene.effects or scene.drivers or scene.root is not None):
        raise SceneError(
            f"scene '{scene.name}' was varied and not declared; declare it by model.scene(), and "
            "give that."
        )
    if request.expressions:
        name = f"scene '{scene.name}': its output '{request.expressions[0].name}'"
        raise SceneError(f"{name} is an expression, which no case has; declare it in a model file.")
    if request.until:
        raise SceneError(
            f"scene '{scene.name}': its conditions of until= are expressions; write them as texts "
            'in the case, until: {landed: "ball.y < 0"}.'
        )
    data: dict[str, Any] = {"name": scene.name}
    for word in ("effects", "drivers", "without"):
        data |= {word: list(named)} if (named := getattr(request, word)) else {}
    for word in ("fidelity", *_VALUES):
        data |= {word: dict(pairs)} if (pairs := getattr(request, word)) else {}
    data |= {"frozen": True} if request.frozen else {}
    data |= {"analysis": request.analysis} if request.analysis != Request().analysis else {}
    data |= {"outputs": list(request.outputs)} if request.outputs is not None else {}
    return data
