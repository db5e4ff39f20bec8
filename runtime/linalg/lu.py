"""Dense linear equations inside compiled code: LU factors by rows, pivots from the column.

A matrix of order f is one flat array, row after row. The orders are those of mechanisms' degrees of
freedom, so nothing is blocked; nothing is allocated.
"""

from runtime.core.jit import inner
from runtime.core.signatures import Integers, Vector


@inner
def factor(a: Vector, f: int, pivots: Integers) -> int:
    """Overwrite the matrix with its factors L (unit diagonal) and U, rows exchanged.

    Parameters
    ----------
    a : (f f,) float64
        The matrix, row after row.
    pivots : (f,) int64
        Out: the row exchanged with each row.

    Returns
    -------
    int
        0, or 1 where a pivot is zero or not a number.
    """
    for k in range(f):
        at = k
        for i in range(k + 1, f):
            if abs(a[i * f + k]) > abs(a[at * f + k]):
                at = i
        pivots[k] = at
        pivot = a[at * f + k]
        if not abs(pivot) > 0.0:
            return 1
        if at != k:
            for j in range(f):
                a[k * f + j], a[at * f + j] = a[at * f + j], a[k * f + j]
        for i in range(k + 1, f):
            share = a[i * f + k] / pivot
            a[i * f + k] = share
            if share != 0.0:
                for j in range(k + 1, f):
                    a[i * f + j] -= share * a[k * f + j]
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
