"""Elimination of the constraints' Jacobian row by row, in a given order of pivots or a new one.

Rows keep their places; the pivot of each is its largest remaining entry, about the distance of the
row from those before it. In one and the same order of pivots a pivot that changes sign between two
positions announces a singular one in between: their product is the determinant but for its sign.
"""

from typing import NamedTuple

import numpy as np

from runtime.core.array_types import Integers, Matrix, Vector
from runtime.core.jit import inner
from runtime.linalg.rank_policy import REDUNDANT
from runtime.linalg.vectors import dot


class Sparse(NamedTuple):
    """The structural non-zeros of Φ_q, (nnz,)."""

    rows: Integers
    columns: Integers
    values: Vector


@inner
def fill_dense(sparse: Sparse, scale: Vector, dense: Matrix) -> None:
    """Write Φ_q as a dense matrix (m, n), its columns times `scale`."""
    rows, columns, values = sparse.rows, sparse.columns, sparse.values
    dense[:, :] = 0.0
    for k in range(rows.size):
        dense[rows[k], columns[k]] += values[k] * scale[columns[k]]


@inner
def fill_unit_rows(sparse: Sparse, scale: Vector, dense: Matrix) -> None:
    """Write Φ_q as a dense matrix (m, n), its columns times `scale`, its rows of unit length."""
    fill_dense(sparse, scale, dense)
    m, n = dense.shape
    for i in range(m):
        total = dot(dense[i], dense[i])
        if total > 0.0:
            inverse = 1.0 / np.sqrt(total)
            for j in range(n):
                dense[i, j] *= inverse


@inner
def eliminate_rows(dense: Matrix, order: Integers, pivots: Vector, search: int) -> None:
    """Eliminate row by row; `order` holds the column of each row's pivot, chosen if `search`."""
    m, n = dense.shape
    for i in range(m):
        if search != 0:
            order[i] = 0
            for j in range(1, n):
                if abs(dense[i, j]) > abs(dense[i, order[i]]):
                    order[i] = j
        column = order[i]
        pivot = dense[i, column]
        pivots[i] = pivot
        if abs(pivot) <= REDUNDANT:
            continue
        for k in range(i + 1, m):
            if dense[k, column] != 0.0:
                ratio = dense[k, column] / pivot
                for j in range(n):
                    if dense[i, j] != 0.0:
                        dense[k, j] -= ratio * dense[i, j]


@inner
def smallest_pivot(pivots: Vector) -> float:
    """The smallest |pivot|, at most 1, of rows that are not redundant."""
    least = 1.0
    for i in range(pivots.size):
        if REDUNDANT < abs(pivots[i]) < least:
            least = abs(pivots[i])
    return least
