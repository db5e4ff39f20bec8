"""LU factors with row pivoting, against numpy, on singular matrices, and on badly scaled rows."""

import numpy as np
import pytest

from tests.runtime.linalg.drivers import solve_by_factors, solve_equilibrated


@pytest.mark.parametrize("f", [1, 2, 3, 7, 20])
def test_solution(f):
    random = np.random.default_rng(f)
    a, b = random.standard_normal((f, f)), random.standard_normal(f)
    a[0, 0] = 0.0 if f > 1 else a[0, 0]  # rows have to be exchanged
    x = b.copy()
    assert solve_by_factors(a.ravel().copy(), f, x) == 0
    np.testing.assert_allclose(x, np.linalg.solve(a, b), rtol=1e-10)
    x = b.copy()
    assert solve_equilibrated(a.ravel().copy(), x, f, 1e-11) == 0
    np.testing.assert_allclose(x, np.linalg.solve(a, b), rtol=1e-10)


def test_the_largest_entry_of_a_column_is_the_pivot():
    """Without it, growth by 1e20 would leave nothing of the solution."""
    a, x = np.array([[1e-20, 1.0], [1.0, 1.0]]), np.array([1.0, 2.0])
    assert solve_by_factors(a.ravel().copy(), 2, x) == 0
    np.testing.assert_allclose(x, [1.0, 1.0], rtol=1e-15)


@pytest.mark.parametrize("a", [[[0.0]], [[1.0, 2.0], [2.0, 4.0]], [[np.nan]]])
def test_a_singular_matrix_is_refused(a):
    a = np.array(a)
    assert solve_by_factors(a.ravel().copy(), len(a), np.ones(len(a))) == 1
    assert solve_equilibrated(a.ravel().copy(), np.ones(len(a)), len(a), 0.0) == 1


@pytest.mark.parametrize("distance", [1e-9, 1e-13])
def test_rows_are_compared_in_units_of_their_largest_entries(distance):
    """Rows in N and in kN: a row is refused by its distance from the others, not by its unit."""
    a = np.array([[1.0, 2.0], [1.0, 2.0 + 4.0 * distance]]) * [[1e-12], [1e9]]
    x = a @ [3.0, -1.0]
    assert solve_equilibrated(a.ravel().copy(), x, 2, 1e-11) == (distance < 1e-11)
    if distance > 1e-11:
        np.testing.assert_allclose(x, [3.0, -1.0], rtol=1e-5)
