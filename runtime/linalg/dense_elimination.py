"""Eliminations of small dense matrices: LU, full pivoting, rows.

LU factors of a small dense matrix by Gaussian elimination with row pivoting, in compiled code.

A matrix of order f is one flat array, row after row. The orders are those of mechanisms' degrees of
freedom, so nothing is blocked; nothing is allocated. (G. H. Golub and C. F. Van Loan, Matrix
Computations, section 3.4.)

Gaussian elimination with full pivoting, in compiled code, for matrices with few non-zeros.

The largest entry of a row is searched again only where an elimination step has changed the row: in
a Jacobian, whose rows have few entries, that is the case for a few of them at every step. (G. H.
Golub and C. F. Van Loan, Matrix Computations, section 3.4.)

Elimination of the constraints' Jacobian row by row, in a given order of pivots or a new one.

Rows keep their places; the pivot of each is its largest remaining entry, about the distance of the
row from those before it. In one and the same order of pivots a pivot that changes sign between two
positions announces a singular one in between: their product is the determinant but for its sign.
"""

from typing import NamedTuple

import numpy as np

from runtime.core.arrays import Integers, Matrix, Vector, f8, i8, integers, matrix, view
from runtime.core.jit import compiled, inner
from runtime.linalg.rank_policy import REDUNDANT
from runtime.linalg.vectors import largest_magnitude


@inner
def factor(a: Vector, f: int, pivots: Integers, least: float) -> int:
    """Overwrite the matrix, flat, with its factors L (unit diagonal) and U, rows exchanged.

    `pivots`, (f,), receives the row exchanged with each row: the first of the largest entries.
    Returns 0, or 1 where a pivot is no larger than `least` or not a number.
    """
    for k in range(f):
        at = k
        for i in range(k + 1, f):
            if abs(a[i * f + k]) > abs(a[at * f + k]):
                at = i
        pivots[k] = at
        if not abs(a[at * f + k]) > least:
            return 1
        if at != k:
            for j in range(f):
                a[k * f + j], a[at * f + j] = a[at * f + j], a[k * f + j]
        for i in range(k + 1, f):
            ratio = a[i * f + k] / a[k * f + k]
            a[i * f + k] = ratio
            if ratio != 0.0:
                for j in range(k + 1, f):
                    a[i * f + j] -= ratio * a[k * f + j]
    return 0


@inner
def solve(a: Vector, f: int, pivots: Integers, b: Vector) -> None:
    """Overwrite `b` with the solution of A x = b, A in the factors that `factor` left in `a`."""
    for k in range(f):
        at = pivots[k]
        if at != k:
            b[k], b[at] = b[at], b[k]
    for i in range(f):
        for j in range(i):
            b[i] -= a[i * f + j] * b[j]
    for i in range(f - 1, -1, -1):
        for j in range(i + 1, f):
            b[i] -= a[i * f + j] * b[j]
        b[i] /= a[i * f + i]


@inner
def equilibrate(a: Vector, b: Vector, f: int) -> int:
    """Divide each row and its right side by its largest entry; 1 where a row is empty, else 0."""
    for i in range(f):
        largest = largest_magnitude(view(a, i * f, f))
        if not largest > 0.0:
            return 1
        for j in range(f):
            a[i * f + j] /= largest
        b[i] /= largest
    return 0


@inner
def solve_equilibrated(a: Vector, b: Vector, f: int, pivots: Integers, least: float) -> int:
    """Overwrite `b` with the solution of A x = b, and `a`; 1 where a pivot is not above `least`.

    Rows are first divided by their largest entries, so that the size of a pivot alone tells whether
    a row follows from others.
    """
    if equilibrate(a, b, f) != 0 or factor(a, f, pivots, least) != 0:
        return 1
    solve(a, f, pivots, b)
    return 0


_HALF, _LOWER = 32, 2**32 - 1  # layout: bits of half an integer, and the lower half's
_TIED = 1e-9  # safety: entries that differ by no more than this part are equal


@inner
def largest_column(dense: Matrix, row: int, first: int) -> int:
    """Column of the largest entry of a row, from `first` on; of equal ones the first."""
    n = dense.shape[1]
    at, beyond = first, 0.0
    for j in range(first, n):
        # A tie goes to the first: the choice must not hang on rounding.
        if abs(dense[row, j]) > beyond:
            at, beyond = j, abs(dense[row, j]) * (1.0 + _TIED)
    return at


