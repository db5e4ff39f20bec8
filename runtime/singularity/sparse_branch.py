"""The branch nearest to a motion at a singular position of a large machine, and how it is passed.

As `nearest_branch`, in null vectors N that are sparse and not orthogonal:
the least step δ with S δ = r, least in |N δ|, solves (NᵀN, Sᵀ; S, 0) (δ; μ) = (0; r), which is
sparse too. (Å. Björck, Numerical Methods for Least Squares Problems, 1996, section 2.7.)
"""

from typing import Any

import numpy as np
from scipy.sparse.linalg import splu

from runtime.core.array_types import Vector
from runtime.linalg.bordered_matrix import bordered_matrix
from runtime.singularity.singular_root_search import Passage, Root
from runtime.singularity.sparse_complement import SparseJacobian
from runtime.singularity.sparse_forms import difference

_ITERATIONS = 40  # safety: Newton iterations
_CONVERGED = 1e-12  # accuracy: a step over the length of the direction that is the last
_REGULAR = 1e-13  # accuracy: of the largest: squared singular values below this determine nothing
_INVERSE = 300  # safety: steps of inverse iteration
_SETTLED = 1e-8  # accuracy: relative change of the squared singular value at the last one
_COLUMNS = 64  # layout: right sides that are solved for at once


def nearest_passage(jacobian: SparseJacobian, root: Root, rate: Vector) -> Passage:
    """How a motion at the rate dz/ds, (n + 1,), passes a root, and the branch nearest to it."""
    left: Any = root.left
    null: Any = root.null
    weak, free = left.shape[1], null.shape[1]
    of_left, of_null = (left.T @ left).tocsc(), (null.T @ null).tocsc()
    start = splu(of_null, permc_spec="MMD_AT_PLUS_A").solve(null.T @ rate)
    x, weakest, direction = start, 0.0, np.zeros(free)
    for iteration in range(_ITERATIONS):
        slopes = left.T @ jacobian.matrix(difference(jacobian, root.z, null @ x)) @ null
        largest = float(slopes.multiply(slopes).sum(axis=1).max()) or 1.0
        whole = bordered_matrix(of_null, slopes, -_REGULAR * largest * of_left)
        factors = splu(whole, permc_spec="MMD_AT_PLUS_A")
        if iteration == 0:
            weakest, direction = _least_singular_value(factors, of_left, of_null)
        step = factors.solve(np.concatenate([np.zeros(free), -0.5 * (slopes @ x)]))[:free]
        x = x + step
        if not step @ (of_null @ step) >= _CONVERGED**2 * (x @ (of_null @ x)):
            break
    along = null @ direction
    veer: Vector = (null @ (x - start))[:-1]
    return Passage(veer, weakest, along[:-1], weak, shares(left, of_left))


def _least_singular_value(factors: Any, of_left: Any, of_null: Any) -> tuple[float, Vector]:
    """The least singular value between orthonormal vectors, and its right vector, (free,)."""
    weak, free = of_left.shape[0], of_null.shape[0]
    u = np.random.default_rng(0).normal(size=weak)
    square, x = np.inf, np.zeros(free)
    for _ in range(_INVERSE):
        right = of_left @ u
        both = factors.solve(np.concatenate([np.zeros(free), right / np.sqrt(u @ right)]))
        x, u = both[:free], both[free:]
        before, square = square, float(x @ (of_null @ x)) / float(u @ (of_left @ u))
        if abs(square - before) <= _SETTLED * square:
            break
    return float(np.sqrt(square)), x


def shares(left: Any, of_left: Any) -> Vector:
    """Lengths of the rows, (m',), of the left vectors made orthonormal; `of_left` their products.

    Raises RuntimeError where they depend on each other.
    """
    found, factors = np.zeros(left.shape[0]), splu(of_left, permc_spec="MMD_AT_PLUS_A")
    filled = np.flatnonzero(np.diff(left.indptr))
    for k in range(0, filled.size, _COLUMNS):
        rows = left[filled[k : k + _COLUMNS]]
        solved = factors.solve(rows.T.toarray())
        found[filled[k : k + _COLUMNS]] = np.sqrt(np.asarray(rows.multiply(solved.T).sum(axis=1)))
    return found
