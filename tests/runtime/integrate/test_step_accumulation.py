"""A run whose steps or events crowd before an instant ends by name; one that is dear goes on."""

from dataclasses import replace

import numpy as np
import pytest

from runtime.core.kernel_abi import SIGNATURES
from runtime.core.outcomes import Outcome
from runtime.integrate.problem import Options, Passage, Problem, Stops
from tests.runtime.integrate.systems import free_system, integrate, kernel


@kernel(SIGNATURES["accelerations"])
def crowded_accelerations(t, q, v, p, modes, a, lam):
    left = np.hypot(1.0 - p[1] * t, p[2])
    a[0] = modes[0] if modes.size > 0 else p[0] * np.sin(p[0] * t / left) / left**2
    return 0


@kernel(SIGNATURES["switching"])
def crowded_switching(t, q, v, p, g):
    g[0] = np.sin(1.0 / (1.0 - t))


@kernel(SIGNATURES["switching_rates"])
def crowded_rates(t, q, v, a, p, rates):
    rates[0] = np.cos(1.0 / (1.0 - t)) / (1.0 - t) ** 2


CROWDED = free_system(accelerations=crowded_accelerations)
SWITCHED = free_system(
    accelerations=crowded_accelerations,
    switching=crowded_switching,
    switching_rates=crowded_rates,
    switches=1,
)


def problem(t_end, turns, pole, least=0.0):
    start, p = np.zeros(1), np.array([turns, pole, least])
    return Problem(0.0, t_end, start, start, p, np.ones(1))


@pytest.mark.parametrize("method", ["dopri5", "dop853"])
@pytest.mark.parametrize("t_end", [1.0, 3.0])
def test_turns_that_crowd_end_the_run(method, t_end):
    r = integrate(CROWDED, problem(t_end, 1.0, 1.0), Options(method=method, t_eval=[0.0, t_end]))
    assert r.outcome == Outcome.STEP_TOO_SMALL
    assert 0.99 < r.final_t < 1.0
    assert r.statistics.steps < 600_000


def test_events_that_crowd_end_the_run_and_are_named():
    r = integrate(SWITCHED, problem(1.0, 0.0, 0.0), Options(t_eval=[0.0, 1.0]))
    assert r.outcome == Outcome.ZENO
    assert r.index == 0
    assert "add up to t = 0.99999" in r.note
    assert 0.99 < r.final_t < 1.0
    assert r.statistics.steps < 300_000


def test_many_turns_at_a_constant_pace_are_followed():
    r = integrate(CROWDED, problem(1.0, 3e5, 0.0), Options(t_eval=[0.0, 1.0]))
    assert r.outcome == Outcome.OK
    assert r.statistics.steps > 65_536


@pytest.mark.parametrize("left", [1e-4, 5e-5])
def test_turns_up_to_an_instant_before_the_pole_are_followed(left):
    settings = Options(method="dopri5", t_eval=[0.0, 1.0 - left])
    r = integrate(CROWDED, problem(1.0 - left, 10.0, 1.0), settings)
    assert r.outcome == Outcome.OK
    assert r.statistics.steps > 300_000


def test_turns_that_crowd_and_then_do_not_are_followed_with_steps_of_ones_own():
    """Steps shrink as before a pole, and grow again: nobody can tell the two beforehand."""
    begun = problem(1.1, 10.0, 1.0, 5e-5)
    settings = Options(method="dopri5", t_eval=[0.0, 1.1])
    ended = integrate(CROWDED, begun, settings)
    assert ended.outcome == Outcome.STEP_TOO_SMALL
    assert f"In {ended.statistics.steps} steps the run has come to t = 0.9999" in ended.note
    assert "all that are to come add up to t = 1.0000" in ended.note
    assert "max_steps=" in ended.note
    whole = integrate(CROWDED, begun, replace(settings, max_steps=6_000_000))
    assert whole.outcome == Outcome.OK
    assert "Towards about t = 1.00" in whole.note
    assert whole.statistics.steps > 1.5 * ended.statistics.steps


def test_a_limit_of_a_study_is_no_wish_to_go_on_where_steps_crowd():
    begun, settings = problem(1.1, 10.0, 1.0, 5e-8), Options(method="dopri5", t_eval=[0.0, 1.1])
    free = integrate(CROWDED, begun, settings)
    limited = integrate(CROWDED, begun, replace(settings, step_limit=1_000_000))
    assert (limited.outcome, limited.note) == (free.outcome, free.note) != (Outcome.OK, "")
    few = integrate(CROWDED, begun, replace(settings, step_limit=1000))
    assert (few.outcome, few.note) == (Outcome.MAX_STEPS, "")


def test_a_run_that_uses_up_steps_of_ones_own_says_where_they_crowd():
    settings = Options(method="dopri5", t_eval=[0.0, 1.1], max_steps=1_000_000)
    r = integrate(CROWDED, problem(1.1, 10.0, 1.0, 5e-8), settings)
    assert r.outcome == Outcome.MAX_STEPS
    assert r.note.startswith("Towards about t = ")


def test_turns_that_crowd_before_a_known_kink_are_followed_to_it():
    """A kink ends the crowding, as where a cord that is pulled in is held at last."""
    kink = 1.0 - 2e-5
    stops = Stops(np.array([0.5, kink]), np.array([-1, 0]), np.array([0.5, kink]), passed)
    begun = problem(1.0, 1.0, 1.0)._replace(stops=stops)
    r = integrate(CROWDED, begun, Options(method="dopri5", t_eval=[0.0, 1.0], max_steps=4_000_000))
    assert r.outcome == Outcome.DISCONTINUOUS
    assert r.final_t == kink


def passed(number, q, v, modes):
    return Passage(Outcome.DISCONTINUOUS)
