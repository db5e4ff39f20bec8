"""Cholesky and orthogonal factors of small matrices.

Cholesky factors of small normal equations, and orthonormal columns by them, in compiled code.

Vectors are columns of a matrix (count, width) with width ≪ count. (G. H. Golub and C. F. Van Loan,
Matrix Computations, sections 4.2 and 5.2.)

Rows of a small matrix as a triangle times orthonormal rows, A = L Q, in compiled code.

Each row is reduced against those before it, twice against loss of orthogonality. (G. H. Golub and
C. F. Van Loan, Matrix Computations, section 5.2.)
"""

from math import sqrt

import numpy as np

from runtime.core.arrays import Matrix, Vector
from runtime.core.jit import inner
from runtime.linalg.vectors import axpy, dot


@inner
def multiply_gram(vectors: Matrix, out: Matrix) -> None:
    """Write the products of pairs of columns, VᵀV, to the lower half of `out`; 0 above it."""
    count, width = vectors.shape
    out[:, :] = 0.0
    for s in range(count):
        for i in range(width):
            if vectors[s, i] != 0.0:
                for j in range(i + 1):
                    out[i, j] += vectors[s, i] * vectors[s, j]


@inner
def factor_cholesky(a: Matrix) -> bool:
    """Overwrite the lower half by the factor L of A = L Lᵀ; false where it has none."""
    for i in range(a.shape[0]):
        for j in range(i + 1):
            total = a[i, j]
            for k in range(j):
                total -= a[i, k] * a[j, k]
            if i != j:
                a[i, j] = total / a[j, j]
            elif total > 0.0:
                a[i, i] = total**0.5
            else:
                return False
    return True


@inner
def solve_lower(factor: Matrix, x: Vector) -> None:
    """Overwrite x with the solution y of L y = x."""
    for i in range(x.size):
        for j in range(i):
            x[i] -= factor[i, j] * x[j]
        x[i] /= factor[i, i]


@inner
def solve_cholesky(factor: Matrix, x: Vector) -> None:
    """Overwrite x with the solution y of L Lᵀ y = x."""
    solve_lower(factor, x)
    for i in range(x.size - 1, -1, -1):
        x[i] /= factor[i, i]
        for j in range(i):
            x[j] -= factor[i, j] * x[i]


@inner
def orthonormalise(factor: Matrix, vectors: Matrix) -> None:
    """Make columns V orthonormal, V L⁻ᵀ, with the Cholesky factor L of VᵀV."""
    for s in range(vectors.shape[0]):
        solve_lower(factor, vectors[s])


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
