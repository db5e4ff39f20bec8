"""Objects that hide their class or claim another are refused by name, where they stand."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any
from unittest.mock import Mock

import pytest
import sympy

from codegen import Body, LinkwrightError, Model, ModelError, Point
from codegen.reading.scene_selection import valid_scenes


def machine() -> Model:
    """A model of a body and a particle under gravity."""
    model = Model("m", gravity=(0, -9.81))
    model.body("a", mass=1.0, inertia=0.1)
    model.particle("p", mass=1.0)
    return model


class Hidden:
    """An object whose class is not to be had."""

    @property  # type: ignore[misc]
    def __class__(self) -> Any:
        raise SystemExit


def test_objects_that_hide_their_class_are_refused_where_they_stand() -> None:
    model = machine()
    model.revolute("pin", Hidden(), model.bodies["a"].at(0, 0))  # type: ignore[arg-type]
    model.force("f", on=model.bodies["a"], fx=Hidden())
    model.scene("s", effects=[Hidden()])  # type: ignore[list-item]
    model.cam_follower("c", Hidden(), model.bodies["a"].circle(1))  # type: ignore[arg-type]
    with pytest.raises(ModelError) as caught:
        valid_scenes(model, None)
    for name in ("'pin'", "'f'", "'s'", "'c'"):
        assert any(
            name in problem and "fails with" not in problem for problem in caught.value.problems
        )


@pytest.mark.parametrize("word", ["frozen", "effects", "outputs", "analysis"])
def test_a_scene_made_anew_is_read_as_one_that_is_declared(word: str) -> None:
    model = machine()
    scene = replace(model.scene("s"), **{word: Hidden()})  # type: ignore[arg-type]
    with pytest.raises(LinkwrightError, match="scene 's'"):
        valid_scenes(model, scene)


class Meta(type):
    """A class of classes that say nothing of themselves."""

    def __getattribute__(cls, word: str) -> Any:
        if word in ("__name__", "__mro__"):
            raise GeneratorExit
        return type.__getattribute__(cls, word)


class Nameless(metaclass=Meta):
    """An object of such a class."""


IMPOSTORS: dict[str, Callable[[Model], Any]] = {
    "joint": lambda m: m.friction("e", Hidden(), 0.1, radius=0.1),  # type: ignore[arg-type]
    "point of a mock": lambda m: m.force("e", on=Mock(spec=Point), fx=1.0),
    "mock of a body": lambda m: m.revolute("e", m.ground.at(0, 0), Mock(spec=Body)),
    "mock of a joint": lambda m: m.add(Mock(spec=m.revolute("r", m.ground, m.bodies["a"]))),
    "class without a name": lambda m: m.torque("e", on=Nameless(), value=1.0),  # type: ignore[arg-type]
    "in a list": lambda m: m.table("e", [0, 1, Hidden(), 3], [0, 1, 2, 3]),
    "in a mapping": lambda m: m.scene("e", start={Hidden(): 1.0, "a.x": Hidden()}),
    "body of a point": lambda m: m.force("e", on=Point(Hidden(), 0, 0), fx=1.0),  # type: ignore[arg-type]
    "mass": lambda m: m.add(Body("e", Hidden(), None, m.token)),  # type: ignore[arg-type]
    "scene": lambda m: valid_scenes(m, m.scene("e").with_(start=Hidden())),
    "hand-made scene": lambda m: valid_scenes(m, replace(m.scene("e"), owner=Hidden())),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("where", IMPOSTORS)
def test_what_hides_its_class_or_claims_another_is_refused_by_name(where: str) -> None:
    def built() -> None:
        model = machine()
        IMPOSTORS[where](model)
        valid_scenes(model, None)

    with pytest.raises(
        LinkwrightError, match=r"hides its class or claims another|of no model;"
    ) as caught:
        built()
    assert "fails with" not in str(caught.value)
    assert "'e'" in str(caught.value) or where == "mock of a joint"


@pytest.mark.parametrize("word", ["angular_velocity", "position", "inertia_force", "mass_matrix"])
def test_a_body_of_an_own_class_that_hides_an_answer_is_named(word: str) -> None:
    made = type("Mine", (Body,), {word: property(lambda self: Hidden())})
    model = machine()
    model.add(made("mine", sympy.S.One, sympy.S.One, model.token))
    with pytest.raises(ModelError, match=r"body 'mine': its .* hides its class"):
        valid_scenes(model, None)
