"""Crossings are located, decided and recorded; sliding and Zeno have names."""

import numpy as np
import pytest

from runtime.core.kinds import SLIDING
from runtime.core.outcomes import Outcome
from runtime.integrate.method import EXPLICIT
from runtime.integrate.run import initial_modes
from tests.runtime.integrate.systems import relay, run_relay

UP_V = (0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)  # watches v > 0 and does nothing


def watch_q(level, force=0.0):
    return (force, 0.0, 0.0, 1.0, 0.0, 0.0, -level)


@pytest.mark.parametrize("method", EXPLICIT)
def test_crossing_of_free_fall_is_exact(method):
    # q = 1 - t^2 / 2 falls through 0.5 at t = 1.
    r = run_relay(relay(watch_q(0.5), constant=-1.0), 1.0, 0.0, 3.0, method=method)
    assert r.outcome == Outcome.OK
    assert r.events.index.tolist() == [0]
    assert r.events.direction.tolist() == [-1]
    assert r.events.t[0] == pytest.approx(1.0, abs=1e-14)
    assert abs(r.events.q[0, 0] - 0.5) < 1e-14
    assert r.final_q[0] == pytest.approx(1.0 - 4.5, abs=1e-13)


@pytest.mark.parametrize("method", EXPLICIT)
def test_relay_driven_oscillator(method):
    # a = -4 q + (1 where v > 0, -1 where v < 0): the amplitude grows by 0.5 each half turn.
    system = relay((2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0), constant=-1.0, stiffness=4.0)
    r = run_relay(system, 1.0, 0.0, 10.0, method=method, tolerance=1e-12)
    assert r.outcome == Outcome.OK
    # v = 0 every half period of the shifted oscillator; its extremes are -(1 + 0.5), 2.0, ...
    halves = np.arange(1, r.events.t.size + 1)
    np.testing.assert_allclose(r.events.t, halves * np.pi / 2.0, rtol=0, atol=2e-11)
    np.testing.assert_allclose(
        r.events.q[:, 0], (-1.0) ** halves * (1.0 + 0.5 * halves), rtol=0, atol=3e-10
    )
    assert r.events.direction.tolist() == [1 if k % 2 else -1 for k in halves]


@pytest.mark.parametrize("method", EXPLICIT)
def test_touch_from_below(method):
    # q = 1 - (t - 1)^2 touches 1 exactly; v changes sign at the same instant and is watched too.
    system = relay(watch_q(1.0, force=5.0), UP_V, constant=-2.0)
    r = run_relay(system, 0.0, 2.0, 2.0, method=method)
    assert r.outcome == Outcome.OK
    assert r.events.index.tolist() == [1]
    assert r.events.t[0] == pytest.approx(1.0, abs=1e-14)
    assert r.final_q[0] == pytest.approx(0.0, abs=1e-12)
    assert r.statistics.steps < 60


@pytest.mark.parametrize("method", EXPLICIT)
def test_touch_from_above_with_acting_condition(method):
    # With the condition a = -3 + 5 = 2, so that q = 1 + (t - 1)^2 touches 1 with the force acting.
    system = relay(watch_q(1.0, force=5.0), UP_V, constant=-3.0)
    r = run_relay(system, 2.0, -2.0, 2.0, method=method)
    assert r.outcome == Outcome.OK
    assert r.events.index.tolist() == [1]
    assert r.events.t[0] == pytest.approx(1.0, abs=1e-14)
    assert r.final_q[0] == pytest.approx(2.0, abs=1e-12)


@pytest.mark.parametrize("method", EXPLICIT)
def test_simultaneous_roots_are_decided_together(method):
    # Two functions with the same zero but other slopes, and a third that follows an instant later.
    system = relay(
        (1.0, 0.0, 0.0, 1.0, 0.0, 0.0, -0.5),
        (2.0, 0.0, 0.0, -3.0, 0.0, 0.0, 1.5),
        (4.0, 0.0, 0.0, 1.0, 0.0, 0.0, -0.5 - 1e-9),
    )
    r = run_relay(system, 0.0, 1.0, 2.0, method=method)
    # Below 0.5 the force 2 of the second function acts; above it 1, then 1 + 4.
    v = np.sqrt(1.0 + 2.0 * 2.0 * 0.5)
    t1 = (v - 1.0) / 2.0
    assert r.outcome == Outcome.OK
    assert r.events.index.tolist() == [0, 1, 2]
    assert r.events.direction.tolist() == [1, -1, 1]
    np.testing.assert_allclose(r.events.t[:2], t1, rtol=0, atol=1e-14)
    assert r.events.t[2] - t1 == pytest.approx(1e-9 / v, rel=1e-5)
    rest = 2.0 - t1 - 1e-9 / v
    assert r.final_v[0] == pytest.approx(v + 5.0 * rest, abs=1e-7)


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_modes_at_a_start_on_the_surface(method, sign):
    # v = 0 at the start: the condition v > 0 holds at once if the acceleration is positive.
    system = relay((0.5, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0), constant=sign)
    modes = initial_modes(system[0], 0.0, np.zeros(1), np.zeros(1), system[1])
    assert modes.tolist() == [1 if sign > 0 else 0]
    r = run_relay(system, 0.0, 0.0, 1.0, method=method)
    assert r.events.t.size == 0
    assert r.final_v[0] == pytest.approx(1.5 if sign > 0 else -1.0, abs=1e-12)


