"""Contacts in pictures: where a body touches, and the surfaces of the ground."""

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import sqrt

from codegen import Model, disc, rectangle, t
from codegen.declare.body import Body
from codegen.drawing.annotations import acting_loads
from codegen.drawing.body_outlines import complete_picture
from codegen.drawing.contacts import surfaces, touch
from codegen.drawing.lines_between_bodies import lines_between_bodies
from codegen.drawing.lines_in_bodies import lines_in_bodies
from codegen.drawing.picture import Picture
from codegen.drawing.shapes import ContactSide
from codegen.picture_at_start import declared_picture
from codegen.reading.model_file import read_model

SLOPE = 0.4


def drawn(model: Model, body: Body, *contacts: str, x: float = 0.0, y: float = 1.0,
          phi: float = 0.3) -> Picture:  # fmt: skip
    start = {body.x: x, body.y: y, body.vx: 0.0, body.vy: 0.0}
    if body.turns:
        start |= {body.phi: phi, body.omega: 0.0}
    model.scene("falling", contacts, start=start)
    return declared_picture(model)


def touching(picture: Picture, element: str) -> tuple[complex, complex, complex]:
    """Where a body touches, the point of the surface, and the normal."""
    (side,) = (side for symbol, side in picture.having(ContactSide) if symbol.element == element)
    point, surface, normal = map(complex, touch(picture, side))
    return point, surface, normal


def test_a_ball_touches_a_plate_with_its_lowest_point() -> None:
    model = Model("ball")
    ball = model.particle("ball", 1.0, draw=disc(0.1))
    model.contact("plate", model.ground, ball, direction=(0, 1), free_length=0.1, restitution=0.5)
    picture = drawn(model, ball, "plate", x=0.7)
    point, surface, normal = touching(picture, "plate")
    assert_allclose([point, surface, normal], [0.7 + 0.9j, 0.7, 1j], atol=1e-12)
    (plane,) = surfaces(picture, fixed=True)
    assert plane.element == "plate"
    assert_allclose(plane.middle, surface, atol=1e-12)
    lines = [s for s in lines_in_bodies(picture) if s.element == "plate"]
    assert [s.style for s in lines[:2]] == ["rail", "hatch"]
    assert_allclose(lines[0].points.imag, 0.0, atol=1e-12)
    assert all(np.all(s.points.imag < 1e-12) for s in lines)  # the ground is below
    assert not lines_between_bodies(picture)


@pytest.mark.parametrize("phi", [0.3, 2.0, -2.5])
def test_a_corner_of_a_box_touches_a_slope_wherever_it_is(phi: float) -> None:
    model = Model("box")
    box = model.body("box", 1.0, 0.1, draw=rectangle(0.3, 0.2))
    corner = box.at(-0.15, -0.1)
    gap = -sin(SLOPE) * corner.x + cos(SLOPE) * corner.y
    model.contact("edge", gap=gap, stiffness=1e4, may_pull=False)
    picture = drawn(model, box, "edge", x=0.2, y=0.6, phi=phi)
    point, surface, normal = touching(picture, "edge")
    assert_allclose(point, 0.2 + 0.6j - (0.15 + 0.1j) * np.exp(1j * phi), atol=1e-12)
    assert_allclose(normal, 1j * np.exp(1j * SLOPE), atol=1e-12)
    assert (surface * normal.conjugate()).real == pytest.approx(0.0, abs=1e-12)


def test_two_ends_of_a_rod_share_one_floor() -> None:
    """Without an outline the rod is a bar from end to end, with round ends that touch."""
    model = Model("rod")
    rod = model.body("rod", 1.0, 1 / 12)
    for name, x in (("left", -0.5), ("right", 0.5)):
        model.contact(name, gap=rod.at(x, 0).y, restitution=0.5)
    picture = drawn(model, rod, "left", "right", phi=0.5)
    ends = np.array([touching(picture, name)[0] for name in ("left", "right")])
    (corners,) = picture.bodies[1].outlines
    half = np.ptp(corners.imag) / 2
    assert_allclose(abs(corners.real).max(), 0.5 + half, rtol=1e-9)
    (floor,) = surfaces(picture, fixed=True)
    assert_allclose(floor.middle, -1j * half, atol=2e-2 * half)
    assert floor.half > 0.5 * cos(0.5)
    assert_allclose(ends.real, [-0.5 * cos(0.5), 0.5 * cos(0.5)], atol=1e-12)


