"""Derivative of the Schur complement, and the branch nearest to a motion, in compiled code.

In a direction d it is uᵀ J'(d) z between the left vectors u and the null vectors z (see
`schur_complement`); J'(d) is the central difference of two Jacobians.
"""

import numpy as np

from runtime.core.array_types import Integers, Matrix, Vector, f8, i8, integers, matrix, vector
from runtime.core.array_views import view
from runtime.core.jit import compiled, inner
from runtime.linalg.cholesky import factor_cholesky, multiply_gram, solve_cholesky
from runtime.singularity.search_table import (
    ROWS,
    UNKNOWNS,
    ahead_of,
    behind_of,
    displaced_of,
    entry_columns_of,
    entry_rows_of,
    jacobian_entries,
    lengths_of,
    residuals_of,
    step_of,
)

_ITERATIONS = 40  # safety: Newton iterations
_CONVERGED = 1e-12  # accuracy: a step over the length of the direction that is the last
_DIFFERENCE = 6e-6  # accuracy: EPS ** (1/3), the relative size of a central difference
_REGULAR = 1e-13  # accuracy: of the largest: squared singular values below this determine nothing


@inner
def differentiate_left(
    context: Integers, speed: float, z: Vector, direction: Vector, left: Matrix, sums: Matrix
) -> None:
    """Fill `sums`, (n + 1, weak), with uᵀ J'(direction) at z for all left vectors."""
    rows, wide, weak = context[ROWS], context[UNKNOWNS], left.shape[1]
    ahead, behind = ahead_of(context), behind_of(context)
    at_row, at_column = entry_rows_of(context), entry_columns_of(context)
    lengths, displaced = lengths_of(context), displaced_of(context)
    total = 0.0
    for j in range(wide):
        total += direction[j] ** 2
    delta = _DIFFERENCE / max(np.sqrt(total), 1e-300)
    for j in range(wide):
        displaced[j] = z[j] + delta * direction[j]
    jacobian_entries(context, speed, displaced, ahead)
    for j in range(wide):
        displaced[j] = z[j] - delta * direction[j]
    jacobian_entries(context, speed, displaced, behind)
    for j in range(wide):
        for w in range(weak):
            sums[j, w] = 0.0
    for e in range(ahead.size):
        i, j = at_row[e], at_column[e]
        if i < rows and ahead[e] != behind[e]:
            slope = (ahead[e] - behind[e]) / (2.0 * delta * lengths[i])
            for w in range(weak):
                sums[j, w] += slope * left[i, w]


@inner
def apply_to_null(sums: Matrix, null: Matrix, first: int, every: int, out: Matrix) -> None:
    """Fill rows `first`, `first` + `every`, … of `out` with uᵀ J' z, one left vector u each."""
    wide, free = null.shape
    weak = sums.shape[1]
    for w in range(weak):
        for f in range(free):
            out[first + w * every, f] = 0.0
    for j in range(wide):
        for w in range(weak):
            if sums[j, w] != 0.0:
                for f in range(free):
                    out[first + w * every, f] += sums[j, w] * null[j, f]


@inner
def factor_normal_equations(
    context: Integers,
    speed: float,
    z: Vector,
    left: Matrix,
    null: Matrix,
    direction: Vector,
    sums: Matrix,
    form: Matrix,
    normal: Matrix,
) -> bool:
    """Fill `form`, (weak free, free), with the complement's derivatives, and factor formᵀ form.

    The factor is `normal`. Directions that the derivatives do not determine are kept short in z.
    Returns whether there are any derivatives.
    """
    wide, free = null.shape
    for g in range(free):
        for j in range(wide):
            direction[j] = null[j, g]
        differentiate_left(context, speed, z, direction, left, sums)
        apply_to_null(sums, null, g, free, form)
    multiply_gram(form, normal)
    largest = 0.0
    for f in range(free):
        largest = max(largest, normal[f, f])
    if not largest > 0.0:
        return False
    for j in range(wide):
        for i in range(free):
            if null[j, i] != 0.0:
                for k in range(i + 1):
                    normal[i, k] += _REGULAR * largest * null[j, i] * null[j, k]
    return factor_cholesky(normal)


@inner
def newton_step(slopes: Matrix, square: Matrix, missed: Vector, x: Vector) -> float:
    """Take Newton's step of least norm to a root of xᵀ form x; its length over that of x.

    `slopes` is form x, (weak, free), the forms being symmetric.
    """
    weak, free = slopes.shape
    largest = 0.0
    for w in range(weak):
        missed[w] = 0.0
        for f in range(free):
            missed[w] += slopes[w, f] * x[f]
        for k in range(w + 1):
            total = 0.0
            for f in range(free):
                total += slopes[w, f] * slopes[k, f]
            square[w, k] = total
        largest = max(largest, square[w, w])
    for w in range(weak):
        square[w, w] += _REGULAR * largest
    if not factor_cholesky(square):
        return 0.0
    solve_cholesky(square, missed)
    moved, size = 0.0, 0.0
    for f in range(free):
        step = 0.0
        for w in range(weak):
            step -= 0.5 * slopes[w, f] * missed[w]
        x[f] += step
        moved += step * step
        size += x[f] * x[f]
    return float(np.sqrt(moved / max(size, 1e-300)))


@compiled(i8(integers, f8, vector, vector, matrix, matrix, matrix, matrix, matrix, matrix, vector))
def find_branch(
    context: Integers,
    speed: float,
    z: Vector,
    rate: Vector,
    left: Matrix,
    null: Matrix,
    sums: Matrix,
    square: Matrix,
    slopes: Matrix,
    passing: Matrix,
    x: Vector,
) -> int:
    """Direction of the branch nearest to a motion, in a singular position.

    Branches have directions N x with uᵀ J'(N x) N x = 0 for all left vectors u. Newton's method
    with steps of least norm starts from the direction of the motion.

    Parameters
    ----------
    z, rate : (n + 1,)
        The position, and dz/ds of the motion.
    left, null : (rows, weak), (n + 1, free)
        Orthonormal left vectors and null vectors N.
    sums, square, slopes : (n + 1, weak), (weak, weak), (weak, free)
        Workspace.
    passing : (weak, free)
        Out: the rate of the complement along the motion.
    x : (free,)
        Out: the branch's direction less that of the motion, in terms of null vectors.

    Returns
    -------
    int
        Iterations.
    """
    wide, free = null.shape
    weak = left.shape[1]
    direction = step_of(context)
    missed = view(residuals_of(context), 0, weak)
    for f in range(free):
        x[f] = 0.0
        for j in range(wide):
            x[f] += null[j, f] * rate[j]
    done = 0
    for iteration in range(_ITERATIONS):
        for j in range(wide):
            direction[j] = 0.0
            for f in range(free):
                direction[j] += null[j, f] * x[f]
        differentiate_left(context, speed, z, direction, left, sums)
        apply_to_null(sums, null, 0, 1, slopes)
        if iteration == 0:
            for w in range(weak):
                for f in range(free):
                    passing[w, f] = slopes[w, f]
        done = iteration + 1
        if newton_step(slopes, square, missed, x) < _CONVERGED:
            break
    for f in range(free):
        for j in range(wide):
            x[f] -= null[j, f] * rate[j]
    return done
