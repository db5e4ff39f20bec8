"""Sparse linear algebra of a large machine before it is compiled: least norms, left null vectors.

Both come from the quasidefinite matrix [[α I, Aᵀ], [A, -δ I]], whose factors have few non-zeros
where A has. (R. J. Vanderbei, Symmetric quasidefinite matrices, SIAM Journal on Optimization 5,
1995.)
"""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

SPARSE_FROM = 300  # measured: coordinates, from which on the Jacobian is no dense matrix
_DAMPING = 1e-12  # accuracy: δ of least norms, over the largest squared length of a row
_REFINEMENTS = 6  # safety: further steps of least norm from the residual
_SMALL = 1e-6  # accuracy: α of null vectors; singular values of 1e-8 stand out from δ
_NULL = 1e-14  # accuracy: δ of null vectors, near the rounding of rows of length 1
_ITERATIONS = 3  # measured: of inverse iteration, each of which gains four digits or more
_BLOCK = 4  # measured: null vectors that are sought at first


def least_norm(matrix: Any, right: Array) -> Array:
    """The x of least norm, (n,), among those of the least residual of a sparse A x = `right`."""
    largest = float(matrix.multiply(matrix).sum(axis=1).max(initial=0.0)) if right.size else 0.0
    factors, n = _factors(matrix, 1.0, _DAMPING * (largest or 1.0)), matrix.shape[1]
    x, left = np.zeros(n), right
    for _ in range(1 + _REFINEMENTS):
        step = factors.solve(np.concatenate([np.zeros(n), left]))[:n]
        rest = left - matrix @ step
        if not float(rest @ rest) < float(left @ left):
            break
        x, left = x + step, rest
    return x


def dependent_rows(matrix: Any, tolerance: float) -> list[int]:
    """Rows of a sparse matrix, (m, n), that follow from earlier ones, to a tolerance.

    Each is the last row of a left null vector, as the rows are scaled to length 1.
    """
    from scipy.sparse import diags_array

    m, n = matrix.shape
    lengths = np.sqrt(matrix.multiply(matrix).sum(axis=1))
    scaled = (diags_array(1.0 / np.maximum(lengths, 1e-300)) @ matrix).tocsr()  # safety: zeros
    factors, random = _factors(scaled, _SMALL, _NULL), np.random.default_rng(0)
    count = min(_BLOCK, m)
    while True:
        vectors = np.linalg.qr(random.standard_normal((m, count)))[0]
        for _ in range(_ITERATIONS):
            right = np.vstack([np.zeros((n, count)), vectors])
            vectors = np.linalg.qr(factors.solve(right)[n:])[0]
        sizes, turned = np.linalg.svd(scaled.T @ vectors, full_matrices=False)[1:]
        null = vectors @ turned[sizes <= tolerance].T
        if null.shape[1] < count or count == m:
            return _last_rows(null)
        count = min(2 * count, m)


def _factors(matrix: Any, first: float, second: float) -> Any:
    from scipy.sparse import block_array, eye_array
    from scipy.sparse.linalg import splu

    m, n = matrix.shape
    whole = [[first * eye_array(n), matrix.T], [matrix, -second * eye_array(m)]]
    return splu(block_array(whole, format="csc"), permc_spec="COLAMD")


def _last_rows(null: Array) -> list[int]:
    """The last rows of vectors, (m, d), that are independent of later ones; in order."""
    rest, found = null.copy(), []
    for row in range(len(rest) - 1, -1, -1):
        if rest.shape[1] == 0:
            break
        size = float(np.linalg.norm(rest[row]))
        if size > _SMALL:  # an orthogonal change of the vectors leaves one with an entry here
            basis = np.linalg.qr(np.column_stack([rest[row], np.eye(rest.shape[1])]))[0]
            rest = (rest @ basis)[:, 1:]
            found.append(row)
    return found[::-1]
