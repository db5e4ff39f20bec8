"""Newton's method by steps of least norm: its order, its least step, and where it stops."""

from itertools import pairwise

import numpy as np
import pytest

from runtime.linalg.least_norm import solve_by_newton


def test_convergence_is_quadratic():
    """√2 from 1.5: each error is about the last one's square over 2 √2."""
    seen = []

    def residual(x):
        seen.append(abs(x[0] - np.sqrt(2.0)))
        return x * x - 2.0

    x, largest = solve_by_newton(residual, lambda x: np.diag(2.0 * x), np.array([1.5]))
    assert x[0] == pytest.approx(np.sqrt(2.0), abs=4e-16)
    assert largest <= 4.5e-16
    errors = sorted(set(seen), reverse=True)[:3]
    for before, after in pairwise(errors):
        assert after == pytest.approx(before**2 / (2.0 * np.sqrt(2.0)), rel=0.1)


def test_the_nearest_point_of_a_line_is_found():
    """Fewer equations than unknowns: one step of least norm."""
    normal = np.array([[3.0, 4.0]])
    x, largest = solve_by_newton(lambda x: normal @ x - 5.0, lambda x: normal, np.zeros(2))
    np.testing.assert_allclose(x, [0.6, 0.8], rtol=1e-14)
    assert largest < 1e-15


def test_equations_that_say_the_same_are_borne():
    twice = np.array([[1.0, 1.0], [2.0, 2.0]])
    x, largest = solve_by_newton(
        lambda x: twice @ x - [1.0, 2.0], lambda x: twice, np.array([3.0, 0.0])
    )
    np.testing.assert_allclose(x, [2.0, -1.0], atol=1e-14)
    assert largest < 1e-15


def test_the_best_point_is_returned_where_there_is_no_root():
    calls = []

    def residual(x):
        calls.append(1)
        return x * x + 1.0

    x, largest = solve_by_newton(residual, lambda x: np.diag(2.0 * x), np.array([0.6]))
    assert largest == pytest.approx(1.0 + x[0] ** 2)
    assert largest <= 1.36
    assert len(calls) < 10


def test_nothing_to_solve():
    x, largest = solve_by_newton(lambda x: np.zeros(0), lambda x: np.zeros((0, 2)), np.ones(2))
    assert largest == 0.0
    np.testing.assert_array_equal(x, [1.0, 1.0])
