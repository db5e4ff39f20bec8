"""What users call and set: wrong calls, read-only declarations, failures of their own functions."""

import copy
import pickle
import stat
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
import sympy
from pandas import Series
from pint import Quantity

from codegen import (
    ConjugateReaction,
    Coordinate,
    Curve,
    Effect,
    I,
    LinkwrightError,
    Model,
    ModelError,
    Point,
    Scene,
    Statement,
    build,
    coordinate,
    element,
    given,
    t,
)
from codegen.files.whole_files import whole_file
from codegen.reading.scene_selection import valid_scenes


def machine() -> Model:
    """A model of a body and a particle under gravity."""
    model = Model("m", gravity=(0, -9.81))
    model.body("a", mass=1.0, inertia=0.1)
    model.particle("p", mass=1.0)
    return model


WRONG: dict[str, Callable[[Model], Any]] = {
    "build()": lambda m: build(),  # type: ignore[call-arg]
    "build(): got an unexpected keyword argument 'foo'": lambda m: build(m, foo=1),  # type: ignore[call-arg]
    "Model": lambda m: Model(),  # type: ignore[call-arg]
    "model.table": lambda m: m.table(),  # type: ignore[call-arg]
    "model.body 'c'": lambda m: m.body("c", 1, 2, 3),  # type: ignore[call-arg]
    "body.at of 'a'": lambda m: m.bodies["a"].at(1),  # type: ignore[call-arg]
    "table": lambda m: m.table("l", range(5), range(5))(),  # type: ignore[call-arg]
    "Point": lambda m: Point(),  # type: ignore[call-arg]
    "Curve": lambda m: Curve(1),  # type: ignore[call-arg, arg-type]
    "Statement": lambda m: Statement(),  # type: ignore[call-arg]
    "ConjugateReaction": lambda m: ConjugateReaction(),  # type: ignore[call-arg]
    "frame.bind": lambda m: I.bind(),  # type: ignore[call-arg]
    "scene": lambda m: Scene(),  # type: ignore[call-arg]
    "coordinate": lambda m: coordinate(),  # type: ignore[call-arg]
    "given": lambda m: given(),  # type: ignore[call-arg]
    "element": lambda m: element(1, 2),  # type: ignore[call-overload]
    "model.altered": lambda m: m.altered(1),
    "model.kind": lambda m: m.kind(),
}


@pytest.mark.parametrize("title", WRONG)
def test_a_wrong_call_says_what_is_taken_and_what_was_given(title: str) -> None:
    with pytest.raises(LinkwrightError) as caught:
        WRONG[title](machine())
    assert str(caught.value).lower().startswith(title.lower())
    assert "it takes (" in str(caught.value)
    assert "was given (" in str(caught.value)


class _Mute(type):
    """A class of classes that do not say what they are called."""

    def __getattribute__(cls, word: str) -> Any:
        if word == "__name__":
            raise RuntimeError(word)
        return type.__getattribute__(cls, word)


class _Nameless(metaclass=_Mute):
    pass


@pytest.mark.parametrize("function", [coordinate, Model.scene, build])
def test_a_wrong_call_with_an_object_of_a_class_that_says_nothing(
    function: Callable[..., Any],
) -> None:
    with pytest.raises(LinkwrightError, match="it takes"):
        function(_Nameless(), *range(20))


