"""Accelerations and multipliers by the null space of Φ_q, which divide by no mass.

Φ_q is eliminated first, by full pivoting; what its null space leaves, NᵀMN z = Nᵀ(Q − M a_p), adds
up masses and never takes them from each other. So masses may lie as far apart as they like, where
an elimination of the whole system that begins with M loses their ratio. (M. Benzi, G. H. Golub
and J. Liesen, Acta Numerica 14, 2005, section 6.)
"""

import numba
import numpy as np

from runtime.core import arrays
from runtime.core.arrays import Integers, Matrix, Vector, i8, integers, matrix, none, vector
from runtime.core.jit import allocating, inner
from runtime.linalg import orthogonal_factors
from runtime.linalg.dense_elimination import Sparse, eliminate_below
from runtime.linalg.leading_block import complete_solution, null_vectors
from runtime.linalg.rank_policy import NO_PIVOT
from runtime.linalg.vectors import dot, multiply

_constant = numba.types.Array(i8, 1, "C", readonly=True)  # integers that a closure holds
SPARSE = arrays.named_tuple_type((_constant, _constant, vector), Sparse)

_LEAST = 1e-7  # accuracy: of the largest scale of a column; least scale, above the noise of pivots
_CLOSED = 1e-9  # accuracy: part of a row's terms that may be left; rounding leaves 1e-12 at most


@inner
def scale_columns(mass: Sparse, scale: Vector, weight: Vector) -> None:
    """M_kk^(-1/4) and M_kk^(-1/2); ten times the largest without mass.

    The first tells pivots from noise: none is so small beside the largest that its column would
    count as zero. The second chooses pivots, so that light coordinates follow heavy ones.
    """
    most = 0.0
    weight[:] = 0.0
    for k in range(mass.rows.size):
        if mass.rows[k] == mass.columns[k] and mass.values[k] > 0.0:
            weight[mass.rows[k]] = mass.values[k] ** -0.5
            most = max(most, weight[mass.rows[k]])
    for j in range(scale.size):
        if not weight[j] > 0.0:
            weight[j] = 100.0 * most
        scale[j] = max(weight[j] ** 0.5, _LEAST * most**0.5)


@inner
def factor_weighted(
    dense: Matrix, unit: Vector, scale: Vector, weight: Vector, row_order: Integers,
    column_order: Integers,
) -> int:  # fmt: skip
    """Eliminate as `factor_fully` does, with the pivots that are largest with their weights.

    `dense` comes with rows times `unit` and columns times `scale`, and its factors leave without.
    """
    m, n = dense.shape
    for i in range(m):
        row_order[i] = i
    for j in range(n):
        column_order[j] = j
    for step in range(m):
        most, at_row, at_column = 0.0, -1, step
        for i in range(step, m):
            for j in range(step, n):
                size, column = abs(dense[i, j]), column_order[j]
                if size > NO_PIVOT and size * (weight[column] / scale[column]) > most:
                    most = (1.0 + 1e-9) * size * (weight[column] / scale[column])
                    at_row, at_column = i, j
        if at_row < 0:
            return step
        for j in range(n):
            dense[step, j], dense[at_row, j] = dense[at_row, j], dense[step, j]
        for i in range(m):
            dense[i, step], dense[i, at_column] = dense[i, at_column], dense[i, step]
        row, column = row_order[at_row], column_order[at_column]
        row_order[at_row], column_order[at_column] = row_order[step], column_order[step]
        row_order[step], column_order[step] = row, column
        eliminate_below(dense, step)
    for i in range(m):
        own = unit[row_order[i]]
        for j in range(n):
            other = unit[row_order[j]] / own if j < i else 1.0 / (own * scale[column_order[j]])
            dense[i, j] *= other
    return int(m)


@inner
def unbalanced_force(mass: Sparse, force: Vector, a: Vector, out: Vector) -> None:
    """Q - M a."""
    for j in range(force.size):
        out[j] = force[j]
    for k in range(mass.rows.size):
        out[mass.rows[k]] -= mass.values[k] * a[mass.columns[k]]


@inner
def reduced_mass(mass: Sparse, null: Matrix, unit: Vector, out: Matrix) -> bool:
    """The Cholesky factor of NᵀMN, its rows and columns scaled to a unit diagonal by `unit`."""
    count = null.shape[1]
    out[:, :] = 0.0
    for k in range(mass.rows.size):
        i, j = mass.rows[k], mass.columns[k]
        for s in range(count):
            for r in range(s + 1):
                out[s, r] += mass.values[k] * null[i, s] * null[j, r]
    for s in range(count):
        if not out[s, s] > 0.0:
            return False
        unit[s] = out[s, s] ** -0.5
    for s in range(count):
        for r in range(s + 1):
            out[s, r] *= unit[s] * unit[r]
    return orthogonal_factors.factor_cholesky(out)


