"""Full pivoting of sparse matrices, against numpy: factors, rank, and the choice among equals."""

import numpy as np
import pytest

from runtime.linalg.dense_elimination import factor_fully


def factored(dense, least):
    a, row_order = dense.copy(), np.zeros(len(dense), np.int64)
    column_order = np.zeros(dense.shape[1], np.int64)
    rank = factor_fully(a, row_order, column_order, least)
    return rank, a, row_order, column_order


@pytest.mark.parametrize("seed", range(5))
def test_the_factors_of_a_sparse_matrix(seed):
    """P A Q = L U with pivots that nothing left is larger than; equal entries go by their place."""
    random = np.random.default_rng(seed)
    dense = np.where(random.random((9, 11)) < 0.3, random.integers(-2, 3, (9, 11)), 0).astype(float)
    dense[4] = dense[2] - dense[7]
    rank, a, row_order, column_order = factored(dense, 1e-10)
    assert rank == np.linalg.matrix_rank(dense)
    lower = np.tril(a[:, :rank], -1) + np.eye(9, rank)
    upper = np.triu(a[:rank])
    np.testing.assert_allclose(lower @ upper, dense[row_order][:, column_order], atol=1e-12)
    assert np.abs(lower).max() <= 1.0 + 1e-8
    assert np.all(np.abs(np.diag(upper)) * (1.0 + 1e-8) >= np.abs(upper).max(axis=1))
    largest = np.abs(dense).max()
    first = np.argwhere(np.abs(dense) == largest)[0]
    assert (row_order[0], column_order[0]) == tuple(first)


def test_elimination_stops_at_the_smallest_pivot_allowed():
    dense = np.diag([1.0, 0.5, 0.25, 0.0])
    for least, rank in ((0.3, 2), (0.5, 1), (0.0, 3), (2.0, 0)):
        found, _, row_order, column_order = factored(dense, least)
        assert found == rank
        assert sorted(row_order) == sorted(column_order) == [0, 1, 2, 3]


def test_rounding_does_not_decide_between_equal_entries():
    dense = np.array([[1.0, 1.0 + 1e-15], [1.0 + 2e-15, 1.0 - 1.0 / 3.0]])
    _, _, row_order, column_order = factored(dense, 1e-10)
    assert (row_order[0], column_order[0]) == (0, 0)
