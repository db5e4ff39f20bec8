"""Sparse elimination against dense matrices: orders of pivots, complements, null vectors."""

import numpy as np
import pytest
from numba import njit

from runtime.linalg.sparse_elimination import (
    by_rows,
    complete_sparsely,
    eliminate_in_order,
    order_sparsely,
)


@njit
def order(rows, columns, values, m, n, least):  # type: ignore[no-untyped-def]
    row_order, column_order = np.empty(m, np.int64), np.empty(n, np.int64)
    matrix = by_rows(rows, columns, values, m)
    rank = order_sparsely(matrix, n, least, row_order, column_order)
    return rank, row_order, column_order


@njit
def eliminate(rows, columns, values, m, n, strong, right):  # type: ignore[no-untyped-def]
    upper = eliminate_in_order(by_rows(rows, columns, values, m), n, strong, right, 0.0)
    return upper, complete_sparsely(upper, n, strong)


def dense(matrix: tuple[np.ndarray, ...], m: int, n: int) -> np.ndarray:
    starts, columns, values = matrix
    whole = np.zeros((m, n))
    for i in range(m):
        for e in range(starts[i], starts[i + 1]):
            whole[i, columns[e]] += values[e]
    return whole


def drawn(seed: int, m: int, n: int) -> np.ndarray:
    """A matrix with four entries a row, of largest entry 1."""
    random, matrix = np.random.default_rng(seed), np.zeros((m, n))
    for i in range(m):
        matrix[i, random.choice(n, 4, replace=False)] = random.uniform(-1.0, 1.0, 4)
    matrix /= np.abs(matrix).max(axis=1)[:, None]
    return matrix


def entries(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rows, columns = np.nonzero(matrix)
    return rows, columns, matrix[rows, columns]


@pytest.mark.parametrize("seed", range(6))
def test_order_finds_rank_and_dependent_rows(seed: int) -> None:
    matrix = drawn(seed, 12, 17)
    matrix[5], matrix[9] = matrix[2] - 0.5 * matrix[3], matrix[7]
    rank, row_order, column_order = order(*entries(matrix), 12, 17, 1e-10)
    assert rank == np.linalg.matrix_rank(matrix) == 10
    assert sorted(row_order) == list(range(12))
    assert sorted(column_order) == list(range(17))
    block = matrix[np.ix_(row_order[:rank], column_order[:rank])]
    assert np.linalg.cond(block) < 1e4


@pytest.mark.parametrize("seed", range(6))
def test_complement_and_null_vectors(seed: int) -> None:
    m, n, strong = 14, 19, 9
    matrix = drawn(seed, m, n)
    _, row_order, column_order = order(*entries(matrix), m, n, 0.0)
    ordered, right = matrix[np.ix_(row_order, column_order)], np.arange(1.0, m + 1.0)
    block = ordered[:strong, :strong]
    reduced = right.copy()
    upper, rows = eliminate(*entries(ordered), m, n, strong, reduced)
    whole = dense(upper, m, n)
    behind = ordered[strong:, :strong] @ np.linalg.inv(block)
    assert whole[strong:, strong:] == pytest.approx(
        ordered[strong:, strong:] - behind @ ordered[:strong, strong:], abs=1e-11
    )
    assert reduced[strong:] == pytest.approx(right[strong:] - behind @ right[:strong], abs=1e-10)
    null = np.vstack([dense(rows, strong, n - strong), np.eye(n - strong)])
    assert np.abs(ordered[:strong] @ null).max() < 1e-11 * np.abs(null).max()


def test_weak_rows_come_last() -> None:
    matrix = np.eye(6, 8)
    matrix[:, 6] = 0.3
    matrix[2] *= 1e-3
    _, row_order, _ = order(*entries(matrix), 6, 8, 0.0)
    assert row_order[-1] == 2
