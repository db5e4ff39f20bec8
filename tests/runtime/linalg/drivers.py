"""Ways in from Python to linear algebra that only compiled code calls; numba keeps them on disk."""

import numpy as np

from runtime.core.arrays import f8, i8, integers, matrix, none, vector
from runtime.core.jit import allocating, compiled
from runtime.core.kernel_abi import SIGNATURES
from runtime.linalg import (
    dense_elimination,
    leading_block,
    least_multipliers,
    orthogonal_factors,
    symbolic_elimination,
)


@allocating(i8(vector, i8, vector))
def solve_by_factors(a, f, b):
    """`lu.factor`, then `lu.solve`."""
    pivots = np.zeros(f, np.int64)
    if dense_elimination.factor(a, f, pivots, 0.0) != 0:
        return 1
    dense_elimination.solve(a, f, pivots, b)
    return 0


@allocating(i8(vector, vector, i8, f8))
def solve_equilibrated(a, b, f, least):
    return dense_elimination.solve_equilibrated(a, b, f, np.zeros(f, np.int64), least)


@compiled(i8(matrix, matrix))
def factor_gram(vectors, out):
    """Cholesky factor of the columns' products; 0 where they have none."""
    orthogonal_factors.multiply_gram(vectors, out)
    return int(orthogonal_factors.factor_cholesky(out))


@compiled(none(matrix, vector))
def solve_cholesky(factor, x):
    orthogonal_factors.solve_cholesky(factor, x)


@compiled(none(matrix, matrix))
def orthonormalise(factor, vectors):
    orthogonal_factors.orthonormalise(factor, vectors)


@compiled(none(vector, i8, vector))
def minimise_norm(free, count, lam):
    least_multipliers.minimise_norm(free, count, lam)


@compiled(i8(matrix, i8, vector, f8))
def eliminate_leading(a, r, right, least):
    return int(leading_block.eliminate_leading(a, r, right, least))


@compiled(none(matrix, i8, vector, vector))
def complete_solution(a, r, right, x):
    leading_block.complete_solution(a, r, right, x)


@compiled(none(matrix, i8, integers, integers, matrix, matrix))
def both_vectors(a, r, row_order, column_order, left, null):
    leading_block.left_vectors(a, r, row_order, left)
    leading_block.null_vectors(a, r, column_order, null)


@compiled(SIGNATURES["jacobian"])
def entries_linear_in_time(t, q, p, values):
    """A Jacobian whose values are the first half of p, and change at the rates in the second."""
    for k in range(values.size):
        values[k] = p[k] + t * p[values.size + k]


@allocating(none(f8, vector, vector, integers, integers, vector, matrix))
def fill_unit_rows(t, p, scale, rows, columns, values, dense):
    """Of the Jacobian that `entries_linear_in_time` gives."""
    entries_linear_in_time(t, scale, p, values)
    sparse, inverse = dense_elimination.Sparse(rows, columns, values), np.empty(len(dense))
    dense_elimination.fill_unit_rows(sparse, scale, np.zeros(len(dense)), dense, inverse)


@compiled(f8(matrix, integers, vector, i8))
def eliminate_rows(dense, order, pivots, search):
    """`eliminate_rows`, and the smallest pivot."""
    dense_elimination.eliminate_rows(dense, order, pivots, search)
    return dense_elimination.smallest_pivot(pivots)


@compiled(none(integers, integers, integers, vector, vector, matrix, integers, vector))
def write_plan(order, rows, columns, values, scale, dense, plan, lengths):
    sparse = dense_elimination.Sparse(rows, columns, values)
    symbolic_elimination.write_plan(order, sparse, scale, dense, plan, lengths)


@compiled(i8(f8, vector, vector, integers, integers, vector, vector, integers, vector, vector))
def replay_plan(t, p, scale, rows, columns, values, flat, plan, lengths, pivots):
    """Of the Jacobian that `entries_linear_in_time` gives."""
    entries_linear_in_time(t, scale, p, values)
    sparse = dense_elimination.Sparse(rows, columns, values)
    return int(symbolic_elimination.replay_plan(sparse, scale, flat, plan, lengths, pivots))
