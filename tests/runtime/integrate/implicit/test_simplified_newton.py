"""The iteration on a sequence of known sizes, the renewal of derivatives, the tolerance."""

import numpy as np
import pytest

from runtime.constraints.newton_return import FAILED
from runtime.core.arrays import f8, i8, integers
from runtime.core.jit import compiled, inner
from runtime.core.workspace_rows import Y0
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.simplified_newton import newton_iteration, step_solver
from tests.runtime.integrate.implicit.drivers import Arrays, set_tolerance
from tests.runtime.integrate.stiff import SMOOTH_PENDULUM
from tests.runtime.integrate.systems import PENDULUM_P

# The toy problem counts in numbers of METHOD_FLOATS that only BDF takes.
SIZE, CALLS = mem.CHANGE, mem.CHANGE + 1


@inner
def evaluate(context, t, c):
    return 2


@inner
def improve(context, c):
    """A change whose size falls by the factor c."""
    floats = context.method_floats
    floats[SIZE] *= c
    return floats[SIZE]


iterate = newton_iteration(evaluate, improve, 5, 0.99)


@inner
def predict(context, c):
    context.method_floats[CALLS] += 1.0
    return 0


@inner
def linearize(context, t):
    context.method_integers[mem.CURRENT] = 1
    context.method_floats[mem.FACTORED_FOR] = 0.0
    return 0


@inner
def factor(context, c):
    return 1 if c < 0.0 else 0


@inner
def solve(context, t, c):
    """It converges once derivatives are fresh, and never at t = 1."""
    return 3 if context.method_floats[CALLS] > 1.0 and t != 1.0 else FAILED


solver = step_solver(predict, linearize, factor, solve)


@compiled(i8(integers, f8))
def run_iteration(context, c):
    return iterate(context, 0.0, c)


@compiled(i8(integers, f8, f8))
def run_step(context, t, c):
    return solver(context, t, c)


@pytest.fixture
def arrays():
    found = Arrays(SMOOTH_PENDULUM, PENDULUM_P)
    found.numbers[SIZE] = found.numbers[mem.RATE] = 1.0
    found.numbers[mem.ENOUGH], found.notes[mem.CURRENT] = 1e-3, 1
    return found


def test_iterations_until_the_rest_is_small(arrays):
    # Rates 0.01 / 0.99: after the second change of 1e-4 the rest is about 1e-6.
    assert run_iteration(arrays.table, 0.01) == 2 * 2
    assert arrays.notes[mem.ITERATIONS] == arrays.record["iterations"] == 2
    assert arrays.numbers[mem.RATE] == pytest.approx(0.01 / 0.99)
    assert arrays.notes[mem.CURRENT] == 1


def test_slow_convergence_asks_for_derivatives(arrays):
    assert run_iteration(arrays.table, 0.1) != FAILED
    assert arrays.notes[mem.CURRENT] == 0


@pytest.mark.parametrize(("factor", "iterations"), [(0.9, 2), (1.5, 2), (np.nan, 1)])
def test_divergence_is_seen_early(arrays, factor, iterations):
    # At 0.9 the five iterations would not do.
    assert run_iteration(arrays.table, factor) == FAILED
    assert arrays.record["iterations"] == iterations


def test_old_derivatives_are_renewed_once(arrays):
    assert run_step(arrays.table, 0.0, 0.5) == 3
    assert arrays.numbers[CALLS] == 2
    assert arrays.notes[mem.CURRENT] == 1
    assert arrays.record["factorizations"] == 2


def test_fresh_derivatives_are_not_renewed(arrays):
    arrays.notes[mem.CURRENT] = 0
    assert run_step(arrays.table, 1.0, 0.5) == FAILED
    assert arrays.numbers[CALLS] == 1
    assert arrays.notes[mem.CURRENT] == 0


def test_a_singular_matrix_ends_the_step(arrays):
    assert run_step(arrays.table, 0.0, -1.0) == FAILED
    assert arrays.notes[mem.CURRENT] == 0


def test_tolerance_is_that_of_the_user_down_to_rounding(arrays):
    arrays.set_derivatives(np.zeros((3, 3)), np.zeros((3, 3)))
    state = np.array([1.0, 10.0, 0.0, 0.0, 0.0, 0.0])
    arrays.workspace[Y0] = state
    set_tolerance(arrays.table, 0.1, state)
    expected = 0.1 * (1e-6 + 1e-6 * state)
    np.testing.assert_allclose(arrays.rows[mem.TOLERANCE], expected, rtol=1e-12)
    assert arrays.numbers[mem.ENOUGH] == pytest.approx(1e-3 / 0.1)
    set_tolerance(arrays.table, 1e-12, 2.0 * state)  # moved by 10: 64 units of rounding of that
    assert np.all(arrays.rows[mem.TOLERANCE] > 64 * 2.0**-52 * 10.0)
    assert arrays.numbers[mem.ENOUGH] == pytest.approx(4.0 / 64.0, rel=1e-3)
