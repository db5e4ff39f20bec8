"""The real and the complex matrix against NumPy, and an error seen through the real one."""

import numpy as np
import pytest

from runtime.integrate.implicit import method_memory as mem
from tests.runtime.integrate.implicit.drivers import (
    Arrays,
    filtered_error,
    solve_complex,
    solve_real,
)
from tests.runtime.integrate.stiff import SMOOTH_PENDULUM
from tests.runtime.integrate.systems import PENDULUM_P

A, B = np.random.default_rng(5).normal(size=(2, 3, 3))


@pytest.fixture
def arrays():
    found = Arrays(SMOOTH_PENDULUM, PENDULUM_P)
    found.set_derivatives(A, B)
    return found


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
