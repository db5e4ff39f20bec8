"""Elimination of the leading block of a matrix: Schur complement, left vectors, null vectors.

The matrix A stands in the order of its pivots: those of the first r rows are on the diagonal. Their
elimination leaves U in the first rows, L below the diagonal, and behind both the Schur complement
of the leading block. Left vectors u take A to the complement, uᵀ A = (0, complement), with 1 in one
of the rows behind; null vectors z, which the first rows take to zero, have 1 in one of the columns
behind. (G. H. Golub and C. F. Van Loan, Matrix Computations, section 3.2.)
"""

from runtime.core.arrays import Integers, Matrix, Vector
from runtime.core.jit import inner

_ROUNDING = 1e-14  # safety: of vectors with a component 1, below which it is 0, to keep them sparse


@inner
def eliminate_leading(a: Matrix, r: int, right: Vector, least: float) -> bool:
    """Eliminate the leading block of order r from A and from the right side.

    `a`, (m, n), is overwritten by the factors and the Schur complement, `right`, (m,), by L⁻¹ times
    the right side; behind r, the part that is left. False where a pivot is no larger than `least`,
    which ends the elimination.
    """
    m, n = a.shape
    for s in range(r):
        pivot = a[s, s]
        if not abs(pivot) > least:
            return False
        for i in range(s + 1, m):
            if a[i, s] != 0.0:
                ratio = a[i, s] / pivot
                a[i, s] = ratio
                for j in range(s + 1, n):
                    a[i, j] -= ratio * a[s, j]
                right[i] -= ratio * right[s]
    return True


@inner
def complete_solution(a: Matrix, r: int, right: Vector, x: Vector) -> None:
    """The first r entries of x from the others, so that U x = `right` in the first rows."""
    n = a.shape[1]
    for s in range(r - 1, -1, -1):
        total = right[s]
        for j in range(s + 1, n):
            total -= a[s, j] * x[j]
        x[s] = total / a[s, s]


@inner
def left_vectors(a: Matrix, r: int, order: Integers, u: Matrix) -> None:
    """The left vectors, (m, m - r); `order` says which row of u is where in A."""
    m, count = u.shape
    for s in range(m):
        i = order[s]
        for w in range(count):
            if s < r:
                u[i, w] = -a[r + w, s]
            else:
                u[i, w] = 1.0 if s == r + w else 0.0
    for s in range(r - 1, -1, -1):
        i = order[s]
        for w in range(count):
            if abs(u[i, w]) < _ROUNDING:
                u[i, w] = 0.0
        for k in range(s):
            ratio = a[s, k]
            if ratio != 0.0:
                for w in range(count):
                    u[order[k], w] -= ratio * u[i, w]


@inner
def null_vectors(a: Matrix, r: int, order: Integers, z: Matrix) -> None:
    """The null vectors, (n, n - r); `order` says which row of z is where in A's columns."""
    n, count = z.shape
    for s in range(r, n):
        for f in range(count):
            z[order[s], f] = 1.0 if s == r + f else 0.0
    for s in range(r - 1, -1, -1):
        i = order[s]
        for f in range(count):
            z[i, f] = a[s, r + f]
        for j in range(s + 1, r):
            ratio = a[s, j]
            if ratio != 0.0:
                for f in range(count):
                    z[i, f] += ratio * z[order[j], f]
        for f in range(count):
            z[i, f] /= -a[s, s]
            if abs(z[i, f]) < _ROUNDING:
                z[i, f] = 0.0