NONSENSE: dict[str, Callable[[Model], Any]] = {
    "LinkwrightError": lambda m: LinkwrightError(7),  # type: ignore[arg-type]
    "ModelError: problems of type list": lambda m: ModelError([7]),  # type: ignore[list-item]
    "frame.bind(": I.bind,  # type: ignore[dict-item]
    "table 'l' of 5 points is called": lambda m: m.table("l", range(5), range(5))(
        Quantity(m.bodies["a"], "m")
    ),
    "body.torque of 'a'": lambda m: m.bodies["a"].torque("x"),  # type: ignore[arg-type]
    "model.place_of": lambda m: m.place_of(m.bodies["a"], 7),  # type: ignore[arg-type]
    "point of body 'a'": lambda m: m.bodies["a"].at("q", 0).x,
    "point of body 'p'": lambda m: m.bodies["p"].at([1], None).vx,
    "curve of body 'a'": lambda m: m.bodies["a"].curve("x", "y").at(sympy.pi),
    "curve.at('x')": lambda m: m.bodies["a"].circle(1).at("x"),  # type: ignore[arg-type]
    "point of 'a'": lambda m: Point("a", 0, 0).x,  # type: ignore[arg-type]
    "coordinate(3, 'x')": lambda m: coordinate(3, "x"),  # type: ignore[arg-type]
    "Coordinate takes a name": lambda m: Coordinate(sympy.Dummy("a")),  # type: ignore[arg-type]
    "Coordinate takes": lambda m: Coordinate("a_x", real=[1]),
    "model.altered: scenes=3": lambda m: m.altered(scenes=3),
    "model.altered: zz={}": lambda m: m.altered(zz={}),
    "model.altered: bodies={'q': 3}": lambda m: m.altered(bodies={"q": 3}),
    "model.acting: None is no scene": lambda m: m.acting(None),
    "model.recompose: 'x' is no scene": lambda m: m.recompose("x"),
    "model.varied: 3 is no scene": lambda m: m.varied(3, out=(), taken=()),
    "model.choice('zz', {}, ...)": lambda m: m.choice("zz", {}, ()),
    "model 'm': 'spring'": lambda m: setattr(m, "spring", 3),
    "model 'm': 'torque'": lambda m: delattr(m, "torque"),
    "Particle 'p': 'at'": lambda m: delattr(m.bodies["p"], "at"),
    "scene 's', varied: fidelity=": lambda m: valid_scenes(
        m, [_with(m).scenes["s"].with_(fidelity=[1])]
    ),
    "dry friction 'f' has both slip= and axis=": lambda m: valid_scenes(_with_axis(m), None),
    "given(None)": lambda m: given(None),  # type: ignore[arg-type]
    "ConjugateReaction.along(['x'])": lambda m: ConjugateReaction.along(["x"]),  # type: ignore[arg-type]
    "table 'l'": lambda m: m.table("l", range(5), range(5))(10**400),
    "scene 's': effect": lambda m: valid_scenes(_with(m, effects={"gravity": 1}), None),
}


def _with_axis(model: Model) -> Model:
    slip = model.bodies["p"].vx
    model.dry_friction("f", coefficient=0.2, normal=1, axis=(0, 1), slip=slip)
    return _with(model)


def _with(model: Model, **words: Any) -> Model:
    model.scene("s", **words)
    return model


@pytest.mark.parametrize("start", NONSENSE)
def test_nonsense_is_named_where_it_stands(start: str) -> None:
    with pytest.raises(LinkwrightError) as caught:
        NONSENSE[start](machine())
    assert str(caught.value).startswith(start)


def test_what_is_no_name_has_no_role() -> None:
    assert machine().kind(["a"]) == machine().kind({}) == "element"  # type: ignore[arg-type]


def test_a_models_own_table_lists_its_effects() -> None:
    model = machine()
    assert model.scene("s", effects=model.effects).effects == ("gravity",)


def test_what_is_declared_cannot_be_replaced() -> None:
    model = machine()
    scene = model.scene("s", effects=["gravity"])
    body = model.bodies["a"]
    model.revolute("pin", model.ground.at(0, 0), body.at(1, 0))
    changes: list[Callable[[], Any]] = [
        lambda: model.bodies.__setitem__("z", 5),  # type: ignore[arg-type]
        lambda: model.effects.pop("gravity"),
        lambda: model.parameters.update(z=5),  # type: ignore[arg-type]
        model.scenes.clear,
        lambda: delattr(model, "bodies"),
        lambda: setattr(model, "name", "a\nb"),
        lambda: setattr(model, "problems", ()),
        lambda: setattr(body, "name", "z"),
        lambda: setattr(body.at(1, 0), "sx", 2),
        lambda: setattr(scene, "name", "../z"),
        lambda: delattr(scene, "effects"),
        lambda: setattr(model.joints["pin"], "name", "z"),
        lambda: model.revolut("pin"),
    ]
    for change in changes:
        with pytest.raises(ModelError):
            change()
    assert set(model.bodies) == {"a", "p"}
    assert [s.name for s in valid_scenes(copy.deepcopy(model), None)] == ["s"]
    with pytest.raises(AttributeError, match="did you mean 'revolute'"):
        _ = model.revolut


