"""Accelerations and multipliers by the null space of Φ_q, which divide by no mass.

Φ_q is eliminated first, by full pivoting; what its null space leaves, NᵀMN z = Nᵀ(Q − M a_p), adds
up masses and never takes them from each other. So masses may lie as far apart as they like, where
an elimination of the whole system that begins with M loses their ratio. (M. Benzi, G. H. Golub
and J. Liesen, Acta Numerica 14, 2005, section 6.)
"""

import numpy as np

from runtime.core.array_types import Integers, Matrix, Vector, i8, vector
from runtime.core.jit import allocating, inner
from runtime.linalg import cholesky
from runtime.linalg.full_pivoting import factor_fully
from runtime.linalg.leading_block_and_null_vectors import null_vectors
from runtime.linalg.rank_policy import NO_PIVOT
from runtime.linalg.redundant_constraints_solve import SPARSE, solve_factored
from runtime.linalg.row_elimination import Sparse
from runtime.linalg.vectors import dot, multiply

_LEAST = 1e-7  # accuracy: of the largest scale of a column; masses are 1e28 apart there


@inner
def scale_columns(mass: Sparse, scale: Vector) -> None:
    """M_kk^(-1/4), so that light coordinates follow; ten times the largest without mass.

    None is so small beside the largest that its column would count as zero.
    """
    most = 0.0
    scale[:] = 0.0
    for k in range(mass.rows.size):
        if mass.rows[k] == mass.columns[k] and mass.values[k] > 0.0:
            scale[mass.rows[k]] = mass.values[k] ** -0.25
            most = max(most, scale[mass.rows[k]])
    for j in range(scale.size):
        scale[j] = max(scale[j], _LEAST * most) if scale[j] > 0.0 else 10.0 * most


@inner
def unbalanced_force(mass: Sparse, force: Vector, a: Vector, scale: Vector, out: Vector) -> None:
    """Q - M a, scaled."""
    for j in range(force.size):
        out[j] = force[j]
    for k in range(mass.rows.size):
        out[mass.rows[k]] -= mass.values[k] * a[mass.columns[k]]
    for j in range(force.size):
        out[j] *= scale[j]


@inner
def reduced_mass(mass: Sparse, scale: Vector, null: Matrix, unit: Vector, out: Matrix) -> bool:
    """The Cholesky factor of NᵀMN, its rows and columns scaled to a unit diagonal by `unit`."""
    count = null.shape[1]
    out[:, :] = 0.0
    for k in range(mass.rows.size):
        i, j = mass.rows[k], mass.columns[k]
        entry = mass.values[k] * scale[i] * scale[j]
        for s in range(count):
            for r in range(s + 1):
                out[s, r] += entry * null[i, s] * null[j, r]
    for s in range(count):
        if not out[s, s] > 0.0:
            return False
        unit[s] = out[s, s] ** -0.5
    for s in range(count):
        for r in range(s + 1):
            out[s, r] *= unit[s] * unit[r]
    return cholesky.factor_cholesky(out)


@inner
def solve_transposed(
    a: Matrix, row_order: Integers, column_order: Integers, right: Vector, y: Vector, x: Vector
) -> None:
    """x with Aᵀ x = `right` in the columns that have a pivot, A as `factor_fully` left it.

    `y`, (m,), is scratch.
    """
    m = row_order.size
    for s in range(m):
        y[s] = right[column_order[s]]
        for k in range(s):
            y[s] -= a[k, s] * y[k]
        y[s] /= a[s, s]
    for s in range(m - 1, -1, -1):
        for k in range(s + 1, m):
            y[s] -= a[k, s] * y[k]
        x[row_order[s]] = y[s]


@allocating(i8(SPARSE, SPARSE, vector, vector, vector, vector))
def solve_motion_by_null_space(
    jacobian: Sparse, mass: Sparse, force: Vector, gamma: Vector, a: Vector, lam: Vector
) -> int:
    """Solve M a + Φ_qᵀ λ = Q, Φ_q a = γ, for `a`, (n,), and `lam`, (m,).

    Returns how many constraints follow from others; where there are any, or no mass resists a
    motion, nothing is solved.
    """
    n, m = force.size, gamma.size
    count = n - m
    if count < 0:
        return int(m)
    dense, scale, unit = np.zeros((m, n)), np.zeros(n), np.ones(m)
    scale_columns(mass, scale)
    for k in range(jacobian.rows.size):
        i, j = jacobian.rows[k], jacobian.columns[k]
        dense[i, j] += jacobian.values[k] * scale[j]
    right = np.zeros(m)
    for i in range(m):
        largest = 0.0
        for j in range(n):
            largest = max(largest, abs(dense[i, j]))
        unit[i] = 1.0 / largest if largest > 0.0 else 1.0
        for j in range(n):
            dense[i, j] *= unit[i]
        right[i] = gamma[i] * unit[i]
    row_order, column_order = np.zeros(m, np.int64), np.zeros(n, np.int64)
    rank = factor_fully(dense, row_order, column_order, NO_PIVOT)
    if rank < m:
        return int(m - rank)
    null, x, rest = np.zeros((n, count)), np.zeros(n), np.zeros(n)
    null_vectors(dense, m, column_order, null)
    solve_factored(dense, rank, row_order, column_order, right, x)
    for j in range(n):
        a[j] = scale[j] * x[j]
    factor, even, z = np.zeros((count, count)), np.zeros(count), np.zeros(count)
    if not reduced_mass(mass, scale, null, even, factor):
        return int(m)
    for _ in range(2):  # the second time for what rounding left
        unbalanced_force(mass, force, a, scale, rest)
        multiply(null.T, rest, z)
        for s in range(count):
            z[s] *= even[s]
        cholesky.solve_cholesky(factor, z)
        for s in range(count):
            z[s] *= even[s]
        for j in range(n):
            a[j] += scale[j] * dot(null[j], z)
    unbalanced_force(mass, force, a, scale, rest)
    solve_transposed(dense, row_order, column_order, rest, right, lam)
    for i in range(m):
        lam[i] *= unit[i]
    return 0