def test_an_eccentric_disc_touches_below_its_own_centre() -> None:
    model = Model("cam")
    cam = model.body("cam", 1.0, 0.1, draw=disc(0.2, center=(0.05, 0)))
    model.contact("floor", gap=cam.at(0.05, 0).y - 0.2, restitution=0.5)
    point, surface, _ = touching(drawn(model, cam, "floor", phi=1.1), "floor")
    depth = 0.2 * cos(pi / 64)  # of a polygon within the circle, at most
    assert point.real == pytest.approx(0.05 * cos(1.1), abs=1e-12)
    assert point.imag == pytest.approx(1.0 + 0.05 * sin(1.1) - depth, abs=1e-3)
    assert surface.imag == pytest.approx(0.0, abs=1e-3)


def two_balls(**law: float | bool) -> Model:
    model = Model("two_balls")
    one, two = (model.particle(name, 1.0, draw=disc(0.1)) for name in ("one", "two"))
    model.contact("hit", one, two, free_length=0.2, **law)
    model.scene("s", ["hit"])
    return model


def bowl() -> Model:
    model = Model("bowl")
    ball = model.particle("ball", 1.0, draw=disc(0.1))
    model.contact("bowl", gap=2 - sqrt(ball.x**2 + ball.y**2), restitution=0.5)
    model.scene("s", ["bowl"])
    return model


@pytest.mark.parametrize(
    "model", [two_balls(restitution=0.5), two_balls(stiffness=1e4, may_pull=False), bowl()]
)
def test_a_gap_without_slopes_at_the_start_has_no_place(model: Model) -> None:
    """A distance has none where it is zero; all else of the picture is drawn."""
    picture = declared_picture(model)
    sides = picture.having(ContactSide)
    assert sides
    assert all(np.isnan([side.gx, touch(picture, side).point]).all() for _, side in sides)
    assert surfaces(picture, fixed=True) == surfaces(picture, fixed=False) == []
    assert np.isfinite(picture.poses).all()
    names = {text.get_text() for text in model.draw(forces=True).axes[0].texts}
    assert {body.name for body in picture.bodies[1:]} <= names


def test_a_surface_is_near_where_the_motion_comes_near_it() -> None:
    model = Model("fall")
    ball = model.particle("ball", 1.0, draw=disc(0.1))
    model.contact("plate", gap=ball.y - 0.1, restitution=0.5)
    for height in (3.0, 1e3):
        start = {ball.x: 0.0, ball.vx: 0.0, ball.y: height, ball.vy: 0.0}
        model.scene(f"from_{height:.0f}", ["plate"], start=start)
    low, far = (declared_picture(model, scene) for scene in ("from_3", "from_1000"))
    assert low.size == pytest.approx(3.1, abs=0.1)
    (plane,) = surfaces(low, fixed=True)
    assert_allclose(plane.middle, 0, atol=1e-12)
    assert surfaces(far, fixed=True) == []
    assert far.size == pytest.approx(0.2 * 2**0.5, rel=1e-2)
    motion = np.repeat(far.poses[None], 3, axis=0)
    motion[:, 1, 1] = [1e3, 0.1, 50.0]
    far = replace(far, motion=motion)
    assert complete_picture(far).size == pytest.approx(1e3, rel=1e-2)
    (plane,) = surfaces(far, fixed=True)
    assert_allclose(plane.middle, 0, atol=1e-9)


@pytest.mark.parametrize(("x", "way"), [(-0.4, 1.0), (0.6, -1.0)])
def test_the_limit_that_is_hit_exerts_the_force_of_a_rigid_stop(x: float, way: float) -> None:
    model = Model("slide")
    block = model.body("block", 1.0, 0.1, draw=rectangle(0.1, 0.1))
    guide = model.translational("guide", model.ground, block, axis=(1, 0))
    model.stop("ends", guide, lower=-0.4, upper=0.6, restitution=0.5)
    model.scene("sliding", ["ends"], start={block.x: x, block.vx: 0.0})
    picture = declared_picture(model)
    assert len(picture.having(ContactSide)) == 2
    (load,) = acting_loads(picture, {"ends.force": 7.0})
    assert_allclose(load.value, 7.0 * way)
    assert_allclose(load.at, x - 0.05 * way, atol=1e-12)


MACHINES = [("quarter_car", "bump"), ("hard/contact_follower", "touching"),
            ("valve_lifter", "free_follower"),
            ("hard/bouncing_ball", "shaken")]  # fmt: skip