def test_what_nothing_reads_is_not_set() -> None:
    model = machine()
    for owner, title in (
        (model, "model 'm'"),
        (model.bodies["p"], "Particle 'p'"),
        (model.ground, "Ground 'ground'"),
        (model.bodies["a"].at(0, 0), "Point"),
        (model.scene("s", ["gravity"]), "Scene 's'"),
    ):
        with pytest.raises(AttributeError, match=f"{title}: 'friction' cannot be set"):
            owner.friction = 0.1  # type: ignore[attr-defined, union-attr]

    class Crane(Model):
        """A model with a number of its own."""

    crane = Crane("crane")
    crane.reach = 3.0  # type: ignore[attr-defined]
    assert crane.reach == 3.0


def test_a_scene_that_is_changed_by_hand_is_read_again() -> None:
    model = machine()
    scene = model.scene("s", effects=["gravity"])
    changes: list[dict[str, Any]] = [
        {"name": "../x\nimport os"},
        {"bodies": ("nothing",)},
        {"effects": 5},
        {"start": (("a.phi", "x"),)},
        {"outputs": (5,)},
        {"fidelity": (("gravity", 7),)},
        {"request": None},
        {"expression": 7, "root": scene},
        {"start": iter([("a.phi", 0.0)])},
        {"start": {"a.phi": 0.0}},
        *({word: None} for word in ("effects", "fidelity", "start", "guess", "parameters")),
    ]
    for change in changes:
        with pytest.raises(LinkwrightError, match=r"scene 's'|'\.\./x") as caught:
            valid_scenes(model, replace(scene, **change))
        assert "fails with" not in str(caught.value)


def test_what_a_subclass_says_of_its_problems_is_not_asked() -> None:
    class Silent(Model):
        problems = property(lambda self: 1 / 0)  # type: ignore[assignment]

    with pytest.raises(ModelError, match="no body"):
        valid_scenes(Silent("q"), None)


class Breaking(BaseException):
    """Somebody's own way to end."""


@pytest.mark.parametrize("kind", [SystemExit, GeneratorExit, RecursionError, Breaking])
def test_what_a_callback_raises_is_an_answer_of_the_element(kind: type[BaseException]) -> None:
    def fails(*_: Any) -> Any:
        raise kind

    model = machine()
    model.spring("s", model.ground, model.bodies["p"], force=fails)
    model.add(type("Own", (Effect,), {"kind": "own", "name": "o", "forces": fails})())
    with pytest.raises(ModelError) as caught:
        valid_scenes(model, None)
    assert any(p.startswith("force of spring 's'") for p in caught.value.problems)
    assert any("own 'o'" in p for p in caught.value.problems)


def test_the_wish_to_stop_passes() -> None:
    def stop(*_: Any) -> Any:
        raise KeyboardInterrupt

    model = machine()
    with pytest.raises(KeyboardInterrupt):
        model.spring("s", model.ground, model.bodies["p"], force=stop)


def test_a_progress_that_raises_is_the_users_and_loses_nothing(tmp_path: Path) -> None:
    def report(line: str) -> None:
        raise ZeroDivisionError(line)

    model = machine()
    model.scene("s", effects=["gravity"])
    with pytest.raises(ZeroDivisionError) as caught:
        build(model, out=tmp_path, compile=False, progress=report)
    assert "progress=" in caught.value.__notes__[0]
    assert (tmp_path / "m__s.py").is_file()
    with pytest.raises(LinkwrightError, match="called with one text"):
        build(model, out=tmp_path, compile=False, progress=lambda a, b: None)  # type: ignore[misc, arg-type]


def test_expressions_too_deep_for_python_are_refused_with_advice() -> None:
    model = machine()
    deep = model.bodies["p"].x
    for _ in range(280):
        deep = sympy.sin(deep, evaluate=False)
    model.force("f", on=model.bodies["p"], fx=deep)
    with pytest.raises(ModelError, match=r"'f'.*too deep.*model\.table"):
        valid_scenes(model, None)


def test_conditions_that_jump_with_coordinates_are_refused() -> None:
    model = machine()
    x = model.bodies["a"].x
    model.force("f", on=model.bodies["a"], when=x > sympy.ceiling(x))
    with pytest.raises(ModelError, match=r"ceiling\(a_x\) jumps"):
        valid_scenes(model, None)


