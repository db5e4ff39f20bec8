"""Pictures of declarations: what each kind of element is drawn as, and where."""

from dataclasses import fields
from math import cos, pi, sin

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model, alpha, disc, rectangle
from codegen.drawing.picture import KINDS, SAMPLES, Picture
from codegen.drawing.shapes import Place, Profile, Reaction, Shape, places
from codegen.elements.registry import kinds_of_elements
from codegen.errors import ModelError
from codegen.picture_at_start import declared_picture
from codegen.reading.model_file import read_model
from codegen.reference.pages import example_of
from tests.codegen.elements.turned_body import TurnedBody

OF_LIBRARY = [name for name, kind in kinds_of_elements().items() if not kind.is_user_defined]
NOT_DRAWN = {"constraint", "friction", "generalized force", "potential"}


def shapes_of(picture: Picture, element: str) -> list[Shape]:
    return [s.shape for s in picture.symbols if s.element == element]


def drawn(kind: str) -> tuple[Picture, list[Shape]]:
    """The picture of a kind's example, and the shapes of the kind in it, reactions apart."""
    picture = declared_picture(example_of(kind).model, assembled=False)
    found = [s.shape for s in picture.symbols if s.kind == kind]
    return picture, [shape for shape in found if not isinstance(shape, Reaction)]


@pytest.mark.parametrize("kind", OF_LIBRARY)
def test_each_kind_has_shapes_with_plain_fields(kind: str) -> None:
    picture, found = drawn(kind)
    assert bool(found) == (kind not in NOT_DRAWN)
    for shape in found:
        for field in fields(shape):
            value = getattr(shape, field.name)
            assert isinstance(value, float | int | bool | str | Place | tuple | None), field.name
        assert all(0 <= place.body < len(picture.bodies) for place in places(shape))


def test_every_shape_is_some_elements() -> None:
    found = {shape.kind for kind in OF_LIBRARY for shape in drawn(kind)[1]}
    assert found | {"reaction", "trace", "opposite force"} == set(KINDS)


def test_joints_close_at_the_start_and_stay_open_at_the_guesses() -> None:
    model = read_model("slider_crank").model
    closed = declared_picture(model, "kinematics", {"rod_length": 3.0})
    pin = shapes_of(closed, "C")[0]
    at, on = (closed.at(place) for place in places(pin))
    assert_allclose(at, on, atol=1e-9)
    (crank,) = (k for k, body in enumerate(closed.bodies) if body.name == "crank")
    x = closed.poses[crank, 2]
    assert_allclose(on.real, 2 * cos(x) + np.sqrt(9 - 4 * sin(x) ** 2), atol=1e-9)
    still = declared_picture(model, "kinematics", {"rod_length": 3.0}, assembled=False)
    assert_allclose(still.poses[2], (3.015, 0.7071, -0.41595))
    at, on = (still.at(place) for place in places(shapes_of(still, "C")[0]))
    assert abs(at - on) > 0.2


def test_outlines_follow_parameters_also_those_that_nothing_else_contains() -> None:
    model = Model("plate")
    width = model.parameter("width", 0.2, unit="m")
    body = model.body("plate", 1.0, 1.0, draw=[rectangle(2.0, width, (1, 0)), disc(width)])
    model.revolute("A", model.ground.at(0, 0), body.at(0, 0))
    model.scene("first", parameters={width: 0.4})
    for values, expected in ((None, 0.4), ({"width": 0.6}, 0.6)):
        plate = declared_picture(model, None, values).bodies[1]
        assert not plate.is_derived
        corners, round_ = plate.outlines
        half = expected / 2
        assert_allclose(corners, [-1j * half, 2 - 1j * half, 2 + 1j * half, 1j * half])
        assert_allclose(abs(round_), expected)


def test_the_ground_has_outlines_that_follow_parameters() -> None:
    model = Model("plate")
    width = model.parameter("width", 0.2, unit="m")
    model.body("plate", 1.0, 1.0)
    model.draw_ground([rectangle(2.0, width, (1, 0)), disc(width)])
    model.scene("first")
    ground, plate = declared_picture(model, None, {"width": 0.6}).bodies
    assert_allclose(ground.outlines[0], [-0.3j, 2 - 0.3j, 2 + 0.3j, 0.3j])
    assert (len(ground.outlines), ground.fixed, plate.is_derived) == (2, True, True)


def test_places_may_have_any_function_of_machine_code() -> None:
    model = Model("bar")
    a, body = model.parameter("a", 0.3, unit="m"), model.body("bar", 1.0, 1.0)
    model.revolute("A", model.ground.at(0, 0), body.at(sympy.atan2(a, 2 * a), 0))
    (pin,) = (s.shape for s in declared_picture(model).symbols if s.shape.kind == "pin")
    assert pin.j.x == pytest.approx(np.arctan2(0.3, 0.6))


def test_curves_are_sampled_all_round() -> None:
    model = Model("cam")
    a = model.parameter("a", 0.3, unit="m")
    cam, pin = model.body("cam", 1.0, 1.0), model.body("pin", 1.0, 1.0)
    model.revolute("A", model.ground.at(0, 0), cam.at(0, 0))
    model.point_follower("track", cam.curve(a * 2, alpha * a), pin.at(0, 0))
    picture = declared_picture(model, parameters={"a": 0.5}, assembled=False)
    (profile,) = (s.shape for s in picture.symbols if isinstance(s.shape, Profile))
    at = np.linspace(0, 2 * pi, SAMPLES)
    assert_allclose(profile.curve.points, 1.0 + 0.5j * at, atol=1e-12)


def test_bodies_without_an_angle_are_posed_by_their_rotation() -> None:
    model = Model("turned")
    body = model.add(TurnedBody("rod", sympy.S.One, sympy.S.One, model.token, 0.1, 0.2))
    model.revolute("A", model.ground.at(1, 2), body.at(0, 0))
    model.scene("swing", guess={body.e0: cos(0.3), body.e1: sin(0.3)})
    picture = declared_picture(model)
    assert_allclose(picture.poses[1], (1, 2, 0.6), atol=1e-9)


def test_torsion_springs_and_wheels_without_points_sit_on_pins() -> None:
    model = Model("hub")
    arm, wheel = model.body("arm", 1.0, 1.0), model.body("wheel", 1.0, 1.0)
    model.revolute("A", model.ground.at(0, 0), arm.at(-1, 0))
    model.revolute("B", arm.at(1, 0), wheel.at(0.2, 0))
    model.torsion_spring("coil", arm, wheel, stiffness=5.0)
    picture = declared_picture(model)
    (coil,) = shapes_of(picture, "coil")
    assert list(places(coil)) == [Place(1, 1.0, 0.0), Place(2, 0.2, 0.0)]


@pytest.mark.parametrize(
    ("given", "word"),
    [
        (3, "give the corners of a polygon"),
        ([(0, 0), (1, 1)], "three or more"),
        ([(0, 0), (1, 0), ("a", 2)], "neither a number"),
        ([], "give the corners"),
    ],
)
def test_outlines_that_are_none(given: object, word: str) -> None:
    model = Model("bad")
    model.body("b", 1.0, 1.0, draw=given)
    model.scene("s")
    with pytest.raises(ModelError, match=rf"body 'b': draw.*{word}"):
        declared_picture(model)


def test_outlines_contain_no_coordinates() -> None:
    model = Model("bad")
    a = model.body("a", 1.0, 1.0)
    model.body("b", 1.0, 1.0, draw=[(0, 0), (a.x, 0), (1, 2)])
    with pytest.raises(ModelError, match="draw contains a_x; give numbers"):
        declared_picture(model)
