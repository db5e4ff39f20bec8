"""Multipliers of redundant constraints, against the pseudo-inverse."""

import numpy as np
import pytest

from runtime.linalg.dense_elimination import Sparse
from runtime.linalg.least_multipliers import take_least_multipliers
from tests.runtime.linalg import drivers


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
def test_multipliers_of_least_norm_exert_the_same_forces(seed):
    jacobian, random = redundant(seed)
    given = random.normal(size=5) / np.linalg.norm(jacobian, axis=1)
    rows, columns = map(np.ascontiguousarray, np.nonzero(jacobian))
    lam = given.copy()
    take_least_multipliers(rows, columns, jacobian[rows, columns], 8, 2, lam)
    scale = np.abs(jacobian.T @ given).max()
    np.testing.assert_allclose(jacobian.T @ lam, jacobian.T @ given, atol=1e-12 * scale)
    least = np.linalg.pinv(jacobian.T, rcond=1e-10) @ (jacobian.T @ given)
    np.testing.assert_allclose(lam, least, rtol=1e-8, atol=1e-9 * np.abs(least).max())


def test_rows_that_barely_look_independent_count_as_redundant():
    """Off the constraints by 1e-7: the number of redundant rows decides, and not their rounding."""
    jacobian, random = redundant(1)
    near = jacobian * (1.0 + 1e-7 * random.normal(size=jacobian.shape))
    rows, columns = map(np.ascontiguousarray, np.nonzero(near))
    lam, exact = (np.array([1.0, 1e-3, 1e3, 1.0, 0.1]) for _ in range(2))
    take_least_multipliers(rows, columns, near[rows, columns], 8, 2, lam)
    take_least_multipliers(rows, columns, jacobian[rows, columns], 8, 2, exact)
    np.testing.assert_allclose(lam, exact, rtol=1e-4, atol=1e-4)


def test_the_norm_is_least_when_nothing_of_the_free_part_is_left():
    """Of three vectors, one of which follows from the others."""
    random = np.random.default_rng(6)
    free, lam = random.normal(size=(3, 5)), random.normal(size=5)
    free[1] = 1e-9 * free[0] - 2.0 * free[2]
    least = lam.copy()
    drivers.minimise_norm(free.ravel().copy(), 2, least)
    np.testing.assert_allclose(free @ least, 0.0, atol=1e-14)
    np.testing.assert_allclose(np.linalg.lstsq(free[::2].T, lam - least)[1], 0.0, atol=1e-26)
