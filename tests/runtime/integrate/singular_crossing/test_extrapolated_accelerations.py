"""Accelerations by continuity, where the equations could be asked as well."""

import numpy as np
import pytest

from runtime.integrate.problem import Options
from runtime.integrate.run_state import RunState
from runtime.integrate.singular_crossing.extrapolated_accelerations import extrapolate_accelerations
from runtime.singularity.motion_polynomial import taylor
from tests.runtime.integrate.systems import PENDULUM, pendulum_problem

SCALE = np.ones(3)


def pendulum(phi=-0.8, omega=3.0):
    state = RunState(PENDULUM, pendulum_problem(phi, omega, 1.0), Options())
    q, v = state.y
    exact, lam = np.zeros(3), np.zeros(2)
    PENDULUM.accelerations(0.0, q, v, state.p, state.modes, exact, lam)
    return state, taylor(0.0, q, v, np.zeros(3)), exact


@pytest.mark.parametrize("instant", [0.0, 1e-3, -1e-3])
def test_accelerations_of_a_regular_motion(instant):
    state, motion, exact = pendulum()
    found = extrapolate_accelerations(state, SCALE, motion, instant, 4e-3)
    # The fourth derivative is left out: 6 δ² of it, over the next ones.
    np.testing.assert_allclose(found, exact, atol=2e-4 * np.abs(exact).max())


def test_none_where_the_constraints_cannot_be_met():
    state, motion, _ = pendulum()
    motion.series[0, :] = np.nan
    assert extrapolate_accelerations(state, SCALE, motion, 0.0, 4e-3) is None
