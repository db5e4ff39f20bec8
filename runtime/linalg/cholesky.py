"""Cholesky factors of small normal equations, and orthonormal columns by them, in compiled code.

Vectors are columns of a matrix (count, width) with width ≪ count. (G. H. Golub and C. F. Van Loan,
Matrix Computations, sections 4.2 and 5.2.)
"""

from runtime.core.array_types import Matrix, Vector
from runtime.core.jit import inner


@inner
def multiply_gram(vectors: Matrix, out: Matrix) -> None:
    """Products of all pairs of columns, VᵀV: the lower half of `out`."""
    count, width = vectors.shape
    for i in range(width):
        for j in range(i + 1):
            out[i, j] = 0.0
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
def solve_cholesky(factor: Matrix, x: Vector) -> None:
    """Overwrite x with the solution y of L Lᵀ y = x."""
    size = x.size
    for i in range(size):
        for j in range(i):
            x[i] -= factor[i, j] * x[j]
        x[i] /= factor[i, i]
    for i in range(size - 1, -1, -1):
        x[i] /= factor[i, i]
        for j in range(i):
            x[j] -= factor[i, j] * x[i]


@inner
def orthonormalise(factor: Matrix, vectors: Matrix) -> None:
    """Make columns V orthonormal, V L⁻ᵀ, with the Cholesky factor L of VᵀV."""
    count, width = vectors.shape
    for s in range(count):
        for i in range(width):
            total = vectors[s, i]
            for j in range(i):
                total -= factor[i, j] * vectors[s, j]
            vectors[s, i] = total / factor[i, i]
