"""A page of kinematics is turned by hand: a body that is dragged moves the time."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from runtime import load
from tests.runtime.show.animation.conftest import PHONE, Open
from tests.runtime.show.animation.machines import crank_pictures, page_of

TIME = "player.clock.t"


def at(page: Any, body: int, x: float, y: float = 0.0) -> tuple[float, float]:
    """Where a point of a body is in the window, px."""
    box = page.locator("svg.stage").bounding_box()
    script = f"player.camera.toScreen(player.scenes[0].place({{body: {body}, x: {x}, y: {y}}}))"
    point = page.evaluate(script)
    return box["x"] + point["x"], box["y"] + point["y"]


@pytest.fixture(name="turned")
def _turned(show: Open, tmp_path: Path) -> Any:
    """A crank driven through two turns in 2 s, a rod and a slider."""
    run = load("slider_crank", "kinematics").kinematics(np.linspace(0.0, 2.0, 201))
    page = show(run.animate().save(tmp_path / "driven.html"))
    page.evaluate("player.clock.seek(0.25)")
    return page


def grasped(page: Any, x: float) -> Callable[[float], float]:
    """Take the crank at a place; a function turns it by an angle, and returns the time there."""
    center, pin = np.array(at(page, 0, 0.0)), np.array(at(page, 1, x))
    page.mouse.move(*pin)
    page.mouse.down()

    def turn(angle: float) -> float:
        c, s = np.cos(angle), np.sin(angle)
        page.mouse.move(*(center + np.array([[c, s], [-s, c]]) @ (pin - center)))
        return float(page.evaluate(TIME))

    return turn


def test_the_crank_follows_the_pointer_round_and_back(turned: Any) -> None:
    page, turn = turned, grasped(turned, 1.4)
    for k in range(1, 33):
        now = turn(k * np.pi / 16)
        assert now == pytest.approx(0.25 + k / 32, abs=2e-3)
    for k in range(32, -5, -1):
        now = turn(k * np.pi / 16)
    assert now == pytest.approx(0.25 - 4 / 32, abs=2e-3)
    page.mouse.up()
    turn(1.0)
    assert page.evaluate(TIME) == pytest.approx(now)


@pytest.mark.parametrize(("turns", "back"), [(1.0, 0.875), (0.9, 0.0)])
def test_a_closed_motion_goes_round_through_its_ends(
    show: Open, tmp_path: Path, turns: float, back: float
) -> None:
    """A page opens at t = 0: from there a crank of whole turns goes either way, and on and on."""
    t = np.linspace(0.0, 1.0, 201)
    path = page_of(tmp_path / "crank.html", crank_pictures(t, 2 * np.pi * turns * t), driven=True)
    page = show(path)
    turn = grasped(page, -0.05)
    for k in range(-1, -9, -1):
        now = turn(k * np.pi / 32)
    assert now == pytest.approx(back, abs=2e-3)
    for k in range(-7, 81):
        now = turn(k * np.pi / 32)
    assert now == pytest.approx(0.25 if turns == 1.0 else 1.0, abs=2e-3)
    page.mouse.up()


def test_the_slider_carries_the_crank_through_its_dead_centre(turned: Any) -> None:
    """The slider is farthest to the left half a turn after it was farthest to the right."""
    page = turned
    x = "player.scenes[0].poses[3].x"
    start = at(page, 3, 0.0, 0.05)
    scale = page.evaluate("player.camera.scale")
    page.mouse.move(*start)
    page.mouse.down()
    for k in range(1, 31):
        page.mouse.move(start[0] - k * 0.1 * scale, start[1])
    left = page.evaluate(TIME)
    assert left == pytest.approx(0.375, abs=0.02)  # where the crank's angle is π
    assert page.evaluate(x) == pytest.approx(1.5, abs=0.01)
    for k in range(30, -46, -1):
        page.mouse.move(start[0] - k * 0.1 * scale, start[1])
    assert page.evaluate(TIME) == pytest.approx(0.875, abs=0.02)
    assert page.evaluate(x) == pytest.approx(5.5, abs=0.01)


def test_the_background_and_a_simulated_body_move_the_view(
    show: Open, turned: Any, compressor_page: Path
) -> None:
    for page, body in ((turned, 0), (show(compressor_page), 1)):
        before, place = page.evaluate(TIME), page.evaluate("player.camera.x")
        x, y = at(page, body, 1.0, -1.5 if body == 0 else 0.0)
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 40, y, steps=4)
        page.mouse.up()
        assert page.evaluate(TIME) == before
        assert page.evaluate("player.camera.x") == pytest.approx(place + 40)


def test_a_finger_turns_a_crank_and_does_not_scroll(show: Open, tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 101)
    path = page_of(tmp_path / "crank.html", crank_pictures(t, t), driven=True)
    page = show(path, PHONE, has_touch=True)
    devtools = page.context.new_cdp_session(page)
    (x0, y0), (x, y) = at(page, 0, 0.0), at(page, 1, -0.05)

    def touch(kind: str, points: list[dict[str, float]]) -> None:
        devtools.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    touch("touchStart", [{"x": x, "y": y}])
    for angle in np.linspace(0.05, 0.8, 16):
        reach = x - x0
        touch("touchMove", [{"x": x0 + reach * np.cos(angle), "y": y0 - reach * np.sin(angle)}])
        page.wait_for_timeout(16)
    touch("touchEnd", [])
    assert page.evaluate(TIME) == pytest.approx(0.8, abs=0.01)
    assert page.evaluate("scrollY") == 0
