"""LU factors of a small dense matrix by Gaussian elimination with row pivoting, in compiled code.

A matrix of order f is one flat array, row after row. The orders are those of mechanisms' degrees of
freedom, so nothing is blocked; nothing is allocated. (G. H. Golub and C. F. Van Loan, Matrix
Computations, section 3.4.)
"""

from runtime.core.array_types import Integers, Vector
from runtime.core.jit import inner
from runtime.core.unowned_array_views import view
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