@pytest.mark.parametrize("unit", ["N·m", "N⋅m", "m^(1/2)", "kg m^(-3/2)"])
def test_units_of_parameters_are_units_of_reports(unit: str) -> None:
    def reported(self: Any, bodies: Any) -> Any:
        return (("pull", unit, sympy.Float(1)),)

    def forces(self: Any, bodies: Any) -> Any:
        return {body.x: sympy.cos(t)}

    model = machine()
    body = model.bodies["p"]
    model.parameter("k", 1.0, unit=unit)
    words = {"kind": "own", "name": "o", "forces": forces, "reported": reported}
    model.add(type("Own", (Effect,), words)())
    assert valid_scenes(model, None)


def test_a_whole_file_keeps_links_modes_and_the_errors_of_others(tmp_path: Path) -> None:
    file, link = tmp_path / "a.txt", tmp_path / "link"
    file.write_text("old")
    file.chmod(0o600)
    link.symlink_to(file)
    with whole_file(link) as path:
        path.write_text("new")
    assert link.is_symlink()
    assert file.read_text() == "new"
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    with pytest.raises(FileNotFoundError), whole_file(file) as path:  # noqa: PT012
        path.write_text("newer")
        (tmp_path / "nothing").read_text()
    assert file.read_text() == "new"


def test_a_sum_with_powers_of_powers_of_numbers_is_never_written() -> None:
    """To sort the terms of a sum for its text, SymPy compares them, and would never end."""
    model = machine()
    tower = sympy.Integer(9)
    for _ in range(3):
        tower = sympy.Pow(9, tower, evaluate=False)
    total = model.bodies["a"].x + tower
    model.force("f", on=model.bodies["a"], fx=total)
    model.parameter("k", [total])
    model.cam_follower("c", model.bodies["a"].circle(tower), model.bodies["p"].circle(1))
    with pytest.raises(ModelError) as caught:
        valid_scenes(model, None)
    assert any("a number beyond 1e308" in problem for problem in caught.value.problems)


@pytest.mark.parametrize("method", ["revolute", "body", "gravity"])
def test_methods_called_on_the_class_say_what_they_take(method: str) -> None:
    with pytest.raises(ModelError, match=rf"model\.{method}"):
        getattr(Model, method)()


@pytest.mark.parametrize("word", ["name", "is_Add", "unit", "args", "free_symbols"])
def test_symbols_of_a_model_stay_as_they_are(word: str) -> None:
    """SymPy has one object for all symbols of a name: a change would reach every other model."""
    model = machine()
    parameter, place = model.parameter("k", 1.0), model.bodies["a"].x
    for symbol, name in ((parameter, "k"), (place, "a_x"), (place.rate, "a_vx"), (t, "t")):
        with pytest.raises(ModelError, match=f"'{name}': '{word}' cannot be set"):
            setattr(symbol, word, "z")
        with pytest.raises(AttributeError, match=f"'{name}': '{word}' cannot be deleted"):
            delattr(symbol, word)
    assert copy.copy(parameter) == parameter
    assert pickle.loads(pickle.dumps(2 * place)) == 2 * place


def test_a_table_of_declarations_is_made_by_its_model_alone() -> None:
    model = Model("tables")
    model.parameter("m", 1.0)
    for make in (type(model.parameters).fromkeys, model.parameters.fromkeys):
        with pytest.raises(LinkwrightError, match="view of what is declared"):
            make(["m"])


def test_every_property_of_what_is_declared_can_be_read() -> None:
    model = machine()
    body, scene = model.bodies["a"], model.scene("s")
    joint = model.revolute("pin", model.ground, body)
    moving = Point(body, sympy.sin(t), 0)
    parts = [model, body, model.bodies["p"], model.ground, moving, body.circle(1), scene, joint]
    for part in [*parts, joint.statement(), I, scene.request]:
        for word in dir(type(part)):
            if not word.startswith("_"):
                getattr(part, word)


@pytest.mark.parametrize("when", [Series(["a"]), np.array([1, 2]), np.bool_(True), Mock()])
def test_what_is_no_condition_is_named(when: Any) -> None:
    model = machine()
    model.force("push", on=model.bodies["a"], fx=1.0, when=when)
    with pytest.raises(ModelError, match=r"force 'push': when=.* (never changes|is no condition)"):
        valid_scenes(model, None)
