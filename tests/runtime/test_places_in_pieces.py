"""Places and gaps by pieces of the time: what lies on them follows, and steps end at the pieces."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from sympy import Abs, Expr, Heaviside, Max, Piecewise

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.results.result import Result

LIFT = Piecewise((0.2 * t**2, t < 0.5), (0.1 - 0.2 * (1 - t) ** 2, t < 1), (0.1, True))
RISE = Max(0, t - 1) ** 2
SOFT = {"stiffness": 1e4, "damping": 50.0, "may_pull": False}


@pytest.fixture
def dropped(workshop: Path) -> Callable[..., Result]:
    """A ball that falls 0.3 m onto a floor at a height of the time."""

    def run(name: str, height: Expr, kind: str, settings: dict[str, str], **law: float) -> Result:
        model, drivers = Model(f"floor_{name}_{kind}", gravity=(0, -9.81)), []
        ball = model.particle("ball", mass=1.0)
        model.absolute("rail", ball, "x", 0.0)
        if kind == "gap":
            model.contact("floor", gap=ball.y - height, **law)
        elif kind == "place":
            model.contact("floor", model.ground.at(0, height), ball, direction=(0, 1), **law)
        elif kind == "stop":
            law.pop("may_pull", None)
            model.stop("floor", ball.y, lower=height, **law)
        else:
            body = model.particle("body", mass=1.0)
            model.absolute("rail_of_body", body, "x", 0.0)
            model.driver("lift", body.y, height)
            model.contact("floor", gap=ball.y - body.y, **law)
            drivers = ["lift"]
        start = {ball.y: 0.3, ball.vy: 0.0}
        model.scene("drop", ["gravity", "floor"], drivers=drivers, start=start)
        return load(model, folder=workshop).simulate(2.0, 9, **settings)

    return run


@pytest.mark.parametrize("kind", ["gap", "place", "stop"])
@pytest.mark.parametrize(
    ("name", "height", "law"),
    [
        ("lift", LIFT, {"restitution": 0.0}),
        ("bouncing", LIFT, {"restitution": 0.5}),
        ("soft", LIFT, SOFT),
        ("rise", RISE, {"restitution": 0.0}),
        ("late", Heaviside(t - 1) * RISE, {"restitution": 0.0}),
    ],
)
def test_a_ball_follows_the_floor_as_one_that_is_driven(
    dropped: Callable[..., Result], name: str, height: Expr, law: dict[str, float], kind: str
) -> None:
    settings = {"formulation": "reduced"} if kind == "gap" else {}
    result = dropped(name, height, kind, settings, **law)
    body = dropped(name, height, "body", {}, **law)
    assert result.outcome is body.outcome is Outcome.OK
    np.testing.assert_allclose(result.q("ball.y"), body.q("ball.y"), atol=1e-6)
    np.testing.assert_allclose(result.v("ball.vy"), body.v("ball.vy"), atol=1e-5)
    assert name != "lift" or result.q("ball.y")[-1] == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "height", "instant", "said"),
    [
        ("jump", 0.1 * Heaviside(t - 1), 1.0, "'floor' jumps by 0.1 at t = 1 s"),
        ("ramp", Max(0, t - 1) / 2, 1.0, "rate that jumps by 0.5 a second at t = 1 s, while"),
        ("cycle", Abs(t - 1.5) / 5, 1.5, "rate that jumps by 0.4 a second at t = 1.5 s, while"),
    ],
)
def test_a_floor_that_jumps_under_a_ball_ends_the_run(
    dropped: Callable[..., Result], name: str, height: Expr, instant: float, said: str
) -> None:
    result = dropped(name, height, "place", {}, restitution=0.0)
    assert result.outcome is Outcome.DISCONTINUOUS
    assert result.t[-1] == pytest.approx(instant)
    assert said in result.message


@pytest.mark.parametrize("given", ["place", "slip"])
def test_friction_slides_where_its_belt_starts_or_stops_at_once(workshop: Path, given: str) -> None:
    """A belt that turns back from -0.1 to 0.1 m/s draws the block along at μ g."""
    model = Model(f"belt_by_{given}")
    block = model.particle("block", mass=1.0)
    model.absolute("rail", block, "y", 0.0)
    law = {"coefficient": 0.1, "normal": 9.81}
    if given == "place":
        model.dry_friction("belt", model.ground.at(Abs(t - 1) / 10, 0), block, **law)
    else:
        model.dry_friction("belt", slip=block.vx - Piecewise((-0.1, t < 1), (0.1, True)), **law)
    model.scene("run", ["belt"], start={block.x: 0.0, block.vx: -0.1})
    result = load(model, folder=workshop).simulate(2.0, 3)
    assert result.outcome is Outcome.OK
    assert result.v("block.vx") == pytest.approx([-0.1, -0.1, 0.1])
    sliding = 0.2 / 0.981
    assert result.q("block.x")[-1] == pytest.approx(-0.1 + 0.1 * (1 - sliding), abs=1e-8)


def test_a_journal_hangs_in_a_bearing_that_moves_off(workshop: Path) -> None:
    model = Model("bearing_in_pieces", gravity=(0, -9.81))
    journal = model.particle("journal", mass=1.0)
    bearing = model.ground.at(Max(0, t - 1) ** 2 / 10, 0)
    model.clearance_joint("pin", bearing, journal, clearance=0.01, stiffness=1e5, damping=3.0)
    x, y = journal.x, journal.y
    model.scene("run", ["gravity", "pin"], start={x: 0.001, y: -0.01, journal.vx: 0, journal.vy: 0})
    result = load(model, folder=workshop).simulate(2.0)
    assert result.outcome is Outcome.OK
    off = np.hypot(
        result.q("journal.x") - np.maximum(0, result.t - 1) ** 2 / 10, result.q("journal.y")
    )
    assert off.max() < 0.0135
    assert off[-1] == pytest.approx(0.01 + (9.812 / 1e5) ** (2 / 3), abs=1e-4)
