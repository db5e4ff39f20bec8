"""Steps across a singular position: errors, nodes that keep away from it, their beginnings."""

import numpy as np
import pytest

from runtime.integrate.method import find_method
from runtime.integrate.problem import Options
from runtime.integrate.run_state import RunState
from runtime.integrate.singular_crossing.crossing_step_planning import (
    CrossingSteps,
    extrapolate_accelerations,
)
from runtime.singularity.motion_polynomial import taylor
from runtime.singularity.singular_position_near_motion import Singularity
from tests.runtime.integrate.systems import PENDULUM, pendulum_problem

METHOD = find_method("dop853")
SCALE = np.ones(3)


def position(rate=1.0, speed=1.0, miss=0.0):
    flat = np.zeros(2)
    return Singularity(1.0, np.ones(2), np.ones(1), 1, flat, 0.0, rate, flat, 0.0, speed, miss, 1.0)


def steps(rtol=1e-8, method=METHOD):
    return CrossingSteps(np.ones(2), rtol, method)


@pytest.mark.parametrize("name", ["dop853", "dopri5", "tsit5"])
def test_the_instant_falls_into_the_middle_of_a_gap_between_nodes(name):
    method = find_method(name)
    best = steps(method=method).best(position(), 0.01)
    nodes = np.unique(method.nodes)
    k = np.searchsorted(nodes, best.lead / best.h)
    assert best.lead / best.h == pytest.approx(0.5 * (nodes[k - 1] + nodes[k]))
    assert best.h >= 0.01
    distance = 0.5 * (nodes[k] - nodes[k - 1]) * best.h
    noise = steps(method=method).noise(position())
    assert best.rounding == pytest.approx(noise * best.h / distance**3)


def test_where_rounding_rules_the_step_is_longer():
    short, long = (steps(rtol=rtol).best(position(), 1e-4) for rtol in (1e-3, 1e-13))
    assert long.h > short.h >= 1e-4
    # At the length of least error the derivative of the method's is that of rounding: p m = 2 r.
    assert METHOD.estimate_order * long.method == pytest.approx(2.0 * long.rounding, rel=1e-9)


def test_a_step_from_here_begins_here():
    across = steps()
    best = across.best(position(), 0.01)
    from_there = across.best(position(), 0.01, best.lead)
    assert from_there.lead == best.lead
    assert from_there.total <= 2.0 * best.total
    assert across.best(position(), 0.01, -1e-6).lead == -1e-6


def test_an_uncertain_instant_makes_an_error():
    sure, unsure = (steps().best(position(miss=miss), 0.01).total for miss in (0.0, 1e-2))
    assert unsure > sure


def test_noise_and_reach():
    assert steps(1e-10).noise(position()) == pytest.approx(100.0 * steps(1e-8).noise(position()))
    assert steps().noise(position(rate=4.0)) == pytest.approx(0.25 * steps().noise(position()))
    assert steps().reach(position(rate=4.0)) == pytest.approx(0.25 * steps().reach(position()))
    assert steps().rounding(np.array([3.0, -8.0])) == pytest.approx(
        8.0 * steps().rounding(np.ones(2))
    )


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
