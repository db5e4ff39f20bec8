"""Equations of motion with redundant constraints, against the pseudo-inverse."""

import numpy as np
import pytest

from runtime.linalg.dense_elimination import Sparse
from runtime.linalg.redundant_constraints_solve import (
    minimise_norm,
    solve_factored,
    solve_least_norm,
    solve_motion,
)
from tests.runtime.linalg.test_full_pivoting import factored


def sparse(matrix):
    rows, columns = (np.ascontiguousarray(places) for places in np.nonzero(matrix))
    rows.flags.writeable = columns.flags.writeable = False
    return Sparse(rows, columns, np.ascontiguousarray(matrix[rows, columns]))


def redundant(seed, m=5, n=8, rank=3):
    """A Jacobian whose last rows follow from the first; some also of another length."""
    random = np.random.default_rng(seed)
    jacobian = random.normal(size=(m, n))
    jacobian[rank:] = random.normal(size=(m - rank, rank)) @ jacobian[:rank]
    return jacobian * np.array([1.0, 1e3, 1e-3, 1.0, 10.0])[:m, None], random


@pytest.mark.parametrize("seed", range(4))
def test_the_solution_of_least_norm(seed):
    jacobian, random = redundant(seed)
    w = random.uniform(0.1, 10.0, 8)
    w[3] = 0.0  # a coordinate that is held
    right = jacobian @ np.where(w > 0.0, random.normal(size=8), 0.0)
    d, both = np.full((2, 8), 9.0), np.stack([right, -2.0 * right])
    assert solve_least_norm(sparse(jacobian), w, both, d) == 3
    root = np.sqrt(w)
    expected = root * (np.linalg.pinv(jacobian * root, rcond=1e-8) @ right)
    np.testing.assert_allclose(d, [expected, -2.0 * expected], rtol=1e-8, atol=1e-11)


@pytest.mark.parametrize("seed", range(4))
def test_accelerations_and_multipliers_of_least_norm(seed):
    jacobian, random = redundant(seed)
    root = random.normal(size=(8, 8))
    mass = root @ root.T + np.diag(10.0 ** np.arange(-2.0, 6.0))
    force, gamma = random.normal(size=8), jacobian @ random.normal(size=8)
    a, lam = np.zeros(8), np.zeros(5)
    found = solve_motion(sparse(jacobian), sparse(mass), force, gamma, a, lam)
    assert found == 2
    free = np.linalg.solve(mass, force)
    inverse = np.linalg.solve(mass, jacobian.T)
    expected = np.linalg.lstsq(jacobian @ inverse, jacobian @ free - gamma, rcond=1e-11)[0]
    np.testing.assert_allclose(jacobian @ a, gamma, rtol=1e-7, atol=1e-8)
    np.testing.assert_allclose(mass @ a + jacobian.T @ lam, force, atol=1e-7)
    null = np.linalg.svd(jacobian / np.linalg.norm(jacobian, axis=1)[:, None])[0][:, 3:]
    null = null / np.linalg.norm(jacobian, axis=1)[:, None]
    np.testing.assert_allclose(null.T @ lam / np.linalg.norm(null), 0.0, atol=1e-6 * abs(lam).max())
    assert np.linalg.norm(lam) == pytest.approx(np.linalg.norm(expected), rel=1e-4)


def test_masses_that_determine_no_acceleration():
    """A point without mass that one rod holds: what it does across the rod is not determined."""
    a, lam = np.zeros(2), np.zeros(1)
    jacobian = np.array([[1.0, 0.0]])
    none = np.zeros((2, 2))
    for mass, lost in ((np.eye(2), 0), (none, 1 + 3)):
        found = solve_motion(sparse(jacobian), sparse(mass), np.ones(2), np.zeros(1), a, lam)
        assert found == lost


def test_a_factored_system_gives_unknowns_without_pivot_no_value():
    matrix = np.array([[0.0, 2.0, 0.0], [4.0, 8.0, 0.0], [0.0, 0.0, 0.0]])
    rank, a, row_order, column_order = factored(matrix, 1e-10)
    x = np.full(3, 9.0)
    solve_factored(a, rank, row_order, column_order, np.array([2.0, 4.0, 0.0]), x)
    np.testing.assert_allclose(x, [-1.0, 1.0, 0.0], atol=1e-15)


def test_the_norm_is_least_when_nothing_of_the_free_part_is_left():
    random = np.random.default_rng(6)
    free, lam = random.normal(size=(5, 2)), random.normal(size=5)
    least = lam.copy()
    minimise_norm(free, least)
    np.testing.assert_allclose(free.T @ least, 0.0, atol=1e-14)
    np.testing.assert_allclose(np.linalg.lstsq(free, lam - least)[1], 0.0, atol=1e-26)
