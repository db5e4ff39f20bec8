"""Steps across a singular position: errors, nodes, beginnings, and the loan of another method."""

import numpy as np
import pytest

from runtime.core.loop_record import Plan
from runtime.core.workspace_rows import K
from runtime.integrate.crossing_step_planning import (
    CrossingSteps,
    MethodHandover,
    extrapolate_accelerations,
)
from runtime.integrate.method import find_method
from runtime.integrate.problem import Options
from runtime.integrate.run_state import RunState
from runtime.integrate.singular_crossings import Crossings
from runtime.integrate.step import Signal
from runtime.singularity.motion_polynomial import taylor
from runtime.singularity.singular_position_near_motion import Singularity
from tests.runtime.integrate.stiff import SMOOTH_PENDULUM
from tests.runtime.integrate.systems import PENDULUM, pendulum_problem


def run_with(method):
    problem = pendulum_problem(0.3, 2.0, 10.0)
    state = RunState(SMOOTH_PENDULUM, problem, Options(method=method))
    state.rows[K] = state.y[1], np.zeros(3)
    state.record["h"] = 0.25
    return state, CrossingSteps(np.ones(3), 1e-8, state.method), problem


@pytest.mark.parametrize("method", ["radau5", "bdf"])
def test_an_implicit_method_is_replaced_and_comes_back(method):
    state, steps, _ = run_with(method)
    handover, r = MethodHandover(state), state.record
    assert handover.begin(steps, position(), 1e-6, 0.01)
    assert r["lent"] == 1
    assert r["estimate_order"] == 8
    assert r["h"] == pytest.approx(0.2e-6)  # a fifth of the way
    assert r["lent_until"] == 1.25  # at least a usual step behind the position
    assert not handover.begin(steps, position(), 1.0, 0.01)  # lent already
    handover.end()
    assert (r["lent"], r["h"]) == (0, 0.25)
    assert r["estimate_order"] == state.method.estimate_order
    assert state.methods == [(0.0, method)]


@pytest.mark.parametrize("method", ["dop853", "auto"])
def test_the_method_that_leads_across_needs_none(method):
    state, steps, _ = run_with(method)
    assert not MethodHandover(state).begin(steps, position(), 1.0, 0.01)
    assert state.record["lent"] == 0


def test_no_way_is_left_to_learn_on():
    state, steps, _ = run_with("bdf")
    assert not MethodHandover(state).begin(steps, position(), 0.0, 0.01)
    assert state.record["lent"] == 1
    assert state.record["h"] >= 0.25


def test_a_loan_ends_where_the_position_is_behind():
    state, steps, problem = run_with("bdf")
    crossings = Crossings(state, problem)
    crossings.handover.begin(steps, position(), 1.0, 0.01)
    state.record["t"] = 3.0
    assert crossings.decide() == Signal.GOING
    assert state.record["lent"] == 0


def test_without_a_kernel_of_the_constraints_nothing_is_looked_for():
    state, _, problem = run_with("dop853")
    crossings = Crossings(state, problem)
    assert state.record["quiet"] == np.inf
    assert not crossings.prepare_start()


def test_a_step_that_is_refused_behind_a_position_passes_nothing():
    state, _, problem = run_with("dop853")
    crossings, r = Crossings(state, problem), state.record
    crossings.position, r["t"] = position()._replace(due=np.nan), 1.5
    crossings.before = crossings._start_state()
    r["plan"], r["error"], r["length_across"] = Plan.CROSSING, 1e6, 0.25
    assert crossings.decide() == Signal.GOING
    assert crossings.passed == []
    assert (r["plan"], r["quiet"]) == (Plan.LEAVING, 1.75)


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