@inner
def eliminate_below(dense: Matrix, step: int) -> None:
    """Take multiples of row `step` from those below, and leave the ratios in its column."""
    m, n = dense.shape
    for i in range(step + 1, m):
        if dense[i, step] != 0.0:
            ratio = dense[i, step] / dense[step, step]
            dense[i, step] = ratio
            for j in range(step + 1, n):
                dense[i, j] -= ratio * dense[step, j]


@compiled(i8(matrix, integers, integers, f8))
def factor_fully(dense: Matrix, row_order: Integers, column_order: Integers, least: float) -> int:
    """Eliminate with full pivoting until no pivot is larger than `least`; count the pivots.

    `dense`, (m, n), is overwritten: rows and columns in the order of pivots; U on the diagonal and
    right of it, L below; behind the pivots the part that is left. `row_order`, (m,), and
    `column_order`, (n,), receive rows and columns in the order of pivots, then the others.
    """
    m, n = dense.shape
    for j in range(n):
        column_order[j] = j
    # Until the end a row's place holds its number and, above it, the column of its largest entry.
    for i in range(m):
        row_order[i] = i | largest_column(dense, i, 0) << _HALF
    rank = min(m, n)
    for step in range(min(m, n)):
        pivot, at_row = 0.0, step
        for i in range(step, m):
            largest = abs(dense[i, row_order[i] >> _HALF])
            if largest > pivot * (1.0 + _TIED):
                pivot, at_row = largest, i
        if not pivot > least:
            rank = step
            break
        at_column = row_order[at_row] >> _HALF
        if at_row != step:
            for j in range(n):
                dense[step, j], dense[at_row, j] = dense[at_row, j], dense[step, j]
            row_order[step], row_order[at_row] = row_order[at_row], row_order[step]
        if at_column != step:
            for i in range(m):
                dense[i, step], dense[i, at_column] = dense[i, at_column], dense[i, step]
            taken = column_order[at_column]
            column_order[at_column] = column_order[step]
            column_order[step] = taken
        eliminate_below(dense, step)
        for i in range(step + 1, m):
            # The column that was exchanged stands further back now.
            if dense[i, step] != 0.0 or row_order[i] >> _HALF == step:
                row_order[i] &= _LOWER
                row_order[i] |= largest_column(dense, i, step + 1) << _HALF
    for i in range(m):
        row_order[i] &= _LOWER
    return int(rank)


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
def fill_unit_rows(
    sparse: Sparse, scale: Vector, shortest: Vector, dense: Matrix, inverse: Vector
) -> None:
    """Write Φ_q, (m, n), columns times `scale`, rows times `inverse`, (m,): of unit length.

    Rows shorter than `shortest`, (m,), are divided by that.
    """
    rows, columns, values = sparse.rows, sparse.columns, sparse.values
    fill_dense(sparse, scale, dense)
    inverse[:] = 0.0
    for k in range(rows.size):
        inverse[rows[k]] += (values[k] * scale[columns[k]]) ** 2
    for i in range(inverse.size):
        inverse[i] = max(np.sqrt(inverse[i]), shortest[i])
        inverse[i] = 1.0 / inverse[i] if inverse[i] > 0.0 else 1.0
    for k in range(rows.size):
        dense[rows[k], columns[k]] *= inverse[rows[k]]


@inner
def eliminate_rows(dense: Matrix, order: Integers, pivots: Vector, search: int) -> None:
    """Eliminate row by row; `order` holds the column of each row's pivot, chosen if `search`."""
    m, n = dense.shape
    for i in range(m):
        if search != 0:
            column, largest = 0, abs(dense[i, 0])
            for j in range(1, n):
                if abs(dense[i, j]) > largest:
                    column, largest = j, abs(dense[i, j])
            order[i] = column
        column = order[i]
        pivot = dense[i, column]
        pivots[i] = pivot
        if abs(pivot) <= REDUNDANT:
            continue
        for k in range(i + 1, m):
            if dense[k, column] != 0.0:
                ratio = dense[k, column] / pivot
                for j in range(n):
                    less = dense[k, j] - ratio * dense[i, j]  # no branch: many at once
                    dense[k, j] = less if dense[i, j] != 0.0 else dense[k, j]


@inner
def smallest_pivot(pivots: Vector) -> float:
    """The smallest |pivot|, at most 1, of rows that are not redundant."""
    least = 1.0
    for i in range(pivots.size):
        if REDUNDANT < abs(pivots[i]) < least:
            least = abs(pivots[i])
    return least
