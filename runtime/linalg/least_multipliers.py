"""Multipliers of least norm, where constraints are redundant.

Many multipliers exert the same forces Φ_qᵀ λ there; those of least norm are a choice that follows
from the position alone.
"""

import numpy as np

from runtime.core.arrays import Integers, Vector, i8, integers, none, vector
from runtime.core.jit import allocating, inner
from runtime.linalg.dense_elimination import factor_fully
from runtime.linalg.leading_block import null_vectors
from runtime.linalg.rank_policy import NO_PIVOT


@inner
def minimise_norm(free: Vector, count: int, lam: Vector) -> None:
    """Take from λ, (m,), its part in the span of vectors, which is not determined.

    The vectors stand one after the other in `free`, (k m,), which is overwritten, and span `count`
    dimensions: the longest of what is left is taken each time, so that none that follows from
    others is.
    """
    m = lam.size
    for _ in range(count):
        most, at = 0.0, -1
        for first in range(0, free.size, m):
            square = 0.0
            for i in range(first, first + m):
                square += free[i] * free[i]
            if square > most:
                most, at = square, first
        if at < 0:
            return
        share = 0.0
        for i in range(m):
            share += free[at + i] * lam[i]
        for i in range(m):
            lam[i] -= share / most * free[at + i]
        for first in range(0, free.size, m):
            if first != at:
                share = 0.0
                for i in range(m):
                    share += free[at + i] * free[first + i]
                for i in range(m):
                    free[first + i] -= share / most * free[at + i]
        for i in range(m):
            free[at + i] = 0.0


@allocating(none(integers, integers, vector, i8, i8, vector))
def take_least_multipliers(
    rows: Integers, columns: Integers, slopes: Vector, n: int, redundant: int, lam: Vector
) -> None:
    """Make multipliers, (m,), those of least norm that exert the same forces Φ_qᵀ λ.

    `slopes`, (nnz,), are the non-zeros of Φ_q, of n columns; at least `redundant` of its rows
    follow from others.
    """
    m = lam.size
    across, unit = np.zeros((n, m)), np.zeros(m)
    for e in range(rows.size):
        unit[rows[e]] = max(unit[rows[e]], abs(slopes[e]))
    for e in range(rows.size):
        if unit[rows[e]] > 0.0:
            across[columns[e], rows[e]] += slopes[e] / unit[rows[e]]
    row_order, column_order = np.zeros(n, np.int64), np.zeros(m, np.int64)
    rank = min(factor_fully(across, row_order, column_order, NO_PIVOT), m - redundant)
    null, free = np.zeros((m, m - rank)), np.zeros((m - rank) * m)
    null_vectors(across, rank, column_order, null)
    for i in range(m):
        for k in range(m - rank):
            free[k * m + i] = null[i, k] / (unit[i] if unit[i] > 0.0 else 1.0)
    minimise_norm(free, m - rank, lam)