@pytest.mark.parametrize(("path", "scene"), MACHINES)
def test_the_drawn_force_is_the_force_of_the_equations(path: str, scene: str) -> None:
    """A force G at the place where it is drawn has the moment ∂g/∂φ about the body's origin."""
    picture = declared_picture(read_model(path).model, scene)
    found = picture.having(ContactSide)
    assert found
    for _, side in found:
        arm = touch(picture, side).point - picture.placed(0j, side.body)
        moment = arm.real * side.gy - arm.imag * side.gx
        assert moment == pytest.approx(side.turn, abs=1e-12)


def test_the_road_of_a_car_is_at_its_height() -> None:
    picture = declared_picture(read_model("quarter_car").model, "bump")
    assert not surfaces(picture, fixed=True)
    (road,) = surfaces(picture, fixed=False)
    assert road.element == "tyre"
    corners = 0.3 * (1 - cos(pi / 64))  # by how much the wheel's polygon is within its circle
    assert 0.0 <= road.middle.imag <= corners
    tyre = {s.style for s in lines_between_bodies(picture) if s.element == "tyre"}
    assert tyre == {"rail", "hatch"}


@pytest.mark.parametrize("law", [{"stiffness": 1e4}, {"restitution": 0.5}])
def test_stops_of_a_slide_have_plates_where_the_block_ends(law: dict[str, float]) -> None:
    model = Model("slide")
    block = model.body("block", 1.0, 0.1)
    guide = model.translational("guide", model.ground, block, axis=(1, 0))
    model.stop("ends", guide, lower=-0.4, upper=0.6, **law)
    model.scene("sliding", ["ends"], start={block.x: 0.1, block.vx: 0.0})
    picture = declared_picture(model)
    half = max(z.real for outline in picture.bodies[1].outlines for z in outline)
    lower, upper = surfaces(picture, fixed=True)
    assert_allclose([lower.middle, upper.middle], [-0.4 - half, 0.6 + half], atol=1e-12)
    assert_allclose([lower.normal, upper.normal], [1, -1], atol=1e-12)


def test_contacts_without_a_surface() -> None:
    """A stop of an angle only turns; two bodies that move have sides alone; a far one is none."""
    model = Model("none")
    one, two = (model.particle(name, 1.0, draw=disc(0.1)) for name in ("one", "two"))
    wheel = model.body("wheel", 1.0, 0.1)
    pin = model.revolute("pin", model.ground, wheel)
    model.stop("turn", pin, lower=-1.0, upper=1.0, stiffness=10.0)
    model.contact("hit", one, two, free_length=0.2, restitution=0.5)
    model.contact("sky", gap=1e4 - one.y, restitution=0.5)
    start = {one.x: 1.0, one.y: 0.0, two.x: 2.0, two.y: 0.0}
    rates = {one.vx: 0.0, one.vy: 0.0, two.vx: 0.0, two.vy: 0.0, wheel.phi: 0.0, wheel.omega: 0.0}
    model.scene("all", ["turn", "hit", "sky"], start=start | rates)
    picture = declared_picture(model)
    names = [
        (symbol.element, picture.bodies[side.body].name)
        for symbol, side in picture.having(ContactSide)
    ]
    turning = [("turn", "wheel")] * 2
    assert names == [*turning, ("hit", "one"), ("hit", "two"), ("sky", "one")]
    assert surfaces(picture, fixed=True) == surfaces(picture, fixed=False) == []
    for (_, side), x in zip(picture.having(ContactSide)[2:4], (1.1, 1.9), strict=True):
        assert_allclose(touch(picture, side).point, x, atol=1e-3)


def test_a_wall_that_moves_is_no_part_of_the_ground_at_rest() -> None:
    model = Model("shaker")
    ball = model.particle("ball", 1.0, draw=disc(0.1))
    model.contact("wall", gap=ball.x - 0.1 - 0.3 * t, restitution=0.5)
    picture = drawn(model, ball, "wall", x=1.0)
    assert not surfaces(picture, fixed=True)
    (wall,) = surfaces(picture, fixed=False)
    assert_allclose(wall.middle, 1j, atol=1e-12)
    motion = np.repeat(picture.poses[None], 3, axis=0)
    motion[:, 1, :2] = [[0.2, 1.0], [0.1, 3.0], [1.0, 9.0]]  # at last far from the wall
    (long,) = surfaces(replace(picture, motion=motion), fixed=False)
    assert_allclose(long.middle, 2j, atol=1e-12)
    assert long.half == pytest.approx(wall.half + 1.0)
