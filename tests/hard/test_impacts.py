"""Impacts of several contacts at once, and what they do to what holds."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from runtime import load
from runtime.core.outcomes import Outcome
from runtime.integrate.method import EXPLICIT
from runtime.machine_facade import Machine
from tests.hard.result_readings import changes, held

G = 9.81


@pytest.fixture(scope="module")
def colliding(request: pytest.FixtureRequest) -> Callable[[str], Machine]:
    """A scene of `colliding.py`, built beside pytest's cache."""
    folder: Path = request.config.cache.mkdir("hard")
    path = Path(__file__).with_name("colliding.py")
    return lambda scene: load(path, scene, folder=folder)


@pytest.mark.parametrize("e", [1.0, 0.5, 0.0])
def test_ball_against_two_that_touch(colliding: Callable[[str], Machine], e: float) -> None:
    """Newton's law at both contacts in one instant: the two do not part from each other."""
    run = colliding("cradle").simulate(3.0, rtol=1e-9, parameters={"e": e})
    assert run.outcome is Outcome.OK
    (struck,) = changes(run, "pair0", "impact" if e else "holds")
    assert struck == pytest.approx(1.0, abs=1e-14)
    v0, v1, v2 = (run.v(f"ball{k}.x")[-1] for k in range(3))
    assert v0 + v1 + v2 == pytest.approx(1.0, abs=1e-14)
    assert v1 - v0 == pytest.approx(e, abs=1e-14)
    assert v2 == pytest.approx(v1, abs=1e-14)


@pytest.mark.parametrize("e", [0.0, 0.5, 0.8])
@pytest.mark.parametrize("rtol", [1e-6, 1e-11])
def test_ball_in_a_corner(colliding: Callable[[str], Machine], e: float, rtol: float) -> None:
    run = colliding("corner").simulate(6.0, rtol=rtol, parameters={"e": e})
    assert run.outcome is Outcome.OK
    due = np.sqrt(2.0 / G) * (1.0 + e) / (1.0 - e)
    for name in ("left", "right"):
        (rest,) = changes(run, name, "holds")
        assert rest == pytest.approx(due, abs=1e-9)
        force = run.reaction(name, "force")[run.t > due + 1e-6]
        np.testing.assert_allclose(force, G / np.sqrt(2.0), rtol=1e-12)
    assert abs(run.q("ball0.x")[-1]) < 1e-12
    assert abs(run.q("ball0.y")[-1]) < 1e-12


def test_ball_without_clearance_stays_and_the_walls_take_turns(
    colliding: Callable[[str], Machine],
) -> None:
    run = colliding("fitting").simulate(5.0, np.linspace(0.0, 5.0, 501), rtol=1e-9)
    assert run.outcome is Outcome.OK
    assert np.abs(run.q("ball0.x")).max() < 1e-12
    here, there = (run.reaction(name, "force") for name in ("here", "there"))
    np.testing.assert_allclose(there - here, 30.0 * np.sin(3.0 * run.t), atol=1e-9)
    assert min(here.min(), there.min()) > -1e-9


def test_impact_tears_loose_what_stuck(colliding: Callable[[str], Machine]) -> None:
    machine = colliding("tray")
    run = machine.simulate(1.0, "steps", rtol=1e-11, parameters={"e": 1.0, "push": 40.0})
    struck = next(e for e in run.events if e.what == "impact")
    vx = [machine.coordinates.index(f"{name}.x") for name in ("tray", "block")]
    before = run.v("block.x")[run.t <= struck.time][-1]
    assert held(run, "sticks")[run.t <= struck.time].all()
    # 2 kg with this velocity against 1 kg at rest, without loss.
    np.testing.assert_allclose(struck.v[vx], [4.0 / 3.0 * before, before / 3.0], rtol=1e-9)
    assert struck.time in changes(run, "sticks", "began")


@pytest.mark.parametrize("method", EXPLICIT)
def test_bouncing_that_friction_meddles_with_ends_at_one_time(
    colliding: Callable[[str], Machine], method: str
) -> None:
    """Friction brakes one half of each flight and drives the other: flights do not shrink by e."""
    machine = colliding("tray")
    ends = [
        changes(machine.simulate(1.0, rtol=rtol, method=method), "stop", "holds")[0]
        for rtol in (1e-7, 1e-9, 1e-12)
    ]
    assert ends[0] == pytest.approx(ends[2], abs=1e-6)
    assert ends[1] == pytest.approx(ends[2], abs=1e-8)


@pytest.mark.parametrize("rtol", [1e-2, 1e-3, 1e-5])
def test_a_contact_that_parts_for_less_than_the_tolerance_stays_shut(
    colliding: Callable[[str], Machine], rtol: float
) -> None:
    """The tip comes back to the floor before it has left it by more than a step's error.

    Its next impacts are where it came back: the floor must not give way with each of them.
    """
    run = colliding("arms").simulate(5.0, rtol=rtol)
    assert run.outcome is Outcome.OK
    assert len(changes(run, "floor", "began")) > 1
    tip = run.q("forearm.y") + 0.5 * np.sin(run.q("forearm.phi")) + 1.2
    elbow = run.q("arm.x") + 0.5 * np.cos(run.q("arm.phi")) + 0.2
    assert min(tip.min(), elbow.min()) > -3.0 * rtol


@pytest.mark.parametrize("rtol", [1e-3, 1e-8, 1e-11])
def test_contacts_that_touch_keep_the_sign_of_their_gaps(
    colliding: Callable[[str], Machine], rtol: float
) -> None:
    """A gap of -1e-16 between two that touch is rounding, and no missed event."""
    start = {"ball1.x": 0.5, "ball2.x": 0.6}
    run = colliding("cradle").simulate(5.0, rtol=rtol, start=start)
    assert run.outcome is Outcome.OK
