"""The first instant: what stands in the rows from which the first step begins."""

import numpy as np
import pytest

from runtime import load
from runtime.core.outcomes import Outcome
from runtime.core.workspace_rows import PARTITION, K
from runtime.integrate.problem import Options, Problem
from runtime.integrate.run import Run
from tests.runtime.integrate.systems import PENDULUM, pendulum_problem


def test_a_state_near_the_constraints_is_returned_onto_them():
    problem = pendulum_problem(-1.0, 2.0, 1.0)
    problem.q[0] += 1e-7
    problem.q[1] -= 1e-7
    run = Run(PENDULUM, problem, Options())
    assert run.start() == Outcome.OK
    q, v = run.state.y
    assert np.hypot(q[0], q[1]) == pytest.approx(1.0, abs=1e-15)
    assert np.count_nonzero(run.state.rows[PARTITION, 0] == 0.0) == 1
    np.testing.assert_array_equal(run.state.rows[K, 0], v)
    assert run.state.rows[K, 1, 2] == pytest.approx(-9.81 * np.cos(q[2]), rel=1e-12)


def test_the_derivative_follows_the_impacts_of_the_first_instant():
    machine = load("hard/bouncing_ball", "dropped")
    names = [q.name for q in machine.description.coordinates]
    q, v = np.zeros(len(names)), np.zeros(len(names))
    q[names.index("ball.y")], v[names.index("ball.y")] = 0.1, -2.0
    problem = Problem(0.0, 1.0, q, v, machine.parameter_values(), np.ones(len(names)))
    run = Run(machine.mechanism.system, problem, Options())
    assert run.start() == Outcome.OK
    assert run.state.y[1].max() == pytest.approx(1.0)  # half of the speed, upwards
    np.testing.assert_array_equal(run.state.rows[K, 0], run.state.y[1])
