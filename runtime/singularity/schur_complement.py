"""Schur complement of a Jacobian at z, with its left vectors and null vectors, in compiled code.

In a given order of pivots, found where the Jacobian was close by, the strong rows are eliminated
with as many columns; behind them stand the weak rows and the free columns. The complement of the
strong block vanishes where the weak rows follow from the strong ones. (Lyapunov-Schmidt reduction:
M. Golubitsky and D. G. Schaeffer, Singularities and Groups in Bifurcation Theory I, 1985, chapter
VII.)

Orders of pivots of Jacobians, and how many of their rows are weak: near to being lost.
"""

from typing import NamedTuple

import numpy as np

from runtime.core.arrays import Integers, Matrix, Vector, i8, integers, matrix
from runtime.core.jit import allocating, inner
from runtime.linalg.dense_elimination import factor_fully
from runtime.linalg.leading_block import eliminate_leading, left_vectors, null_vectors
from runtime.linalg.orthogonal_factors import (
    factor_cholesky,
    multiply_gram,
    orthonormalise,
    solve_lower,
)
from runtime.linalg.rank_policy import NO_DIVISOR
from runtime.linalg.vectors import largest_magnitude
from runtime.singularity import search_function_table as st
from runtime.singularity.scaled_constraints import ScaledConstraints


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


_WEAK = 0.3  # measured: singular values above this, in unit rows of scaled columns, are not weak
_APART = 3.0  # measured: factor by which the weak singular values lie below the others
_NONE = 1e-9  # accuracy: singular values below this are all zero
_KNOWN = 0.02  # measured: difference of two Jacobians up to which they share an order of pivots
_KEPT = 4  # measured: orders of pivots that are remembered
STRONG = 0.5  # measured: a pivot above this belongs to no weak row


class PivotOrder(NamedTuple):
    """A Jacobian's non-zeros, its order of pivots, and how many of its singular values are weak."""

    entries: Vector
    row_order: Integers
    column_order: Integers
    weak: int


class PivotOrders:
    """Orders of pivots of the last few Jacobians of a machine's constraints."""

    def __init__(self, constraints: ScaledConstraints) -> None:
        self.constraints = constraints
        self.known: tuple[PivotOrder, ...] = ()

    def near(self, entries: Vector) -> PivotOrder:
        """Order of pivots of the Jacobian with these entries, or of one that hardly differs."""
        for known in self.known:
            if np.abs(known.entries - entries).max() < _KNOWN:
                return known
        order = self._choose(entries)
        self.known = (order, *self.known[: _KEPT - 1])
        return order

    def _choose(self, entries: Vector) -> PivotOrder:
        """Full pivoting as far as pivots are large; singular values of the complement of these."""
        constraints = self.constraints
        table, arrays = constraints.layout
        orders = arrays["row_order"], arrays["column_order"]
        a = constraints.dense(entries)
        strong, rows = factor_fully(a, *orders, STRONG), len(a)
        values = np.ones(rows)
        if strong < rows:
            weak_part = a[strong:, strong:].copy()
            if reduce_to_weak_part(table, a, strong):
                values[strong:] = 0.0
                smallest = np.linalg.svd(a[strong:, strong:], compute_uv=False)
                values[strong : strong + smallest.size] = smallest
            places = np.empty(rows - strong, np.int64), np.empty(len(a[0]) - strong, np.int64)
            factor_fully(weak_part, *places, 0.0)
            for order, behind in zip(orders, places, strict=True):
                order[strong:] = order[strong:][behind]
        return PivotOrder(
            entries, orders[0].copy(), orders[1].copy(), count_weak(np.minimum(values, 1))
        )


def count_weak(values: Vector) -> int:
    """How many of the singular values, in falling order, lie apart from the others near zero."""
    small = int(np.sum(values < _WEAK))
    if small == 0 or small == len(values):
        return small
    values = np.maximum(values, _NONE)
    ratios = values[len(values) - small - 1 : -1] / values[len(values) - small :]
    return small - int(ratios.argmax()) if ratios.max() > _APART else 0
