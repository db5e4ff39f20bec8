"""What drivers in space exert, as arrows: where they act, and which way; and planes behind them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.drawing.annotations import Load, acting_loads
from codegen.drawing.solids import solids
from models.space.stewart_platform import model as platform
from runtime import load
from runtime.show.pictures import exerted, moving_picture
from tests.space.machines import DOWN, X, Z

MASS = 2.0
OBLIQUE = (0.6, -0.48, 0.64)
SPAN = 0.5  # s of each run


def arm(**drivers: Any) -> Model:
    """An arm on an oblique hinge, and a quill that slides and turns along another axis of it."""
    model = Model("arm", space=True, gravity=DOWN)
    beam = model.body("beam", 3.0, (0.1, 0.2, 0.25), at=(0.4, 0.1, 0))
    quill = model.body("quill", MASS, (0.03, 0.02, 0.04), at=(0.9, 0.2, -0.3))
    hinge = model.revolute("hinge", model.ground, beam, at=(0.1, 0, 0), axis=OBLIQUE)
    guide = model.cylindrical("guide", beam, quill, at=(0.8, 0, 0), axis=(0.0, 0.6, 0.8))
    model.rotation_driver("waist", hinge, 0.7)
    model.translation_driver("lift", guide, 0.2)
    if drivers.get("by_hand"):
        model.driver("twist", guide.angle, -0.4)
    else:
        model.rotation_driver("twist", guide, -0.4)
    model.scene("held", ["gravity"], ["waist", "lift", "twist"])
    return model


def held(model: Model, workshop: Path) -> tuple[Any, list[Load]]:
    """A machine that its drivers hold, and all that acts."""
    result = load(model, folder=workshop).inverse_dynamics(SPAN)
    return result, acting_loads(moving_picture(result), exerted(result))


def balance(loads: list[Load], body: str) -> np.ndarray:
    """Force and moment about the origin of all arrows on a body, (6,), at the first instant."""
    total = np.zeros(6)
    for one in loads:
        if not one.label.endswith(f" on {body}"):
            continue
        at, value = np.array(one.at)[0], np.broadcast_to(one.value, np.shape(one.at))[0]
        if one.style == "torque":
            total[3:] += value
        else:
            total += [*value, *np.cross(at, value)]
    return total


def weight(result: Any, body: str) -> np.ndarray:
    """Force and moment about the origin of a weight, (6,), at the first instant."""
    at, force = [result.q(f"{body}.{c}")[0] for c in "xyz"], MASS * np.array(DOWN)
    return np.array([*force, *np.cross(at, force)])


@pytest.mark.parametrize("by_hand", [False, True])
def test_drivers_and_joint_carry_a_body_at_rest(by_hand: bool, workshop: Path) -> None:
    result, loads = held(arm(by_hand=by_hand), workshop)
    assert_allclose(balance(loads, "quill"), -weight(result, "quill"), atol=1e-9)
    found = {one.element: one for one in loads if one.element in ("waist", "lift", "twist")}
    styles = {name: (one.style, one.unit) for name, one in found.items()}
    assert styles == {
        "waist": ("torque", "N m"), "lift": ("force", "N"), "twist": ("torque", "N m"),
    }  # fmt: skip
    assert found["lift"].label == "lift on quill"
    turn = result.rotation("beam")
    start = np.array([0.1, 0, 0]) + turn @ [0.7, 0, 0]  # of the guide: the hinge turns the beam
    along = turn @ [0.0, 0.6, 0.8]
    assert_allclose(found["lift"].at, start + 0.2 * along, atol=1e-9)
    assert_allclose(found["waist"].at, np.tile([0.1, 0, 0], (len(result.t), 1)), atol=1e-12)
    for name, axis, word in (
        ("waist", OBLIQUE, "torque"), ("lift", along, "force"), ("twist", along, "torque"),
    ):  # fmt: skip
        assert_allclose(found[name].value, result.reaction(name, word)[:, None] * axis, atol=1e-9)


def test_a_motor_speeds_up_the_second_body_by_its_arrow(workshop: Path) -> None:
    model = Model("spin", space=True)
    wheel = model.body("wheel", 1.0, (0.3, 0.3, 0.5), at=(1, 2, 3))
    axle = model.revolute("axle", model.ground, wheel, at=(1, 2, 3), axis=(0, 0, -1))
    model.rotation_driver("motor", axle, 2.0 * t**2)
    model.scene("s", drivers=["motor"])
    _, (motor,) = held(model, workshop)
    assert_allclose(motor.value, np.tile([0, 0, -0.5 * 4.0], (len(motor.value), 1)), atol=1e-9)
    assert_allclose(motor.at, np.tile([1.0, 2.0, 3.0], (len(motor.value), 1)))


def test_points_and_centres_are_pushed_along_global_axes(workshop: Path) -> None:
    model = Model("hung", space=True, gravity=DOWN)
    box = model.body("box", MASS, (0.1, 0.2, 0.3), at=(0.1, 0.2, 0.3), axes=(0.3, -0.2, 0.5))
    model.spherical("ball", model.ground, box, at=(0, 0, 0))
    pin = box.at(0.5, 0.3, -0.2)
    model.point_driver("across", pin, "y", 0.35)
    model.point_driver("lift", pin, "z", 0.4)
    model.driver("centre", box.z, 0.3)
    model.force("wind", box.at(0.4, -0.3, 0.2), (2.0, -3.0, 5.0))
    model.scene("s", ["gravity", "wind"], ["across", "lift", "centre"])
    result, loads = held(model, workshop)
    assert_allclose(balance(loads, "box"), -weight(result, "box"), atol=1e-9)
    found = {one.element: one for one in loads}
    assert set(found) == {"ball", "across", "lift", "centre", "wind"}
    assert_allclose(found["across"].value[:, [0, 2]], 0.0, atol=1e-12)
    assert_allclose(found["lift"].value[:, :2], 0.0, atol=1e-12)
    at = np.array([result.q(f"box.{c}")[0] for c in "xyz"])
    assert_allclose(found["centre"].at[0], at, atol=1e-12)
    assert_allclose(found["lift"].at[0], at + result.rotation("box")[0] @ [0.5, 0.3, -0.2])


def test_an_expression_has_no_place_and_no_arrow(workshop: Path) -> None:
    model = Model("pair", space=True, gravity=DOWN)
    bars = [model.body(name, 1.0, (0.1, 0.1, 0.1), at=(0.5, 0, 0)) for name in ("a", "b")]
    a, b = (
        model.revolute(f"hinge_{one.name}", model.ground, one, at=(0, 0, 0), axis=(0, 1, 0))
        for one in bars
    )
    model.driver("sum", a.angle + b.angle, 0.3)
    model.driver("difference", a.angle - b.angle, 0.1)
    model.scene("s", ["gravity"], ["sum", "difference"])
    result, loads = held(model, workshop)
    assert np.abs(result.reaction("sum", "force")).min() > 1.0
    assert {one.element for one in loads} == {"hinge_a", "hinge_b"}


def test_a_platform_that_is_driven_by_its_coordinates_is_drawn(workshop: Path) -> None:
    result = load(platform, scene="pose", folder=workshop).inverse_dynamics(SPAN)
    loads = acting_loads(moving_picture(result), exerted(result))
    assert {one.element for one in loads} == {"guide_1", "guide_2", "guide_3"}
    (lift,) = (one for one in loads if one.element == "guide_3")
    want = 40.0 * (result.series("a(plate.z)")[0] + 9.81)
    assert_allclose(lift.value[:, 2], want, rtol=1e-9)
    texts = [one.get_text() for one in result.draw(0.2, forces=True).axes[0].texts]
    assert any(text.startswith("guide_3 on plate: ") for text in texts)


def test_planes_hide_nothing_and_reach_as_far_as_their_points(workshop: Path) -> None:
    model = Model("puck", space=True)
    puck = model.body("puck", 1.0, (0.1, 0.1, 0.1), at=(1.0, 2.0, 0.0))
    model.planar("table", model.ground, puck, at=(1.0, 2.0, 0.0), axis=Z)
    other = model.body("far", 1.0, (0.1, 0.1, 0.1), at=(3.0, 2.0, 0.0))
    model.translational("rail", model.ground, other, at=(3.0, 2.0, 0.0), axis=X)
    model.scene("s", start={"puck.vx": 0.4, "puck.vy": -1.0, "puck.omega_z": 1.0})
    result = load(model, folder=workshop).simulate(1.0, progress=False)
    picture = moving_picture(result)
    (plate,) = (one for one in solids(picture) if one.form == "plate")
    low, high = plate.corners.min(axis=0), plate.corners.max(axis=0)
    assert_allclose((low + high)[:2] / 2, [1.2, 1.5], atol=1e-6)
    room = (high - low)[:2] - [0.4, 1.0]
    assert_allclose(room, room[0], atol=1e-6)
    assert 0 < room[0] < 0.2 * picture.size
    still = result.draw(0.5)
    sheer = [color for color in still.axes[0].collections[0].get_facecolor() if 0 < color[3] < 1]
    assert [round(float(color[3]), 2) for color in sheer] == [0.3]
