"""Contacts of runs: surfaces that move as the gap says, forces where bodies touch."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Piecewise, sqrt

from codegen import Model, disc, t
from codegen.drawing.annotations import Load, loads
from codegen.drawing.contacts import moving_surfaces, surfaces
from codegen.drawing.lines_between_bodies import lines_between_bodies
from codegen.drawing.shapes import ContactSide
from runtime import Result, load
from runtime.show.animation.page_data import machine_data
from runtime.show.pictures import exerted, moving_picture
from tests.runtime.show.animation.conftest import Open


@pytest.fixture(scope="module")
def car() -> Any:
    machine = load("quarter_car", "bump")
    return machine.simulate(0.4, 81, start=machine.equilibrium(), progress=False)


@pytest.fixture(scope="module")
def ball() -> Any:
    return load("hard/bouncing_ball", "dropped").simulate(2.0, 401, progress=False)


def load_of(one: Result, element: str) -> Load:
    """What an element exerts at the only instant of a result, where it is not 0."""
    found = loads(moving_picture(one), exerted(one))
    (load_,) = (row for row in found if row.element == element and row.size > 1e-6)
    return load_


def test_the_road_passes_below_the_car(car: Any) -> None:
    """Its height is that of the wheel's lowest point less the gap, at all instants."""
    shown = moving_picture(car)
    (road,) = moving_surfaces(shown)
    height = car.q("upright.y") - 0.3 - car.gap("tyre")
    assert np.ptp(height) == pytest.approx(0.06, abs=1e-4)  # the bump
    corners = 0.3 * (1 - np.cos(np.pi / 64))  # by how much the wheel's polygon is within its circle
    assert np.all(np.abs(road.middle.imag - height) <= corners)
    assert_allclose(road.normal, 1j, atol=1e-12)
    # and so it does in the frames of a movie
    for frame, y in list(zip(shown.frames(), road.middle.imag, strict=True))[::20]:
        rail = next(s for s in lines_between_bodies(frame) if s.style == "rail")
        assert_allclose(rail.points.imag, y, atol=1e-9)


def test_the_force_of_a_tyre_acts_where_it_touches(car: Any) -> None:
    one = car.at(0.2)
    push = load_of(one, "tyre")
    assert (push.label, push.style) == ("tyre on upright", "reaction")
    assert_allclose(push.value, 1j * one.force("tyre"))
    assert push.size > 1000.0
    wheel = one.q("upright.x") + 1j * one.q("upright.y")
    assert_allclose(push.at - wheel, -0.3j, atol=1e-3)


def test_the_plate_carries_the_weight_of_the_ball(ball: Any) -> None:
    weight = load_of(ball.at(1.9), "plate")
    assert_allclose(weight.value, 0.4j * 9.81, rtol=1e-9)
    assert_allclose(weight.at, 0, atol=1e-6)
    texts = {text.get_text() for text in ball.draw(1.9, forces=True).axes[0].texts}
    assert "plate on ball: 3.92 N" in texts


def test_a_page_shows_the_force_and_the_impact_where_they_are(
    show: Open, ball: Any, tmp_path: Path
) -> None:
    path = tmp_path / "ball.html"
    ball.animate(file=path)
    page = show(path)
    page.evaluate("player.clock.seek(1.9)")
    page.get_by_label("reactions").check()
    assert page.locator(".arrow-text:visible").all_text_contents() == ["plate on ball: 3.924 N"]
    scene = "player.scenes[0]"
    (first, *_) = (event.time for event in ball.events if event.word == "strikes" or event.what)
    page.evaluate(f"player.clock.seek({first + 0.1})")
    ring = page.locator(".flash:not([hidden])")
    assert ring.count() == 1
    x, y = (float(part) for part in ring.get_attribute("transform")[10:].split(")")[0].split())
    assert abs(x) < 1e-6
    assert abs(y) < 1e-3  # on the plate, from which the ball has gone
    assert page.evaluate(f"{scene}.poses[1].y") > 0.15
    page.evaluate(f"player.clock.seek({first - 1e-3})")
    assert ring.count() == 0


def test_a_page_moves_the_road(show: Open, car: Any, tmp_path: Path) -> None:
    path = tmp_path / "car.html"
    car.animate(file=path)
    page = show(path)
    rail = ".ground [data-element=tyre]:has(.rail)"
    heights = []
    for instant in (0.0, 2.75 / 12, 0.4):
        page.evaluate(f"player.clock.seek({instant})")
        text = page.locator(rail).get_attribute("transform")
        heights.append(float(text[10:].split(")")[0].split()[1]))
    assert heights == pytest.approx([0.0, 0.06, 0.0], abs=1e-3)


