"""The first step as Hairer, Nørsett and Wanner choose it, and the ratios of the controller."""

import numpy as np
import pytest

from runtime.core.loop_record import Plan
from runtime.core.workspace_rows import K
from runtime.integrate.step_control import first_step
from tests.runtime.integrate.drivers import propose, started
from tests.runtime.integrate.systems import relay, relay_problem


def oscillator(q, v, **options):
    system, p = relay(stiffness=4.0)
    return started(system, relay_problem(p, q, v), **options)


@pytest.mark.parametrize("order", [2, 5, 8])
def test_first_step_balances_the_error_of_its_order(order):
    run, tolerance = oscillator(1.0, 0.5, rtol=1e-6), 1e-6
    size = tolerance * (1.0 + np.array([1.0, 0.5]))
    start, rate = np.array([1.0, 0.5]), np.array([0.5, -4.0])
    h = 0.01 * np.linalg.norm(start / size) / np.linalg.norm(rate / size)
    ahead = start + h * rate
    change = np.array([ahead[1], -4.0 * ahead[0]]) - rate
    steepest = max(np.sqrt(np.mean((x / size) ** 2)) for x in (rate, change / h))
    due = min(100.0 * h, (0.01 / steepest) ** (1.0 / order))
    np.testing.assert_array_equal(run.state.rows[K].ravel(), rate)
    assert first_step(run.state.table, 0.0, 10.0, 1e-6, order) == pytest.approx(due, rel=1e-12)


def test_first_step_is_no_longer_than_permitted():
    assert first_step(oscillator(1.0, 0.0).state.table, 0.0, 1e-9, 1e-6, 8) <= 1e-7


def controlled(error, **record):
    run = oscillator(1.0, 0.0, method="dop853")
    for name, value in {"error": error, "error_old": 1e-4, **record}.items():
        run.state.record[name] = value
    return run, propose(run.state.table, 0.1)


def test_the_ratio_keeps_between_its_bounds():
    run, ratio = controlled(0.0)
    assert ratio == run.state.record["grow"] > 1.0
    run, ratio = controlled(1e20)
    assert ratio == run.state.record["shrink"] < 1.0


def test_the_ratio_has_a_proportional_and_an_integral_part():
    run, ratio = controlled(0.5, error_old=0.2)
    beta, safety = run.state.record["beta"], run.state.record["safety"]
    assert ratio == pytest.approx(safety * 0.5 ** (0.75 * beta - 1.0 / 8.0) * 0.2**beta, rel=1e-12)


def test_after_a_rejected_step_none_is_longer():
    assert controlled(1e-6)[1] > 1.0
    assert controlled(1e-6, rejected_before=1)[1] == 1.0


def test_an_error_that_passes_through_zero_is_not_believed():
    run, _ = controlled(1e-15, remembered=0.8, length_old=0.1)
    assert run.state.record["error"] == pytest.approx(0.08)
    run, _ = controlled(1e-15, remembered=0.8, length_old=0.1, plan=Plan.CROSSING)
    assert run.state.record["error"] == 1e-15
    assert run.state.record["remembered"] == 0.0
