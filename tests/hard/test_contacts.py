"""Rigid contacts: the end of bouncing, contact forces, release, and contact again."""

import numpy as np
import pytest

from runtime import load
from runtime.core.outcomes import Outcome
from runtime.integrate.method import EXPLICIT
from tests.hard.result_readings import changes, held
from tests.runtime.integrate.systems import ACCURATE

G = 9.81


# A ball that bounces.


@pytest.mark.parametrize("method", ACCURATE)
@pytest.mark.parametrize("e", [0.0, 0.3, 0.5, 0.8, 0.9])
@pytest.mark.parametrize("rtol", [1e-5, 1e-8, 1e-12])
def test_ball_rests_at_the_exact_time(method: str, e: float, rtol: float) -> None:
    machine = load("hard/bouncing_ball", "dropped")
    run = machine.simulate(10.0, rtol=rtol, method=method, parameters={"restitution": e})
    assert run.outcome is Outcome.OK
    (rest,) = changes(run, "plate", "holds")
    assert abs(rest - np.sqrt(2.0 / G) * (1.0 + e) / (1.0 - e)) < 1e-9
    after = run.t > rest
    np.testing.assert_allclose(run.q("ball.y")[after], 0.1, atol=1e-14)
    np.testing.assert_allclose(run.reaction("plate", "force")[after], 0.4 * G, rtol=1e-12)
    assert np.all(run.q("ball.y") > 0.1 - 1e-14)
    assert run.stats["steps"] < 400


def test_every_impact_of_the_ball_returns_its_share() -> None:
    run = load("hard/bouncing_ball", "dropped").simulate(10.0, rtol=1e-10)
    impacts = [e for e in run.events if e.what == "impact"]
    due = np.sqrt(2.0 / G) * (1.0 + 2.0 * np.cumsum(0.5 ** np.arange(1, len(impacts))))
    np.testing.assert_allclose([e.time for e in impacts[1:]], due, atol=1e-12)
    speeds = np.array([e.v[1] for e in impacts])  # after the impact
    np.testing.assert_allclose(
        speeds, np.sqrt(2.0 * G) * 0.5 ** np.arange(1, len(speeds) + 1), rtol=1e-6
    )


def test_ball_without_loss_returns_to_its_height() -> None:
    run = load("hard/bouncing_ball", "dropped").simulate(
        100.0, rtol=1e-12, parameters={"restitution": 1.0}
    )
    fall = np.sqrt(2.0 / G)
    due = fall * (2.0 * np.arange(len(run.events)) + 1.0)
    assert len(run.events) > 100
    np.testing.assert_allclose([e.time for e in run.events], due, atol=1e-9)
    assert np.abs(run.energy() / run.energy()[0] - 1.0).max() < 1e-11


@pytest.mark.parametrize("rtol", [1e-5, 1e-8, 1e-12])
def test_table_throws_the_ball_where_its_acceleration_passes_gravity(rtol: float) -> None:
    run = load("hard/bouncing_ball", "shaken").simulate(
        5.0, np.linspace(0.0, 5.0, 5001), rtol=rtol, parameters={"restitution": 0.0}
    )
    thrown = changes(run, "table", "began")
    assert len(thrown) > 10
    # g = A Ω² sin Ωt, while the table rises.
    np.testing.assert_allclose(0.02 * 30.0**2 * np.sin(30.0 * thrown), G, atol=1e-9)
    lies = held(run, "table")
    force = run.reaction("table", "force")
    due = 0.4 * (G - 0.02 * 30.0**2 * np.sin(30.0 * run.t))
    np.testing.assert_allclose(force[lies], due[lies], atol=1e-9)
    assert force[lies].min() > -1e-9
    assert np.abs(force[~lies]).max() == 0.0
    gap = run.q("ball.y") - 0.1 - 0.02 * np.sin(30.0 * run.t)
    assert gap.min() > -1e-12
    assert np.abs(gap[lies]).max() < 1e-12


# A cam and its follower.


