"""Roots of switching functions are located to 1e-12 of the step that they lie in."""

import numpy as np
import pytest

from runtime.core.outcomes import Outcome
from runtime.integrate.method import EXPLICIT
from tests.runtime.integrate.systems import relay, run_relay

NEAR = 1e-12  # of the step


def position(level):
    """q > level, which does nothing."""
    return (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -level)


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("h", [1e-3, 1.0, 1e3])
def test_two_roots_in_one_step(method, seed, h):
    # q = (t - r1) (t - r2)/h² with the step h.
    first, second = np.sort(np.random.default_rng(seed).uniform(0.02, 0.98, 2)) * h
    second = max(second, first + 0.01 * h)
    r = run_relay(
        relay(position(0.0), constant=2.0 / h**2),
        first * second / h**2, -(first + second) / h**2, h, method=method, first_step=h,
    )  # fmt: skip
    assert r.events.direction.tolist() == [-1, 1]
    np.testing.assert_allclose(r.events.t, [first, second], rtol=0, atol=NEAR * h)


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("height", [1.0, 1e-3, 1e-6, 1e-9])
def test_root_at_the_start_and_the_return_to_it(method, height):
    # q = 4 height t (1 - t): from zero at once upwards, and back at t = 1.
    r = run_relay(
        relay(position(0.0), constant=-8.0 * height),
        0.0, 4.0 * height, 1.5, method=method, first_step=1.5, atol_q=1e-13, atol_v=1e-13,
    )  # fmt: skip
    assert r.modes[1, 0] == 1
    assert r.events.direction.tolist() == [-1]
    assert r.events.t[0] == pytest.approx(1.0, abs=NEAR)


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("depth", [1e-4, 1e-7, 1e-10])
def test_a_dip_has_two_roots_and_a_hover_none(method, depth):
    # q = (t - 1)² ± depth around 0, where time itself is known to the rounding over the root.
    dip = run_relay(relay(position(0.0), constant=2.0), 1.0 - depth, -2.0, 2.0, method=method)
    hover = run_relay(relay(position(0.0), constant=2.0), 1.0 + depth, -2.0, 2.0, method=method)
    assert hover.events.t.size == 0
    assert dip.events.direction.tolist() == [-1, 1]
    half = np.sqrt(depth)
    np.testing.assert_allclose(dip.events.t, [1.0 - half, 1.0 + half], atol=4e-15 / half)


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("first_step", [None, 2.0])
def test_a_root_that_only_touches_is_no_event(method, first_step):
    r = run_relay(
        relay(position(0.0), constant=2.0), 1.0, -2.0, 2.0, method=method, first_step=first_step
    )
    assert r.outcome == Outcome.OK
    assert r.final_q[0] == pytest.approx(1.0, abs=1e-13)
    # Rounding may take it across and back, at the touch and at once.
    assert r.events.t.size in (0, 2)
    assert np.abs(r.events.t - 1.0).max(initial=0.0) < 1e-7
    assert r.final_modes.tolist() == [1]


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("apart", [0.0, 1e-14, 1e-12, 1e-9])
def test_roots_of_several_functions_at_one_time(method, apart):
    # Four functions of other slopes and signs; the last a little later.
    switches = [
        (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -0.5),
        (0.0, 0.0, 0.0, -1e3, 0.0, 0.0, 5e2),
        (0.0, 0.0, 0.0, 0.0, 0.0, 1e-3, -5e-4),
        (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -0.5 - apart),
    ]
    r = run_relay(relay(*switches), 0.0, 1.0, 1.0, method=method, first_step=1.0)
    assert sorted(r.events.index.tolist()) == [0, 1, 2, 3]
    due = np.where(r.events.index == 3, 0.5 + apart, 0.5)
    np.testing.assert_allclose(r.events.t, due, rtol=0, atol=NEAR)
    assert r.final_modes.tolist() == [1, 0, 1, 1]


@pytest.mark.parametrize("method", EXPLICIT)
def test_many_roots_in_a_step_of_free_motion(method):
    levels = np.linspace(0.05, 0.95, 12)
    r = run_relay(
        relay(*(position(level) for level in levels)), 0.0, 1.0, 1.0, method=method, first_step=1.0
    )
    np.testing.assert_allclose(r.events.t, levels, rtol=0, atol=NEAR)
    assert r.events.index.tolist() == list(range(12))
