"""Solutions of least norm of large sparse systems, and their smallest singular value.

A x = b, (m, n), is solved by the quasidefinite matrix [[I, Aᵀ], [A, -ε I]]: x = Aᵀ (A Aᵀ + ε I)⁻¹ b
is Tikhonov's solution, and the residuals of a few more such steps take the effect of ε away where
A has no singular value below √ε. Its factors have few non-zeros where A has, also where a body has
many joints and A Aᵀ is dense. (R. J. Vanderbei, Symmetric quasidefinite matrices, SIAM Journal on
Optimization 5, 1995; P. C. Hansen, Rank-Deficient and Discrete Ill-Posed Problems, 1998, 5.1.)
"""

from typing import Any

import numpy as np

from runtime.core.array_types import Vector
from runtime.linalg.bordered_matrix import bordered_matrix

SPARSE_FROM = 300
"""measured: coordinates from which on sparse factors are used in place of dense ones, which take
0.09 s a solution there (`numpy.linalg.lstsq`, a chain of 100 bars), sparse ones 0.004 s; at 90
coordinates both take about a millisecond."""

_DAMPING = 1e-12  # accuracy: ε, over the largest squared length of a row; √ε as `LOST`
_REFINEMENTS = 6  # safety: further steps from the residual
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
