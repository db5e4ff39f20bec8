"""Solutions where constraints are redundant: pivots are chosen by size, and none is too small.

The static factorization of a generated module needs independent constraints. These are slower by an
order of magnitude and need nothing: rows that follow from others are left without a pivot. The
accelerations do not depend on which; of the multipliers, of which there are many, those of least
norm are given.
"""

import numpy as np
from numba import types

from runtime.core.jit import allocating
from runtime.core.signatures import Integers, Matrix, Vector, i8, matrix, vector

constant = types.Array(types.int64, 1, "C", readonly=True)  # integers that a closure holds

_NONE = 1e-10  # a pivot below this, rows and columns scaled to unit diagonal, is none
_NULL = 1e-9


@allocating(i8(constant, constant, vector, vector, matrix, matrix))
def least(
    rows: Integers, columns: Integers, values: Vector, w: Vector, right: Matrix, d: Matrix
) -> int:
    """Solve Φ_q d = right for the d that are least in dᵀ W⁻¹ d, W = diag(w).

    LDLᵀ of Φ_q W Φ_qᵀ with diagonal pivoting.

    Parameters
    ----------
    rows, columns, values : (nnz,)
        Φ_q.
    w : (n,)
        Weights; 0 holds a coordinate.
    right : (k, m)
        Right sides; overwritten.
    d : (k, n)
        Out.

    Returns
    -------
    int
        Rank of Φ_q W.
    """
    count, m = right.shape
    n = w.size
    dense = np.zeros((m, n))
    for k in range(rows.size):
        dense[rows[k], columns[k]] += values[k]
    S = np.zeros((m, m))
    for i in range(m):
        for j in range(i + 1):
            total = 0.0
            for k in range(n):
                total += dense[i, k] * w[k] * dense[j, k]
            S[i, j] = S[j, i] = total
    unit = np.ones(m)
    for i in range(m):
        if S[i, i] > 0.0:
            unit[i] = 1.0 / np.sqrt(S[i, i])
    for i in range(m):
        for j in range(m):
            S[i, j] *= unit[i] * unit[j]
        for c in range(count):
            right[c, i] *= unit[i]
    order = np.arange(m)
    rank = m
    for step in range(m):
        best = step
        for i in range(step + 1, m):
            if S[order[i], order[i]] > S[order[best], order[best]]:
                best = i
        order[step], order[best] = order[best], order[step]
        pivot = order[step]
        if not S[pivot, pivot] > _NONE:
            rank = step
            break
        for i in range(step + 1, m):
            row = order[i]
            factor = S[row, pivot] / S[pivot, pivot]
            if factor != 0.0:
                for j in range(step + 1, m):
                    S[row, order[j]] -= factor * S[pivot, order[j]]
                for c in range(count):
                    right[c, row] -= factor * right[c, pivot]
    d[:, :] = 0.0
    mu = np.zeros(m)
    for c in range(count):
        for step in range(rank - 1, -1, -1):
            pivot = order[step]
            total = right[c, pivot]
            for j in range(step + 1, rank):
                total -= S[pivot, order[j]] * mu[order[j]]
            mu[pivot] = total / S[pivot, pivot]
        for step in range(rank):
            i = order[step]
            for k in range(n):
                d[c, k] += w[k] * dense[i, k] * unit[i] * mu[i]
    return int(rank)


