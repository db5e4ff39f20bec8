"""Elimination of a leading block: factors, Schur complement, left and null vectors, by numpy."""

import numpy as np
import pytest

from tests.runtime.linalg.drivers import both_vectors, complete_solution, eliminate_leading

M, N, R = 6, 8, 4


@pytest.fixture
def problem():
    random = np.random.default_rng(7)
    a = random.normal(size=(M, N)) + 3.0 * np.eye(M, N)
    a[1, 5] = a[5, 0] = a[3, 0] = 0.0
    return a, random.normal(size=M)


def test_what_is_left_is_the_schur_complement(problem):
    a, right = problem
    factors, reduced = a.copy(), right.copy()
    assert eliminate_leading(factors, R, reduced, 1e-13) == 1
    carry = a[R:, :R] @ np.linalg.inv(a[:R, :R])
    np.testing.assert_allclose(factors[R:, R:], a[R:, R:] - carry @ a[:R, R:], rtol=1e-11)
    np.testing.assert_allclose(reduced[R:], right[R:] - carry @ right[:R], rtol=1e-11)
    lower = np.tril(factors[:, :R], -1) + np.eye(M, R)
    upper = np.triu(factors[:R])
    np.testing.assert_allclose((lower @ upper)[:R], a[:R], rtol=1e-11, atol=1e-13)


def test_a_solution_of_the_first_rows_is_completed(problem):
    a, right = problem
    factors, reduced, x = a.copy(), right.copy(), np.arange(1.0, N + 1)
    eliminate_leading(factors, R, reduced, 1e-13)
    complete_solution(factors, R, reduced, x)
    np.testing.assert_allclose(x[R:], np.arange(R + 1.0, N + 1))
    np.testing.assert_allclose(a[:R] @ x, right[:R], rtol=1e-11)


def test_vectors_in_the_order_of_the_matrix_before_it_was_permuted(problem):
    a, right = problem
    random = np.random.default_rng(3)
    row_order, column_order = random.permutation(M), random.permutation(N)
    before = np.zeros_like(a)
    before[np.ix_(row_order, column_order)] = a
    factors, left, null = a.copy(), np.full((M, M - R), 9.0), np.full((N, N - R), 9.0)
    eliminate_leading(factors, R, right, 1e-13)
    both_vectors(factors, R, row_order, column_order, left, null)
    np.testing.assert_allclose(left[row_order[R:]], np.eye(M - R))
    np.testing.assert_allclose(null[column_order[R:]], np.eye(N - R))
    lost = left.T @ before
    np.testing.assert_allclose(lost[:, column_order[:R]], 0.0, atol=1e-13)
    np.testing.assert_allclose(lost[:, column_order[R:]], factors[R:, R:], atol=1e-13)
    np.testing.assert_allclose(before[row_order[:R]] @ null, 0.0, atol=1e-13)


def test_rounding_in_a_vector_is_cut_off():
    """Vectors stay as sparse as they are."""
    a = np.array([[1.0, 1e-16, 1.0], [0.5, 1.0, 1.0]])
    null = np.zeros((3, 2))
    eliminate_leading(a, 1, np.zeros(2), 1e-13)
    both_vectors(a, 1, np.arange(2), np.arange(3), np.zeros((2, 1)), null)
    assert null[0].tolist() == [0.0, -1.0]


@pytest.mark.parametrize("pivot", [0.0, 1e-14, np.nan])
def test_a_pivot_that_vanishes_ends_the_elimination(pivot):
    a = np.array([[1.0, 2.0, 3.0], [1.0, 2.0 + pivot, 1.0]])
    assert eliminate_leading(a, 2, np.zeros(2), 1e-13) == 0
