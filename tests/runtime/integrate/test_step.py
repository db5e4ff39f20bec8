"""One trial step of a pendulum: its codes, and its return onto the constraints."""

import numpy as np
import pytest

from runtime.core.workspace_rows import PREDICTED, Y0, Y1, K
from runtime.integrate.step import TrialStep
from tests.runtime.integrate.drivers import swinging, tried
from tests.runtime.integrate.systems import PENDULUM


def residual(y):
    (x, height, phi), (vx, vy, omega) = y
    c, s = np.cos(phi), np.sin(phi)
    return np.abs([x - c, height - s, vx + s * omega, vy - c * omega]).max()


@pytest.mark.parametrize("correction", ["step", "projection"])
def test_a_step_ends_on_the_constraints(correction):
    run = swinging(PENDULUM, correction=correction, method="dopri5", rtol=1e-4)
    rows, record = run.state.rows, run.state.record
    assert tried(run, 0.05) == TrialStep.DONE
    assert residual(rows[PREDICTED]) > 1e-9
    assert residual(rows[Y1]) < 1e-15
    moved = np.abs(rows[Y1, 0] - rows[PREDICTED, 0]).max()
    assert record["largest_dq"] == pytest.approx(moved)
    assert record["corrections"] >= 2


def test_without_a_return_it_stays_where_the_method_led():
    run = swinging(PENDULUM, correction="baumgarte", method="dopri5", rtol=1e-4)
    assert tried(run, 0.005) == TrialStep.DONE
    assert residual(run.state.rows[Y1]) > 1e-14
    assert run.state.record["returns"] == 1  # that of the start


def test_the_derivative_at_its_end_is_that_of_its_state():
    run = swinging(PENDULUM, method="dop853")
    tried(run, 0.01)
    rows, last = run.state.rows, int(run.state.record["last"])
    assert np.array_equal(rows[K + last, 0], rows[Y1, 1])
    assert rows[K + last, 1, 2] == pytest.approx(-9.81 * np.cos(rows[Y1, 0, 2]), rel=1e-12)


def test_a_long_step_is_too_large_unless_its_length_is_fixed():
    assert tried(swinging(PENDULUM, rtol=1e-12), 0.3) == TrialStep.TOO_LARGE
    assert tried(swinging(PENDULUM, rtol=1e-12, fixed_step=0.3), 0.3) == TrialStep.DONE


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_state_that_is_not_finite_ends_it(value):
    run = swinging(PENDULUM)
    run.state.rows[Y0, 1, 2] = value
    assert tried(run, 0.01) == TrialStep.NOT_FINITE
