"""Steps are short enough to see the switching functions, and no shorter."""

import numpy as np
import pytest

from runtime.core.kernel_abi import SIGNATURES
from runtime.core.outcomes import Outcome
from runtime.integrate.method import EXPLICIT
from tests.runtime.integrate.systems import (
    ACCURATE,
    free_system,
    kernel,
    relay,
    relay_accelerations,
    run_relay,
)

TOLERANCES = (1e-3, 1e-6, 1e-8, 1e-10, 1e-12)

# A window is (f, c, d, alpha, level, gamma, delta): sin(alpha q + gamma t + delta) > level, with
# the accelerations of `relay`.


@kernel(SIGNATURES["switching"])
def wave(t, q, v, p, g):
    for k in range(g.size):
        i = 6 + 7 * k
        g[k] = np.sin(p[i] * q[0] + p[i + 2] * t + p[i + 3]) - p[i + 1]


@kernel(SIGNATURES["switching_rates"])
def wave_rates(t, q, v, a, p, rate):
    for k in range(rate.size):
        i = 6 + 7 * k
        rate[k] = np.cos(p[i] * q[0] + p[i + 2] * t + p[i + 3]) * (p[i] * v[0] + p[i + 2])


@kernel(SIGNATURES["switching"])
def kinked(t, q, v, p, g):
    g[0] = abs(q[0])


@kernel(SIGNATURES["switching_rates"])
def kinked_rates(t, q, v, a, p, rate):
    rate[0] = v[0] if q[0] > 0.0 else -v[0]


@kernel(SIGNATURES["switching"])
def rounded(t, q, v, p, g):
    g[0] = (1e-9 * q[0] + 1e6) - 1e6  # nine different values


@kernel(SIGNATURES["switching_rates"])
def rounded_rates(t, q, v, a, p, rate):
    rate[0] = 1e-9 * v[0]


def watched(functions, *switches, **terms):
    """A `relay` with other switching functions."""
    _, p = relay(*switches, **terms)
    system = free_system(
        accelerations=relay_accelerations,
        switches=len(switches),
        switching=functions[0],
        switching_rates=functions[1],
    )
    return system, p


def windows(*switches, **terms):
    return watched((wave, wave_rates), *switches, **terms)


def passages(rate, phase, level, t_end):
    """Instants at which sin(rate t + phase) passes the level."""
    up = np.arcsin(level)
    turns = 2.0 * np.pi * np.arange(-2, 2 + rate * t_end)
    t = (np.concatenate([up + turns, np.pi - up + turns]) - phase) / rate
    return np.sort(t[(t > 0.0) & (t < t_end)])


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_windows_of_the_angle_of_a_rotor(method, tolerance):
    # Braked where cos(q) > 0.9; between, the motion is known exactly and the step would grow.
    brake = (-0.5, 0.0, 0.0, 1.0, 0.9, 0.0, np.pi / 2)
    r = run_relay(windows(brake), 1.0, 10.0, 10.0, method=method, tolerance=tolerance)
    assert r.outcome == Outcome.OK
    assert r.events.t.size == 30
    assert np.all(r.events.direction == np.tile([1, -1], 15))
    np.testing.assert_allclose(np.cos(r.events.q[:, 0]), 0.9, atol=1e-10)
    # Work of the brake: 15 windows of 2 arccos(0.9).
    assert r.final_v[0] ** 2 == pytest.approx(100.0 - 15 * 2.0 * np.arccos(0.9), rel=1e-9)
    assert r.statistics.steps + r.statistics.rejected < 30 * 8


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_windows_of_time(method, tolerance):
    push = (1.0, 0.0, 0.0, 0.0, 0.999, 2.0, 0.0)
    r = run_relay(windows(push), 0.0, 0.0, 10 * np.pi, method=method, tolerance=tolerance)
    assert r.outcome == Outcome.OK
    np.testing.assert_allclose(r.events.t, passages(2.0, 0.0, 0.999, 10 * np.pi), atol=1e-11)
    assert r.final_v[0] == pytest.approx(10 * np.arccos(0.999), rel=1e-9)
    assert r.statistics.steps + r.statistics.rejected < 20 * 8


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-8])
@pytest.mark.parametrize("levels", [(0.99999, -0.9), (0.5, 0.999), (-0.99999, 0.0)])
@pytest.mark.parametrize("rates", [(1.0, 37.0), (12.0, 12.5)])
def test_two_functions(method, tolerance, levels, rates):
    switches = [
        (0.0, 0.0, 0.0, rate / 10.0, level, 0.0, 0.3)
        for rate, level in zip(rates, levels, strict=True)
    ]
    r = run_relay(windows(*switches), 0.0, 10.0, 20.0, method=method, tolerance=tolerance)
    assert r.outcome == Outcome.OK
    for k in range(2):
        due = passages(rates[k], 0.3, levels[k], 20.0)
        np.testing.assert_allclose(r.events.t[r.events.index == k], due, atol=1e-8)


@pytest.mark.parametrize("method", EXPLICIT)
def test_the_first_step_is_watched_too(method):
    push = (0.0, 0.0, 0.0, 0.0, 0.9, 2.0 * np.pi, 0.0)
    r = run_relay(windows(push), 0.0, 1.0, 64.0, method=method, first_step=64.0)
    assert r.events.t.size == 128


@pytest.mark.parametrize("method", EXPLICIT)
def test_resolved_steps_are_kept(method):
    # q > 30 degrees, and sin(q) > 1/2: the same events, and the same steps between them.
    linear = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -np.pi / 6)
    plain = run_relay(relay(linear, stiffness=1.0), 1.0, 0.0, 50.0, method=method)
    sine = (0.0, 0.0, 0.0, 1.0, 0.5, 0.0, 0.0)
    r = run_relay(windows(sine, stiffness=1.0), 1.0, 0.0, 50.0, method=method)
    assert r.events.t.size == plain.events.t.size == 16
    assert r.statistics.rejected == plain.statistics.rejected
    assert abs(r.statistics.steps - plain.statistics.steps) <= 2


@pytest.mark.parametrize("method", EXPLICIT)
def test_far_functions_cost_no_step(method):
    far = (0.0, 0.0, 0.0, 0.0, -100.0, 1e4, 0.0)
    r = run_relay(windows(far), 0.0, 1.0, 10.0, method=method)
    assert r.statistics.steps + r.statistics.rejected < 20


@pytest.mark.parametrize("method", ACCURATE)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-9])
@pytest.mark.parametrize("functions", [(kinked, kinked_rates), (rounded, rounded_rates)])
def test_what_no_step_resolves_does_not_shrink_them_for_good(method, tolerance, functions):
    system = watched(functions, (0.0,) * 7, stiffness=1.0)
    r = run_relay(system, 1.0, 0.0, 20.0, method=method, tolerance=tolerance, max_steps=2000)
    assert r.outcome == Outcome.OK


@pytest.mark.parametrize("method", EXPLICIT)
def test_fixed_steps_stay_fixed(method):
    push = (0.0, 0.0, 0.0, 0.0, 0.9, 7.0, 0.0)
    r = run_relay(windows(push), 0.0, 1.0, 10.0, method=method, fixed_step=2.5)
    assert r.statistics.rejected == 0
    # Besides the last one, only steps that end at an event are shorter.
    assert r.statistics.steps <= 4 + r.events.t.size
