"""Gaussian elimination with full pivoting, in compiled code, for matrices with few non-zeros.

The largest entry of a row is searched again only where an elimination step has changed the row: in
a Jacobian, whose rows have few entries, that is the case for a few of them at every step. (G. H.
Golub and C. F. Van Loan, Matrix Computations, section 3.4.)
"""

from runtime.core.array_types import Integers, Matrix, f8, i8, integers, matrix
from runtime.core.jit import compiled, inner

_TIED = 1e-9  # safety: entries that differ by no more than this part are equal


@inner
def largest_column(dense: Matrix, row: int, first: int) -> int:
    """Column of the largest entry of a row, from `first` on; of equal ones the first."""
    n = dense.shape[1]
    at, largest = first, 0.0
    for j in range(first, n):
        # A tie goes to the first: the choice must not hang on rounding.
        if abs(dense[row, j]) > largest * (1.0 + _TIED):
            at, largest = j, abs(dense[row, j])
    return at


@inner
def eliminate_below(dense: Matrix, step: int) -> None:
    """Take multiples of row `step` from those below, and leave the ratios in its column."""
    m, n = dense.shape
    for i in range(step + 1, m):
        ratio = dense[i, step] / dense[step, step]
        dense[i, step] = ratio
        if ratio != 0.0:
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
    # Until the end a row's place holds its number and, times m, the column of its largest entry.
    for i in range(m):
        row_order[i] = i + m * largest_column(dense, i, 0)
    rank = min(m, n)
    for step in range(min(m, n)):
        pivot, at_row = 0.0, step
        for i in range(step, m):
            largest = abs(dense[i, row_order[i] // m])
            if largest > pivot * (1.0 + _TIED):
                pivot, at_row = largest, i
        if not pivot > least:
            rank = step
            break
        at_column = row_order[at_row] // m
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
            if dense[i, step] != 0.0 or row_order[i] // m == step:
                row_order[i] = row_order[i] % m + m * largest_column(dense, i, step + 1)
    for i in range(m):
        row_order[i] %= m
    return int(rank)
