"""Schur complement of a Jacobian at z, with its left vectors and null vectors, in compiled code.

In a given order of pivots, found where the Jacobian was close by, the strong rows are eliminated
with as many columns; behind them stand the weak rows and the free columns. The complement of the
strong block vanishes where the weak rows follow from the strong ones. (Lyapunov-Schmidt reduction:
M. Golubitsky and D. G. Schaeffer, Singularities and Groups in Bifurcation Theory I, 1985, chapter
VII.)
"""

import numpy as np

from runtime.core.array_types import Integers, Matrix, Vector, i8, integers, matrix
from runtime.core.jit import allocating, inner
from runtime.linalg.cholesky import factor_cholesky, multiply_gram, orthonormalise, solve_lower
from runtime.linalg.leading_block import (
    eliminate_leading,
    left_vectors,
    null_vectors,
)
from runtime.linalg.rank_policy import NO_DIVISOR
from runtime.linalg.vectors import largest_magnitude
from runtime.singularity import search_function_table as st


@inner
def eliminate_strong_rows(
    search: Integers, z: Vector, strong: int, a: Matrix, gaps: Vector
) -> bool:
    """Eliminate the strong rows of the Jacobian at z, and of the constraints' values.

    `a`, (rows, n + 1), receives rows and columns in the order of their places, as factors, behind
    the first `strong` ones the Schur complement; `gaps`, (rows,), the values of the rows, those of
    the strong ones eliminated. False where a pivot vanishes.
    """
    values, lengths = st.values_of(search), st.lengths_of(search)
    at_row, at_column = st.entry_rows_of(search), st.entry_columns_of(search)
    row_place, column_place = st.row_place_of(search), st.column_place_of(search)
    st.unit_residuals(search, z, gaps)
    st.jacobian_entries(search, z, values)
    a[:, :] = 0.0
    for e in range(values.size):
        i = at_row[e]
        if i < lengths.size:
            a[row_place[i], column_place[at_column[e]]] += values[e] / lengths[i]
    return bool(eliminate_leading(a, strong, gaps, NO_DIVISOR))


@inner
def find_vectors(search: Integers, a: Matrix, strong: int, left: Matrix, null: Matrix) -> None:
    """Left vectors and null vectors after the elimination of the strong rows."""
    left_vectors(a, strong, st.row_order_of(search), left)
    null_vectors(a, strong, st.column_order_of(search), null)


@inner
def normalise_complement(
    a: Matrix, strong: int, left: Matrix, null: Matrix, square: Matrix, normal: Matrix
) -> bool:
    """Turn the complement G in `a` into that of orthonormal vectors, R_u⁻ᵀ G R_z⁻¹.

    `square`, (weak, weak), and `normal`, (free, free), receive the Cholesky factors of the left and
    the null vectors' products. Returns whether they have such factors.
    """
    multiply_gram(left, square)
    multiply_gram(null, normal)
    if not (factor_cholesky(square) and factor_cholesky(normal)):
        return False
    orthonormalise(normal, a[strong:, strong:])
    orthonormalise(square, a[strong:, strong:].T)
    return True


@inner
def largest_lost_gap(gaps: Vector, strong: int, lower: Matrix) -> float:
    """Largest |uᵀ Φ| of the orthonormal left vectors u; `lower` is the factor of their products."""
    lost = gaps[strong:]
    solve_lower(lower, lost)
    return float(largest_magnitude(lost))


@allocating(i8(integers, matrix, i8))
def reduce_to_weak_part(search: Integers, a: Matrix, strong: int) -> int:
    """Turn the complement of a factored matrix into that of orthonormal vectors; 0 if it has none.

    Its singular values are then the small ones of the matrix, but for the square of their ratio to
    the others: with a complement of zero these would be singular vectors of the matrix.
    """
    rows, wide = a.shape
    weak, free = rows - strong, wide - strong
    left, null = np.empty((rows, weak)), np.empty((wide, free))
    square, normal = np.empty((weak, weak)), np.empty((free, free))
    find_vectors(search, a, strong, left, null)
    return int(normalise_complement(a, strong, left, null, square, normal))