@inner
def solve_transposed(
    a: Matrix, row_order: Integers, column_order: Integers, right: Vector, y: Vector, x: Vector
) -> None:
    """x with Aᵀ x = `right` in the columns that have a pivot, A as `factor_weighted` left it.

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


@inner
def is_solved(
    jacobian: Sparse, mass: Sparse, force: Vector, gamma: Vector, a: Vector, lam: Vector,
    left: Vector, terms: Vector,
) -> bool:  # fmt: skip
    """Whether the equations hold, each beside its own terms; `left` and `terms`: (n + m,), scratch.

    The noise of an acceleration that is zero lies beside the largest one. Forces that are not
    finite have a name of their own elsewhere.
    """
    n, m = force.size, gamma.size
    most = 0.0
    for j in range(n):
        most = max(most, abs(a[j]))
        left[j], terms[j] = -force[j], abs(force[j])
        if not np.isfinite(force[j]):
            return True
    for i in range(m):
        left[n + i], terms[n + i] = -gamma[i], abs(gamma[i])
        if not np.isfinite(gamma[i]):
            return True
    for k in range(mass.rows.size):
        i, j, value = mass.rows[k], mass.columns[k], mass.values[k]
        left[i] += value * a[j]
        terms[i] += abs(value) * (most if i == j else abs(a[j]))
    for k in range(jacobian.rows.size):
        i, j, value = jacobian.rows[k], jacobian.columns[k], jacobian.values[k]
        left[j] += value * lam[i]
        terms[j] += abs(value * lam[i])
        left[n + i] += value * a[j]
        terms[n + i] += abs(value) * most
    solved = True
    for i in range(n + m):
        solved = solved and abs(left[i]) <= _CLOSED * terms[i]
    return solved


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


@allocating(i8(SPARSE, SPARSE, vector, vector, vector, vector))
def solve_motion_by_null_space(
    jacobian: Sparse, mass: Sparse, force: Vector, gamma: Vector, a: Vector, lam: Vector
) -> int:
    """Solve M a + Φ_qᵀ λ = Q, Φ_q a = γ, for `a`, (n,), and `lam`, (m,).

    Returns how many constraints follow from others; where there are any, no mass resists a motion,
    or numbers so far apart leave the equations unsolved, `a` and `lam` say nothing.
    """
    n, m = force.size, gamma.size
    count = n - m
    if count < 0:
        return int(m)
    dense, scale, weight, unit = np.zeros((m, n)), np.zeros(n), np.zeros(n), np.ones(m)
    scale_columns(mass, scale, weight)
    for k in range(jacobian.rows.size):
        i, j = jacobian.rows[k], jacobian.columns[k]
        dense[i, j] += jacobian.values[k] * scale[j]
    for i in range(m):
        largest = 0.0
        for j in range(n):
            largest = max(largest, abs(dense[i, j]))
        unit[i] = 1.0 / largest if largest > 0.0 else 1.0
        for j in range(n):
            dense[i, j] *= unit[i]
    row_order, column_order = np.zeros(m, np.int64), np.zeros(n, np.int64)
    rank = factor_weighted(dense, unit, scale, weight, row_order, column_order)
    if rank < m:
        return int(m - rank)
    null, rest = np.zeros((n, count)), np.zeros(n)
    lam[:] = 0.0
    null_vectors(dense, m, column_order, null)
    for s in range(count):
        for j in range(n):
            null[j, s] *= weight[column_order[m + s]]  # against overflow
    solve_factored(dense, rank, row_order, column_order, gamma, a)
    factor, even, z = np.zeros((count, count)), np.zeros(count), np.zeros(count)
    if not reduced_mass(mass, null, even, factor):
        return int(m)
    for _ in range(2):  # the second time for what rounding left
        unbalanced_force(mass, force, a, rest)
        multiply(null.T, rest, z)
        for s in range(count):
            z[s] *= even[s]
        orthogonal_factors.solve_cholesky(factor, z)
        for s in range(count):
            z[s] *= even[s]
        for j in range(n):
            a[j] += dot(null[j], z)
    scratch, correction = np.zeros(m), np.zeros(m)
    for _ in range(2):  # the second time for small multipliers beside large ones
        unbalanced_force(mass, force, a, rest)
        for k in range(jacobian.rows.size):
            rest[jacobian.columns[k]] -= jacobian.values[k] * lam[jacobian.rows[k]]
        solve_transposed(dense, row_order, column_order, rest, scratch, correction)
        for i in range(m):
            lam[i] += correction[i]
    left, terms = np.zeros(n + m), np.zeros(n + m)
    return 0 if is_solved(jacobian, mass, force, gamma, a, lam, left, terms) else int(m)
