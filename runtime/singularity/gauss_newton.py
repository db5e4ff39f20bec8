"""Gauss-Newton iteration for a singular position, in compiled code.

The unknown is z. The equations are the values of the strong rows and all entries of the Schur
complement of the weak ones, which vanish together (see `location`). (P. Deuflhard, Newton Methods
for Nonlinear Problems, section 4.3.)
"""

import numpy as np

from runtime.core.array_types import Integers, Matrix, Vector, f8, integers, matrix, vector
from runtime.core.jit import compiled
from runtime.linalg.cholesky import orthonormalise, solve_cholesky
from runtime.linalg.leading_block import complete_solution
from runtime.singularity.complement_derivative import factor_normal_equations
from runtime.singularity.schur_complement import (
    eliminate_strong_rows,
    find_vectors,
    largest_lost_gap,
    normalise_complement,
)
from runtime.singularity.search_table import (
    ROWS,
    UNKNOWNS,
    column_order_of,
    origin_of,
    residuals_of,
    step_of,
)

_ITERATIONS = 40  # safety: Newton iterations
_KEEP = 5  # measured: iterations with the same second derivatives, but for the first one's
_CONVERGED = 1e-12  # accuracy: a step over 1 + |z| that is the last
_FAR = 0.5  # safety: of a coordinate's size: a root so far from where the search began is another
_FLAT = 1e-6  # accuracy: the largest entry of the complement at a singular position


@compiled(f8(integers, f8, vector, matrix, matrix, matrix, matrix, matrix, matrix, matrix, vector))
def find_root(
    context: Integers,
    speed: float,
    z: Vector,
    a: Matrix,
    left: Matrix,
    null: Matrix,
    sums: Matrix,
    form: Matrix,
    normal: Matrix,
    square: Matrix,
    x: Vector,
) -> float:
    """Bring z to a position in which as many rows are lost as `left` has columns.

    Parameters
    ----------
    z : (n + 1,)
        Where to begin; overwritten.
    left, null : (rows, weak), (n + 1, free)
        Out: orthonormal left vectors and null vectors there.
    a, sums, form, normal, square, x : (rows, n + 1), (n + 1, weak), (weak free, free), \
    (free, free), (weak, weak), (free,)
        Workspace.

    Returns
    -------
    float
        The largest |uᵀ Φ|, or -1 where there is no such position.
    """
    rows, wide = context[ROWS], context[UNKNOWNS]
    weak, free = left.shape[1], null.shape[1]
    strong = rows - weak
    order, origin = column_order_of(context), origin_of(context)
    step, gaps = step_of(context), residuals_of(context)
    for j in range(wide):
        origin[j] = z[j]
    for iteration in range(_ITERATIONS):
        if not eliminate_strong_rows(context, speed, z, strong, a, gaps):
            return -1.0
        if iteration % _KEEP == 0 or iteration == 1:
            find_vectors(context, a, strong, left, null)
            if not factor_normal_equations(context, speed, z, left, null, step, sums, form, normal):
                return -1.0
        for f in range(free):
            x[f] = 0.0
        for w in range(weak):
            for g in range(free):
                for f in range(free):
                    x[f] += form[w * free + g, f] * a[strong + w, strong + g]
        solve_cholesky(normal, x)
        for f in range(free):
            step[strong + f] = x[f]
        complete_solution(a, strong, gaps, step)
        moved, size, away = 0.0, 0.0, 0.0
        for s in range(wide):
            j = order[s]
            z[j] -= step[s]
            moved += step[s] ** 2
            size += z[j] ** 2
            away = max(away, abs(z[j] - origin[j]))
        if not (away < _FAR and moved < np.inf):
            return -1.0
        if moved < (_CONVERGED * (1.0 + np.sqrt(size))) ** 2:
            break
    if not eliminate_strong_rows(context, speed, z, strong, a, gaps):
        return -1.0
    find_vectors(context, a, strong, left, null)
    if not normalise_complement(a, strong, left, null, square, normal):
        return -1.0
    for i in range(strong, rows):
        for j in range(strong, wide):
            if not abs(a[i, j]) <= _FLAT:
                return -1.0
    orthonormalise(normal, null)
    orthonormalise(square, left)
    return largest_lost_gap(gaps, strong, square)
