"""Rows of a small matrix as a triangle times orthonormal rows, A = L Q, in compiled code.

Each row is reduced against those before it, twice against loss of orthogonality. (G. H. Golub and
C. F. Van Loan, Matrix Computations, section 5.2.)
"""

from math import sqrt

import numpy as np

from runtime.core.array_types import Matrix, Vector
from runtime.core.jit import inner
from runtime.linalg.vectors import axpy, dot


@inner
def factor_rows(a: Matrix, width: int, lower: Matrix, least: float) -> bool:
    """Overwrite rows, of `width` numbers, by Q, and `lower` by L; false where a row follows.

    That is one of which no more than the part `least` is left, or that is not finite.
    """
    m = a.shape[0]
    for i in range(m):
        row = a[i, :width]
        length = sqrt(dot(row, row))
        lower[i, :] = 0.0
        for _ in range(2):
            for j in range(i):
                share = dot(a[j, :width], row)
                lower[i, j] += share
                axpy(-share, a[j, :width], row)
        rest = sqrt(dot(row, row))
        if not (rest > least * length and np.isfinite(length)):
            return False
        lower[i, i] = rest
        for k in range(width):
            row[k] /= rest
    return True


@inner
def solve_least_norm(a: Matrix, width: int, lower: Matrix, right: Vector, x: Vector) -> None:
    """Write the least x, (width,), with A x = b; b, (m,), is overwritten by L⁻¹ b."""
    x[:width] = 0.0
    for i in range(a.shape[0]):
        for j in range(i):
            right[i] -= lower[i, j] * right[j]
        right[i] /= lower[i, i]
        axpy(right[i], a[i, :width], x[:width])


@inner
def bound_singular_value(lower: Matrix, column: Vector) -> float:
    """A number that no singular value of A falls below: 1 / ‖L⁻¹‖, in the norm of Frobenius."""
    m, total = lower.shape[0], 0.0
    for k in range(m):
        for i in range(k, m):
            rest = 1.0 if i == k else 0.0
            for j in range(k, i):
                rest -= lower[i, j] * column[j]
            column[i] = rest / lower[i, i]
            total += column[i] ** 2
    return 1.0 / sqrt(total) if total > 0.0 else 1.0
