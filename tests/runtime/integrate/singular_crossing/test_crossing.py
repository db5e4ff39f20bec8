"""The loan of another method near a singular position, and its end."""

import numpy as np
import pytest

from runtime.core.workspace_rows import K
from runtime.integrate.problem import Options
from runtime.integrate.run_state import RunState
from runtime.integrate.singular_crossing.crossing import Crossings
from runtime.integrate.singular_crossing.crossing_step_planning import CrossingSteps, MethodHandover
from runtime.integrate.step import Signal
from tests.runtime.integrate.singular_crossing.test_crossing_step_planning import position
from tests.runtime.integrate.stiff import SMOOTH_PENDULUM
from tests.runtime.integrate.systems import pendulum_problem


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
