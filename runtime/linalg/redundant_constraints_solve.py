"""Solutions where constraints are redundant: pivots are chosen by size, and none is too small.

The static factorization of a generated module needs independent constraints. These routines are
slower by an order of magnitude and need nothing: rows that follow from others are left without a
pivot. The accelerations do not depend on which; of the multipliers, of which there are many, those
of least norm are given.
"""

import numba
import numpy as np

from runtime.core import arrays
from runtime.core.arrays import Integers, Matrix, Vector, i8, integers, matrix, none, vector
from runtime.core.jit import allocating, inner
from runtime.linalg import orthogonal_factors
from runtime.linalg.dense_elimination import Sparse, factor_fully
from runtime.linalg.leading_block import complete_solution, null_vectors
from runtime.linalg.rank_policy import NO_PIVOT
from runtime.linalg.vectors import dot, multiply

_constant = numba.types.Array(i8, 1, "C", readonly=True)  # integers that a closure holds
SPARSE = arrays.named_tuple_type((_constant, _constant, vector), Sparse)

_NULL = 1e-9  # accuracy: component of a null vector with a component 1, below which it is none


@allocating(none(matrix, i8, integers, integers, vector, vector))
def solve_factored(
    a: Matrix, rank: int, row_order: Integers, column_order: Integers, right: Vector, x: Vector
) -> None:
    """A solution of A x = right, A as `factor_fully` left it; unknowns without a pivot are zero."""
    reduced, placed = np.zeros(rank), np.zeros(a.shape[1])
    for k in range(rank):
        reduced[k] = right[row_order[k]]
        for j in range(k):
            reduced[k] -= a[k, j] * reduced[j]
    complete_solution(a, rank, reduced, placed)
    for k in range(x.size):
        x[column_order[k]] = placed[k]


@allocating(i8(SPARSE, vector, matrix, matrix))
def solve_least_norm(jacobian: Sparse, w: Vector, right: Matrix, d: Matrix) -> int:
    """Solve Φ_q d = right for the d that are least in dᵀ W⁻¹ d, W = diag(w); the rank of Φ_q W.

    d = W Φ_qᵀ μ with Φ_q W Φ_qᵀ μ = right. Rounding of that matrix is the square of a distance of
    rows, so that in terms of distances the tolerance of its pivots is the root of `NO_PIVOT`. A
    weight 0 in `w`, (n,), holds a coordinate; `right`, (k, m), is overwritten, and `d`, (k, n),
    receives the solutions.
    """
    rows, columns, values = jacobian.rows, jacobian.columns, jacobian.values
    (count, m), n = right.shape, w.size
    root = np.sqrt(w)
    across = np.zeros((n, m))  # √W Φ_qᵀ
    for e in range(rows.size):
        across[columns[e], rows[e]] += values[e] * root[columns[e]]
    for i in range(m):
        total = dot(across[:, i], across[:, i])
        if total > 0.0:
            unit = 1.0 / np.sqrt(total)
            for k in range(n):
                across[k, i] *= unit
            for c in range(count):
                right[c, i] *= unit
    normal, order = np.zeros((m, m)), np.zeros(m, np.int64)
    orthogonal_factors.multiply_gram(across, normal)
    rank = orthogonal_factors.factor_semidefinite(normal, order, NO_PIVOT)
    mu = np.zeros(rank)
    d[:, :] = 0.0
    for c in range(count):
        for s in range(rank):
            mu[s] = right[c, order[s]]
        orthogonal_factors.solve_cholesky(normal, mu)
        for k in range(n):
            for s in range(rank):
                d[c, k] += across[k, order[s]] * mu[s]
            d[c, k] *= root[k]
    return int(rank)


@inner
def scale_symmetrically(matrix: Matrix, n: int, scale: Vector) -> None:
    """Scale (M Φ_qᵀ; Φ_q 0) to a unit diagonal of M and rows of Φ_q with largest entry 1."""
    size = scale.size
    scale[:] = 1.0
    for j in range(n):
        if matrix[j, j] > 0.0:
            scale[j] = 1.0 / np.sqrt(matrix[j, j])
    for i in range(n, size):
        largest = 0.0
        for j in range(n):
            largest = max(largest, abs(matrix[i, j]) * scale[j])
        if largest > 0.0:
            scale[i] = 1.0 / largest
    for i in range(size):
        for j in range(size):
            matrix[i, j] *= scale[i] * scale[j]


@allocating(none(matrix, vector))
def minimise_norm(free: Matrix, lam: Vector) -> None:
    """Subtract from λ its part along the columns of `free`, (m, k), which is not determined."""
    m, count = free.shape
    gram, share = np.zeros((count, count)), np.zeros(count)
    orthogonal_factors.multiply_gram(free, gram)
    if not orthogonal_factors.factor_cholesky(gram):
        return
    multiply(free.T, lam, share)
    orthogonal_factors.solve_cholesky(gram, share)
    for i in range(m):
        for k in range(count):
            lam[i] -= free[i, k] * share[k]


@allocating(i8(SPARSE, SPARSE, vector, vector, vector, vector))
def solve_motion(
    jacobian: Sparse, mass: Sparse, force: Vector, gamma: Vector, a: Vector, lam: Vector
) -> int:
    """Solve M a + Φ_qᵀ λ = Q, Φ_q a = γ, for `a`, (n,), and `lam`, (m,), of the least norm.

    Returns how many constraints follow from others, or more where accelerations are not determined.
    """
    n, m = force.size, gamma.size
    size = n + m
    matrix, scale, right, x = np.zeros((size, size)), np.zeros(size), np.zeros(size), np.zeros(size)
    for k in range(mass.rows.size):
        matrix[mass.rows[k], mass.columns[k]] += mass.values[k]
    for k in range(jacobian.rows.size):
        i, j, value = n + jacobian.rows[k], jacobian.columns[k], jacobian.values[k]
        matrix[i, j] += value
        matrix[j, i] += value
    scale_symmetrically(matrix, n, scale)
    for i in range(size):
        right[i] = scale[i] * (force[i] if i < n else gamma[i - n])
    row_order, column_order = np.zeros(size, np.int64), np.zeros(size, np.int64)
    rank = factor_fully(matrix, row_order, column_order, NO_PIVOT)
    solve_factored(matrix, rank, row_order, column_order, right, x)
    null = np.zeros((size, size - rank))
    null_vectors(matrix, rank, column_order, null)
    lost = size - rank
    undetermined = 0
    for j in range(n):
        a[j] = scale[j] * x[j]
        for k in range(lost):
            if abs(null[j, k]) > _NULL:
                undetermined = size
    free = np.zeros((m, lost))
    for i in range(m):
        lam[i] = scale[n + i] * x[n + i]
        for k in range(lost):
            free[i, k] = scale[n + i] * null[n + i, k]
    minimise_norm(free, lam)
    return int(lost + undetermined)