@allocating(i8(matrix, vector, vector, matrix))
def eliminated(matrix: Matrix, right: Vector, x: Vector, null: Matrix) -> int:
    """Solve a square system by Gaussian elimination with full pivoting.

    Parameters
    ----------
    matrix : (N, N)
        Overwritten, as is `right`.
    x : (N,)
        Out: a solution; unknowns without a pivot are zero.
    null : (N, N)
        Out: in its first rows, vectors that span the null space.

    Returns
    -------
    int
        Dimension of the null space.
    """
    size = right.size
    row, column = np.arange(size), np.arange(size)
    rank = size
    for step in range(size):
        largest, at_row, at_column = 0.0, step, step
        for i in range(step, size):
            for j in range(step, size):
                entry = abs(matrix[row[i], column[j]])
                if entry > largest:
                    largest, at_row, at_column = entry, i, j
        row[step], row[at_row] = row[at_row], row[step]
        column[step], column[at_column] = column[at_column], column[step]
        if not largest > _NONE:
            rank = step
            break
        pivot = matrix[row[step], column[step]]
        for i in range(step + 1, size):
            factor = matrix[row[i], column[step]] / pivot
            if factor != 0.0:
                for j in range(step + 1, size):
                    matrix[row[i], column[j]] -= factor * matrix[row[step], column[j]]
                right[row[i]] -= factor * right[row[step]]
    x[:] = 0.0
    for step in range(rank - 1, -1, -1):
        total = right[row[step]]
        for j in range(step + 1, rank):
            total -= matrix[row[step], column[j]] * x[column[j]]
        x[column[step]] = total / matrix[row[step], column[step]]
    for k in range(size - rank):
        null[k, :] = 0.0
        null[k, column[rank + k]] = 1.0
        for step in range(rank - 1, -1, -1):
            total = -matrix[row[step], column[rank + k]]
            for j in range(step + 1, rank):
                total -= matrix[row[step], column[j]] * null[k, column[j]]
            null[k, column[step]] = total / matrix[row[step], column[step]]
    return size - rank


@allocating(
    i8(constant, constant, vector, constant, constant, vector, vector, vector, vector, vector)
)
def motion(
    rows: Integers,
    columns: Integers,
    values: Vector,
    mass_rows: Integers,
    mass_columns: Integers,
    masses: Vector,
    force: Vector,
    gamma: Vector,
    a: Vector,
    lam: Vector,
) -> int:
    """Solve M a + Φ_qᵀ λ = Q, Φ_q a = γ; λ has the least norm.

    Parameters
    ----------
    rows, columns, values : (nnz,)
        Φ_q; `mass_rows` and so on likewise M.
    force, gamma : (n,), (m,)
        Q and γ.
    a, lam : (n,), (m,)
        Out.

    Returns
    -------
    int
        How many constraints follow from others, or more where accelerations are not determined.
    """
    n, m = force.size, gamma.size
    size = n + m
    matrix = np.zeros((size, size))
    for k in range(mass_rows.size):
        matrix[mass_rows[k], mass_columns[k]] += masses[k]
    for k in range(rows.size):
        matrix[n + rows[k], columns[k]] += values[k]
        matrix[columns[k], n + rows[k]] += values[k]
    scale = np.ones(size)
    for j in range(n):
        if matrix[j, j] > 0.0:
            scale[j] = 1.0 / np.sqrt(matrix[j, j])
    for i in range(n, size):
        largest = 0.0
        for j in range(n):
            largest = max(largest, abs(matrix[i, j]) * scale[j])
        if largest > 0.0:
            scale[i] = 1.0 / largest
    right = np.empty(size)
    for i in range(size):
        right[i] = scale[i] * (force[i] if i < n else gamma[i - n])
        for j in range(size):
            matrix[i, j] *= scale[i] * scale[j]
    x = np.empty(size)
    null = np.empty((size, size))
    lost = eliminated(matrix, right, x, null)
    for j in range(n):
        a[j] = scale[j] * x[j]
    for i in range(m):
        lam[i] = scale[n + i] * x[n + i]
    # Modified Gram-Schmidt on what may be added to λ; then none of it is left.
    undetermined = 0
    for k in range(lost):
        for j in range(n):
            if abs(null[k, j]) > _NULL:
                undetermined = size
        for i in range(m):
            null[k, n + i] *= scale[n + i]
    for k in range(lost):
        for other in range(k):
            share = 0.0
            for i in range(m):
                share += null[k, n + i] * null[other, n + i]
            for i in range(m):
                null[k, n + i] -= share * null[other, n + i]
        length = 0.0
        for i in range(m):
            length += null[k, n + i] ** 2
        length = np.sqrt(length)
        share = 0.0
        for i in range(m):
            null[k, n + i] /= length
            share += null[k, n + i] * lam[i]
        for i in range(m):
            lam[i] -= share * null[k, n + i]
    return lost + undetermined
