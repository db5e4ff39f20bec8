"""The iteration on known sizes, renewal of derivatives, tolerance, matrices against NumPy's."""

import numpy as np
import pytest

from runtime.constraints.newton_return import FAILED
from runtime.core.arrays import f8, i8, integers
from runtime.core.jit import compiled, inner
from runtime.core.workspace_rows import Y0
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.simplified_newton import newton_iteration, step_solver
from tests.runtime.integrate.implicit.drivers import (
    Arrays,
    filtered_error,
    set_tolerance,
    solve_complex,
    solve_real,
)
from tests.runtime.integrate.stiff import SMOOTH_PENDULUM
from tests.runtime.integrate.systems import PENDULUM_P

# The toy problem counts in numbers of METHOD_FLOATS that only BDF takes.
SIZE, CALLS = mem.CHANGE, mem.CHANGE + 1
A, B = np.random.default_rng(5).normal(size=(2, 3, 3))


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
    found.set_derivatives(A, B)
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


def test_real_matrix(arrays):
    c, x = 0.7, np.array([1.0, -2.0, 0.5])
    expected = np.linalg.solve(np.eye(3) - c * B - c * c * A, x)
    assert solve_real(arrays.table, c, x) == 0
    np.testing.assert_allclose(x, expected, rtol=1e-12)


def test_complex_matrix(arrays):
    z, right = 0.4 - 0.9j, np.array([1.0 + 1.0j, -2.0j, 0.5])
    expected = np.linalg.solve(np.eye(3) - z * B - z * z * A, right)
    x = np.concatenate([right.real, right.imag])
    assert solve_complex(arrays.table, z.real, z.imag, x) == 0
    np.testing.assert_allclose(x[:3] + 1j * x[3:], expected, rtol=1e-12)


def test_a_singular_matrix_is_reported(arrays):
    arrays.set_derivatives(np.eye(3), np.zeros((3, 3)))
    assert solve_real(arrays.table, 1.0, np.ones(3)) == 1


def test_filtered_error(arrays):
    c, allowed = 0.7, 10.0 ** -np.arange(1.0, 7.0)
    x, y = np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.1, -1.0])
    arrays.rows[mem.SLOPE], arrays.rows[mem.TOLERANCE] = np.concatenate([y, x]), allowed
    J = np.block([[np.zeros((3, 3)), np.eye(3)], [A, B]])
    expected = np.linalg.solve(np.eye(6) - c * J, np.concatenate([x, y]))
    size = filtered_error(arrays.table, c, 1e9 * np.ones(3))
    np.testing.assert_allclose(arrays.rows[mem.IN], expected, rtol=1e-11)
    assert size == pytest.approx(np.sqrt(np.mean((expected / allowed) ** 2)))


def test_dependent_coordinates_have_the_error_that_was_estimated(arrays):
    allowed, raw = 10.0 ** -np.arange(1.0, 7.0), np.array([1.0, 2.0, 1e9])
    arrays.rows[mem.TOLERANCE], arrays.notes[mem.PARTITIONED] = allowed, 1
    arrays.set_independent(2)
    size = filtered_error(arrays.table, 0.7, raw)
    assert size == pytest.approx(np.sqrt(np.sum((raw[:2] / allowed[:2]) ** 2) / 6.0))
