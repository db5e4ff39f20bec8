"""Changes of least norm that satisfy equations, dense and sparse, and Newton's method with them.

Symmetric sparse matrices in two by two blocks, [[A, Bᵀ], [B, C]].

Solutions of least norm of large sparse systems, and their smallest singular value.

A x = b, (m, n), is solved by the quasidefinite matrix [[I, Aᵀ], [A, -ε I]]: x = Aᵀ (A Aᵀ + ε I)⁻¹ b
is Tikhonov's solution, and the residuals of a few more such steps take the effect of ε away where
A has no singular value below √ε. Its factors have few non-zeros where A has, also where a body has
many joints and A Aᵀ is dense. (R. J. Vanderbei, Symmetric quasidefinite matrices, SIAM Journal on
Optimization 5, 1995; P. C. Hansen, Rank-Deficient and Discrete Ill-Posed Problems, 1998, 5.1.)

Newton's method for equations and unknowns of any number, by steps of least norm.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from runtime.core.arrays import EPS, Matrix, Vector
from runtime.linalg.rank_policy import NO_PIVOT


def bordered_matrix(a: Any, b: Any, c: Any) -> Any:
    """The matrix by columns, of A, (n, n), B, (m, n), and C, (m, m).

    In half of the time of `scipy.sparse.block_array`, of which a passage takes hundreds.
    """
    from scipy.sparse import csc_matrix  # small machines load none of it

    (a_rows, a_columns, a_data), (b_rows, b_columns, b_data), (c_rows, c_columns, c_data) = map(
        _entries, (a, b, c)
    )
    m, n = b.shape
    data = np.concatenate([a_data, b_data, b_data, c_data])
    rows = np.concatenate([a_rows, b_rows + n, b_columns, c_rows + n])
    columns = np.concatenate([a_columns, b_columns, b_rows + n, c_columns + n])
    return csc_matrix((data, (rows, columns)), shape=(n + m, n + m))


def _entries(matrix: Any) -> tuple[Any, Any, Any]:
    """Rows, columns and values of the entries."""
    by_columns = matrix.tocsc()
    counts = np.diff(by_columns.indptr)
    return by_columns.indices, np.repeat(np.arange(len(counts)), counts), by_columns.data


SPARSE_FROM = 300
"""measured: coordinates from which on sparse factors are used in place of dense ones, which take
0.09 s a solution there (`numpy.linalg.lstsq`, a chain of 100 bars), sparse ones 0.004 s; at 90
coordinates both take about a millisecond."""

_DAMPING = 1e-12  # accuracy: ε, over the largest squared length of a row; √ε as `LOST`
_REFINEMENTS = 6  # safety: steps of refinement by the residual
_GAIN = 0.5  # measured: a step that leaves more of the residual is the last
_ITERATIONS = 30  # safety: steps of inverse iteration
_SETTLED = 0.01  # measured: relative change of the singular value at the last one


class LeastNorm:
    """Solutions of least norm of one sparse matrix A, (m, n), of which `factors` counts entries."""

    def __init__(self, matrix: Any) -> None:
        from scipy.sparse import identity  # small machines load none of it
        from scipy.sparse.linalg import splu

        self.matrix = matrix.tocsr()
        self.transpose = self.matrix.T.tocsr()
        m, self.n = self.matrix.shape
        largest = float(self.matrix.multiply(self.matrix).sum(axis=1).max()) if m else 0.0
        damping = _DAMPING * (largest or 1.0)
        whole = bordered_matrix(identity(self.n), self.matrix, -damping * identity(m))
        self.lu = splu(whole, permc_spec="MMD_AT_PLUS_A")
        self.factors = int(self.lu.nnz)

    def _step(self, right: Vector) -> Vector:
        both: Vector = self.lu.solve(np.concatenate([np.zeros(self.n), right]))
        return both

    def solve(self, right: Vector) -> Vector:
        """The x of least norm, (n,), among those of the least residual A x - `right`, (m,)."""
        x = self._step(right)[: self.n]
        left = right - self.matrix @ x
        for _ in range(_REFINEMENTS):
            step = self._step(left)[: self.n]
            rest = left - self.matrix @ step
            size, before = float(rest @ rest), float(left @ left)
            if not size < before:
                break
            x, left = x + step, rest
            if size > _GAIN**2 * before:
                break
        return x

    def least_singular_value(self) -> float:
        """The smallest singular value of A, of m ≤ n rows, to a percent; never below it."""
        m = len(self.matrix.indptr) - 1
        if m == 0:
            return float(np.inf)
        u = np.random.default_rng(0).normal(size=m)
        least = float(np.inf)
        for _ in range(_ITERATIONS):
            u = self._step(u / np.linalg.norm(u))[self.n :]
            value = float(np.linalg.norm(self.transpose @ (u / np.linalg.norm(u))))
            settled = abs(value - least) <= _SETTLED * value
            least = min(least, value)
            if settled:
                break
        return least


ROUNDING = 2.0 * EPS  # accuracy: a residual that no step makes smaller, of equations of size 1
ITERATIONS = 60  # safety: Newton iterations


def least_norm_solver(matrix: Matrix | Any) -> Callable[[Vector], Any]:
    """The function that solves A x = b, (m,), with x, (n,), of least norm, for several b.

    `matrix`, (m, n), is dense, or SciPy's sparse one.
    """
    if isinstance(matrix, np.ndarray):
        return lambda right: np.linalg.lstsq(matrix, right, rcond=NO_PIVOT)[0]
    from runtime.linalg.least_norm import LeastNorm

    return LeastNorm(matrix).solve


def solve_by_newton(
    residual: Callable[[Vector], Vector], jacobian: Callable[[Vector], Matrix | Any], x: Vector
) -> tuple[Vector, float]:
    """Bring the residual to rounding by steps of least norm, or go on for as long as they help.

    `residual`, (m,), are the scaled equations, `jacobian` their derivatives by x, (m, n), dense or
    sparse. Returns the best point from `x`, (n,), on and the largest residual there; the caller
    decides what counts as solved.
    """
    best = float(np.abs(residual(x)).max(initial=0.0))
    for _ in range(ITERATIONS):
        if best <= ROUNDING:
            break
        matrix = jacobian(x)
        if not np.isfinite(matrix if isinstance(matrix, np.ndarray) else matrix.data).all():
            break
        trial = x + least_norm_solver(matrix)(-residual(x))
        largest = float(np.abs(residual(trial)).max(initial=0.0))
        if not largest < best:
            break
        slow = largest > 0.9 * best
        x, best = trial, largest
        if slow:
            break
    return x, best