def lift(t: np.ndarray, omega: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Place, velocity and acceleration of the pushrod while it follows."""
    e, phase = 0.0025, -np.pi / 2 + omega * t
    return (
        0.0125 + 0.075 + e * np.sin(phase),
        e * omega * np.cos(phase),
        -e * omega**2 * np.sin(phase),
    )


def seat(y: np.ndarray) -> np.ndarray:
    """Force of the spring on the pushrod, downwards."""
    length = 0.0125 - 0.0025 + 0.15 + 0.04 - (y + 0.075)
    return 1000.0 * (0.06 - length)


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
def test_contact_force_is_the_reaction_of_a_driven_follower(rtol: float) -> None:
    run = load("hard/contact_follower", "touching").simulate(
        0.2, np.linspace(0.0, 0.2, 401), rtol=rtol
    )
    assert not run.events
    assert held(run, "face").all()
    y, _, a = lift(run.t, 150.0)
    np.testing.assert_allclose(run.q("pushrod.y"), y, atol=1e-12)
    force = run.reaction("face", "force")
    np.testing.assert_allclose(force, 0.2 * (a + G) + seat(y), rtol=1e-9)
    # The motor bears it on the arm of the eccentric.
    arm = 0.0025 * np.cos(-np.pi / 2 + 150.0 * run.t)
    np.testing.assert_allclose(run.reaction("motor", "torque"), force * arm, atol=1e-9)


def test_follower_is_let_go_where_its_reaction_vanishes() -> None:
    run = load("hard/contact_follower", "thrown").simulate(0.05, rtol=1e-12)
    first = run.events[0]
    assert (first.name.partition(":")[0], first.what) == ("face", "began")
    y, v, a = lift(np.array(first.time), 600.0)
    assert 0.2 * (a + G) + seat(y) == pytest.approx(0.0, abs=1e-7)
    rod = [row.name for row in run.description.coordinates].index("pushrod.y")
    assert first.q[rod] == pytest.approx(y, abs=1e-13)
    assert first.v[rod] == pytest.approx(v, abs=1e-10)


@pytest.mark.parametrize("method", EXPLICIT)
def test_follower_comes_to_contact_again_after_many_impacts(method: str) -> None:
    machine = load("hard/contact_follower", "thrown")
    found = {}
    for rtol in (1e-8, 1e-12):
        run = machine.simulate(0.1, rtol=rtol, method=method, parameters={"omega": 260.0})
        assert run.outcome is Outcome.OK
        found[rtol] = changes(run, "face", "holds")
        assert len(found[rtol]) >= 3
        assert len(changes(run, "face", "impact")) >= 9 * len(found[rtol])
        place = run.q("pushrod.y") - lift(run.t, 260.0)[0]
        assert place.min() > -1e-12
        assert np.abs(place[held(run, "face")]).max() < 1e-12
    np.testing.assert_allclose(found[1e-8], found[1e-12], atol=1e-7)


@pytest.mark.parametrize(("e", "what"), [(0.5, "impact"), (0.0, "holds")])
def test_an_impact_in_the_very_first_instant_is_an_event(e: float, what: str) -> None:
    run = load("hard/bouncing_ball", "dropped").simulate(
        0.1, rtol=1e-9, parameters={"restitution": e}, start={"ball.y": 0.1, "ball.vy": -2.0}
    )
    first = run.events[0]
    assert (first.time, first.what) == (0.0, what)
    assert first.v[1] == pytest.approx(2.0 * e, abs=1e-15)
    assert run.v("ball.y")[0] == pytest.approx(2.0 * e, abs=1e-15)


def test_a_ball_that_lies_there_is_not_struck() -> None:
    run = load("hard/bouncing_ball", "dropped").simulate(1.0, start={"ball.y": 0.1})
    assert run.events == ()
    assert held(run, "plate").all()


@pytest.mark.parametrize("rtol", [1e-12, 1e-13])
def test_bdf_goes_on_from_where_the_bouncing_ended(rtol: float) -> None:
    """What is held begins without the velocity of the last impact, which no surface permits."""
    run = load("hard/bouncing_ball", "dropped").simulate(5.0, method="bdf", rtol=rtol)
    assert run.outcome is Outcome.OK, run.message
    assert run.t[-1] == 5.0
    np.testing.assert_allclose(run.q("ball.y")[run.t > 1.36], 0.1, atol=1e-13)
