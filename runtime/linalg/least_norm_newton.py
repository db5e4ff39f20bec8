"""Newton's method for equations and unknowns of any number, by steps of least norm."""

from collections.abc import Callable
from typing import Any

import numpy as np

from runtime.core.array_types import Matrix, Vector
from runtime.core.unit_roundoff import EPS
from runtime.linalg.rank_policy import NO_PIVOT

ROUNDING = 2.0 * EPS  # accuracy: a residual that no step makes smaller, of equations of size 1
ITERATIONS = 60  # safety: Newton iterations


def least_norm_solver(matrix: Matrix | Any) -> Callable[[Vector], Any]:
    """The function that solves A x = b, (m,), with x, (n,), of least norm, for several b.

    `matrix`, (m, n), is dense, or SciPy's sparse one.
    """
    if isinstance(matrix, np.ndarray):
        return lambda right: np.linalg.lstsq(matrix, right, rcond=NO_PIVOT)[0]
    from runtime.linalg.sparse_least_norm import LeastNorm

    return LeastNorm(matrix).solve


def solve_by_newton(
    residual: Callable[[Vector], Vector],
    jacobian: Callable[[Vector], Matrix | Any],
    x: Vector,
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
        trial = x + least_norm_solver(jacobian(x))(-residual(x))
        largest = float(np.abs(residual(trial)).max(initial=0.0))
        if not largest < best:
            break
        slow = largest > 0.9 * best
        x, best = trial, largest
        if slow:
            break
    return x, best
