"""Functions that rest on their surfaces, many at once or by a high power of time, leave them."""

from math import cos
from pathlib import Path
from typing import Any

import pytest
from numpy.testing import assert_allclose
from sympy import Heaviside, Max, Piecewise, sign, sin

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome


def laws(v: Any) -> dict[str, tuple[Any, float, float]]:
    """A force that switches with v, and its values where v > 0 and where v < 0, N."""
    above, at_most = (Piecewise((1, c), (0, True)) for c in (v > 0, v <= 0))
    mixed = 5 * sign(v) + 3 * above - 2 * at_most
    return {"sign": (5 * sign(v), 5.0, -5.0), "mixed": (mixed, 8.0, -7.0)}


@pytest.mark.parametrize("count", [7, 12])
@pytest.mark.parametrize("name", ["sign", "mixed"])
def test_many_velocities_leave_rest_together(workshop: Path, name: str, count: int) -> None:
    """A load sets all off at t = 1 s, every other one downward."""
    model = Model(f"leave_together_{name}_{count}")
    loads = [(-1) ** k * (1.0 + k) for k in range(count)]
    for k, load_ in enumerate(loads):
        bead = model.particle(f"bead{k}", mass=1.0)
        model.force(f"F{k}", bead, fx=laws(bead.vy)[name][0], fy=load_ * Heaviside(t - 1))
    run = load(model, folder=workshop).simulate(2.0, [0.5, 2.0], progress=False)
    assert run.outcome is Outcome.OK
    for k, load_ in enumerate(loads):
        _, up, down = laws(t)[name]
        assert_allclose(run.v(f"bead{k}.y"), [0.0, load_], atol=1e-9)
        assert_allclose(run.a(f"bead{k}.x")[-1], up if load_ > 0 else down)


def test_a_contact_and_places_of_a_damper_leave_rest_together(workshop: Path) -> None:
    """The end of a spring with Coulomb's friction jumps five times; the last pulls from a wall."""
    model = Model("leaves_a_wall")
    block = model.particle("block", mass=2.0)
    model.absolute("guide", block, "y", 0.0)
    ends = [(0.1, t < 0.2), (0.0, t < 0.4), (0.05, t < 0.6), (0.0, t < 0.8), (0.1, t < 1.0)]
    end = model.ground.at(Piecewise(*ends, (0.5, True)) - 5, 0)
    model.spring("link", end, block, force=lambda s, v: 8 * (s - 5.0) + 0.7 * sign(v))
    model.force("load", block, fx=-3.0)
    model.contact("wall", gap=block.x, restitution=0.5)
    model.scene("run", ["link", "load", "wall"], start={block.x: 0.0, block.vx: 0.0})
    run = load(model, "run", folder=workshop).simulate(1.5, [0.9, 1.5], progress=False)
    assert run.outcome is Outcome.OK
    # 8 (0.5 - x) - 0.7 - 3 = 2 x'' from t = 1 s on
    swing = 0.0375 * (1 - cos(2 * 0.5))
    assert_allclose(run.q("block.x"), [0.0, swing], atol=1e-8)


@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau5", "bdf"])
def test_a_position_that_leaves_slowly_leaves_once(workshop: Path, method: Any) -> None:
    """By (t - 1)³/6, which after the first 0.04 ms is the last digit of a step."""
    model = Model("leaves_slowly")
    bead = model.particle("bead", mass=1.0)
    model.force("side", bead, fx=5 * sign(bead.y), fy=Max(t - 1, 0))
    run = load(model, folder=workshop).simulate(2.0, [0.5, 2.0], method=method, progress=False)
    assert run.outcome is Outcome.OK
    assert [event.what for event in run.events if "bead_y" in event.name] == ["began"]
    assert_allclose(run.q("bead.y"), [0.0, 1 / 6], atol=1e-6)
    assert_allclose(run.v("bead.x"), [0.0, 5.0], rtol=1e-4)


def test_a_brake_along_the_normal_lets_a_ball_settle(workshop: Path) -> None:
    """On the floor the contact keeps the velocity at 0, whatever the sign's share is."""
    model = Model("settles_with_a_brake")
    ball = model.particle("ball", mass=1.0)
    model.contact("floor", gap=ball.y, restitution=0.5)
    push = 13.73 * sin(5.99 * t - 2.62) - 13.27
    model.force("brake", ball, fx=2 + sign(ball.vy), fy=push - 4.5 * sign(ball.vy))
    start = {ball.x: 0, ball.y: 1.21, ball.vx: 0, ball.vy: 0}
    model.scene("run", ["floor", "brake"], start=start)
    run = load(model, "run", folder=workshop).simulate(1.5, [1.4, 1.5], rtol=1e-9, progress=False)
    assert run.outcome is Outcome.OK
    assert_allclose(run.a("ball.x"), 2.0)
    assert_allclose(run.v("ball.y"), 0.0)