def test_mode_of_a_position_limit_at_a_dead_centre_start():
    # q = 0, v = 0, a = -1: q > 0 does not hold, though neither q nor its rate says so.
    system = relay(watch_q(0.0), constant=-1.0)
    assert initial_modes(system[0], 0.0, np.zeros(1), np.zeros(1), system[1]).tolist() == [0]
    system = relay(watch_q(0.0), constant=1.0)
    assert initial_modes(system[0], 0.0, np.zeros(1), np.zeros(1), system[1]).tolist() == [1]


@pytest.mark.parametrize("method", EXPLICIT)
def test_event_at_start_and_at_end(method):
    system = relay(watch_q(0.0), watch_q(2.0))
    r = run_relay(system, 0.0, 1.0, 2.0, method=method, t_eval=[0.0, 1.0, 2.0])
    # q = 0 at the start is passed upwards at once: no event. q = 2 is met exactly at the end.
    assert r.outcome == Outcome.OK
    assert 0 not in r.events.index.tolist()
    assert r.t.tolist() == [0.0, 1.0, 2.0]
    np.testing.assert_allclose(r.q[:, 0], [0.0, 1.0, 2.0], atol=1e-14)


@pytest.mark.parametrize("method", EXPLICIT)
def test_sample_at_an_event(method):
    r = run_relay(
        relay(watch_q(0.5), constant=-1.0), 1.0, 0.0, 3.0, method=method, t_eval=[0.5, 1.0, 2.0]
    )
    np.testing.assert_allclose(r.q[:, 0], [0.875, 0.5, -1.0], atol=1e-13)
    assert r.modes[0, 0] == 1
    assert r.modes[2, 0] == 0


@pytest.mark.parametrize("method", EXPLICIT)
def test_motion_goes_on_along_a_surface_that_attracts(method):
    # Dry friction on a body that is pushed less than it holds: a = 0.5 - sign(v).
    system = relay((-2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0), constant=1.5)
    r = run_relay(system, 0.0, 1.0, 10.0, method=method)
    assert r.outcome == Outcome.OK
    assert r.events.t[0] == pytest.approx(2.0, abs=1e-13)
    assert r.events.direction.tolist() == [0]
    assert r.final_modes.tolist() == [SLIDING]
    assert abs(r.final_v[0]) < 1e-13
    assert r.final_q[0] == pytest.approx(1.0, abs=1e-12)


def test_motion_begins_on_a_surface_that_attracts():
    system = relay((-2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0), constant=1.5)
    r = run_relay(system, 0.0, 0.0, 10.0)
    assert r.outcome == Outcome.OK
    assert r.events.t.size == 0
    assert r.modes[:, 0].tolist() == [SLIDING] * r.t.size
    assert np.abs(r.q).max() == 0.0


def test_where_no_side_is_consistent_and_nothing_can_hold_it_is_said():
    # q > 0 pulls down and q < 0 pushes up, at rest at 0: the force does not act on dq/dt.
    system = relay((-2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), constant=1.0)
    r = run_relay(system, 0.0, 0.0, 1.0)
    assert r.outcome == Outcome.INCONSISTENT
    assert r.index == 0
    assert r.final_t == 0.0
    assert "jams" in r.outcome.advice


@pytest.mark.parametrize("method", EXPLICIT)
def test_zeno_is_named(method):
    # a = -sign(q) - 0.5 sign(v) spirals into the origin in a finite time.
    system = relay(
        (-2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), (-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0), constant=1.5
    )
    r = run_relay(system, 1.0, 0.0, 100.0, method=method)
    # Quarter turns: from q with v = 0 to q = 0 at v = sqrt(q), then to -q / 3.
    ratio = np.sqrt(1.0 / 3.0)
    first = np.sqrt(2.0 / 0.5) + np.sqrt(2.0 * 0.5) / 1.5
    assert r.outcome == Outcome.ZENO
    assert r.final_t == pytest.approx(first / (1.0 - ratio), abs=1e-3)
    assert r.final_t < 10.0


@pytest.mark.parametrize("method", EXPLICIT)
def test_stiff_contact_is_met_every_time(method):
    # A ball on a spring of stiffness 1e4 below q = 0 under gravity: it returns to its height.
    g, k = 9.81, 1e4
    system = relay((0.0, k, 0.0, 1.0, 0.0, 0.0, 0.0), constant=-g, stiffness=k)
    r = run_relay(system, 1.0, 0.0, 5.0, method=method, tolerance=1e-11)
    assert r.outcome == Outcome.OK
    fall = np.sqrt(2.0 / g)
    v = g * fall
    omega = np.sqrt(k)
    contact = (2.0 * np.pi - 2.0 * np.arctan2(v * omega, g)) / omega
    period = 2.0 * fall + contact
    down = r.events.t[r.events.direction == -1]
    np.testing.assert_allclose(down, fall + np.arange(down.size) * period, atol=5e-9)
    energy = 0.5 * r.final_v[0] ** 2 + g * r.final_q[0] + 0.5 * k * min(r.final_q[0], 0.0) ** 2
    assert energy == pytest.approx(g, rel=1e-8)


def test_watching_costs_no_step():
    # A function that never comes near zero asks for no dense output.
    far = relay(watch_q(100.0), stiffness=1.0)
    plain = relay(stiffness=1.0)
    a = run_relay(far, 1.0, 0.0, 20.0, t_eval=[])
    b = run_relay(plain, 1.0, 0.0, 20.0, t_eval=[])
    assert a.statistics.dense_outputs == 0
    assert a.statistics.steps == b.statistics.steps
    assert a.final_q[0] == b.final_q[0]