def shuttle(push: Any, vx: float, **law: float) -> Model:
    """A block that slides between two limits."""
    model = Model("shuttle")
    block = model.body("block", 1.0, 0.1, draw=disc(0.05))
    guide = model.translational("guide", model.ground, block, axis=(1, 0))
    model.stop("ends", guide, lower=-0.5, upper=0.5, **law)
    model.force("push", block, fx=push)
    model.scene("running", ["ends", "push"], start={block.x: 0.0, block.vx: vx})
    return model


def test_both_limits_of_a_stop_flash_where_they_are_hit(show: Open, tmp_path: Path) -> None:
    model = shuttle(0.0, 1.0, stiffness=1e5)
    run = load(model, generated=tmp_path).simulate(2.0, 201, progress=False)
    run.animate(file=tmp_path / "run.html")
    page = show(tmp_path / "run.html")
    places = []
    for instant in (0.6, 1.6):
        page.evaluate(f"player.clock.seek({instant})")
        text = page.locator(".flash:not([hidden])").get_attribute("transform")
        places.append(float(text[10:].split()[0]))
    assert places == pytest.approx([0.55, -0.55], abs=0.01)


def test_a_rigid_stop_pushes_at_the_limit_that_is_hit_alone(show: Open, tmp_path: Path) -> None:
    """A force turns the block against one limit, and then against the other."""
    model = shuttle(Piecewise((3.0, t < 2.0), (-3.0, True)), 0.0, restitution=0.0)
    run = load(model, generated=tmp_path).simulate(4.0, 401, progress=False)
    run.animate(file=tmp_path / "run.html")
    page = show(tmp_path / "run.html")
    page.get_by_label("reactions").check()
    for instant, x, force in ((1.8, 0.55, -3.0), (3.8, -0.55, 3.0)):
        push = load_of(run.at(instant), "ends")
        assert_allclose(push.value, force, rtol=1e-6)
        assert_allclose(push.at, x, atol=1e-3)
        page.evaluate(f"player.clock.seek({instant})")
        texts = page.locator(".arrow-text:visible").all_text_contents()
        assert [text for text in texts if text.startswith("ends")] == ["ends on block: 3.000 N"]


def test_a_ball_that_starts_at_the_centre_of_a_bowl(tmp_path: Path) -> None:
    """Its gap has no slopes there; later the surface of the bowl is below it, without a turn."""
    model = Model("bowl", gravity=(0, -9.81))
    ball = model.particle("ball", 1.0, draw=disc(0.1))
    model.contact("bowl", gap=2 - sqrt(ball.x**2 + ball.y**2), stiffness=1e4, may_pull=False)
    start = {ball.x: 0.0, ball.y: 0.0, ball.vx: 0.0, ball.vy: 0.0}
    model.scene("falling", ["gravity", "bowl"], start=start)
    shown = moving_picture(load(model, generated=tmp_path).simulate(0.5, 51, progress=False))
    ((_, side),) = shown.having(ContactSide)
    assert np.isnan(side.gy[0])
    assert_allclose(side.gy[1:], 1.0)
    (surface,) = moving_surfaces(shown)
    assert_allclose(surface.middle[1:], -2j, atol=0.11)
    assert_allclose(surface.normal[1:], 1j, atol=1e-12)
    push = {"bowl.force": np.ones(len(shown.t))}
    (arrow,) = machine_data(shown, series=push)["arrows"]
    assert (arrow["label"], arrow["unit"]) == ("bowl on ball", "N")


@pytest.mark.parametrize("height", [3.0, 30.0])
def test_a_ball_from_high_above_falls_on_a_plate(tmp_path: Path, height: float) -> None:
    model = Model("fall", gravity=(0, -9.81))
    ball = model.particle("ball", 1.0, draw=disc(0.1))
    model.contact("plate", gap=ball.y - 0.1, restitution=0.5)
    model.contact("table", gap=ball.y - 0.1 - 0.01 * t, restitution=0.5)
    start = {ball.x: 0.0, ball.y: height, ball.vx: 0.0, ball.vy: 0.0}
    for name in ("plate", "table"):
        model.scene(name, ["gravity", name], start=start)
    runs = [
        load(model, name, generated=tmp_path).simulate(0.6 * height**0.5, 101, progress=False)
        for name in ("plate", "table")
    ]
    still, moves = map(moving_picture, runs)
    assert still.size == pytest.approx(np.hypot(0.2, height), rel=1e-3)
    (plate,) = surfaces(still.first, fixed=True)
    assert_allclose(plate.middle, 0, atol=1e-9)
    (table,) = moving_surfaces(moves)
    assert_allclose(table.middle.imag, 0.01 * runs[1].t, atol=1e-9)
