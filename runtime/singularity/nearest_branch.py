"""Derivative of the Schur complement, and the branch nearest to a motion, in compiled code.

In a direction d it is uᵀ J'(d) z between the left vectors u and the null vectors z (see
`schur_complement`); J'(d) is the central difference of two Jacobians.
"""

import numpy as np

from runtime.core.array_types import Integers, Matrix, Vector, i8, integers, matrix, vector
from runtime.core.jit import allocating, inner
from runtime.core.unowned_array_views import view
from runtime.linalg.cholesky import factor_cholesky, multiply_gram, solve_cholesky
from runtime.linalg.vectors import copy_vector, dot, multiply
from runtime.singularity import search_function_table as st

_ITERATIONS = 40  # safety: Newton iterations
_CONVERGED = 1e-12  # accuracy: a step over the length of the direction that is the last
_DIFFERENCE = 6e-6  # accuracy: EPS ** (1/3), the relative size of a central difference
_REGULAR = 1e-13  # accuracy: of the largest: squared singular values below this determine nothing


@inner
def differentiate_complement(
    search: Integers, z: Vector, left: Matrix, null: Matrix, row: int, out: Matrix
) -> None:
    """Differentiate the complement at z along the direction in `step`: uᵀ J'(step) N.

    Out is (k, free) of as many left vectors u as divide k: theirs are row `row`, and the rows at
    equal distances behind it.
    """
    (wide, free), (rows, weak) = null.shape, left.shape
    ahead, behind = st.ahead_of(search), st.behind_of(search)
    at_row, at_column = st.entry_rows_of(search), st.entry_columns_of(search)
    lengths, displaced, sums = st.lengths_of(search), st.displaced_of(search), st.sums_of(search)
    direction = st.step_of(search)
    delta = _DIFFERENCE / max(np.sqrt(dot(direction, direction)), 1e-300)
    for sign, entries in ((1.0, ahead), (-1.0, behind)):
        for j in range(wide):
            displaced[j] = z[j] + sign * delta * direction[j]
        st.jacobian_entries(search, displaced, entries)
    sums[:] = 0.0
    for e in range(ahead.size):
        i, j = at_row[e], at_column[e]
        if i < rows and ahead[e] != behind[e]:
            slope = (ahead[e] - behind[e]) / (2.0 * delta * lengths[i])
            for w in range(weak):
                sums[j * weak + w] += slope * left[i, w]
    apart = out.shape[0] // weak
    for w in range(weak):
        for f in range(free):
            out[row + w * apart, f] = 0.0
        for j in range(wide):
            if sums[j * weak + w] != 0.0:
                for f in range(free):
                    out[row + w * apart, f] += sums[j * weak + w] * null[j, f]


@inner
def factor_normal_equations(
    search: Integers, z: Vector, left: Matrix, null: Matrix, form: Matrix, normal: Matrix
) -> bool:
    """Fill `form`, (weak free, free), with the complement's derivatives, and factor formᵀ form.

    The factor is `normal`. Directions that the derivatives do not determine are kept short in z.
    Returns whether there are any derivatives.
    """
    wide, free = null.shape
    direction = st.step_of(search)
    for g in range(free):
        copy_vector(null[:, g], direction)
        differentiate_complement(search, z, left, null, g, form)
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
    multiply(slopes, x, missed)
    multiply_gram(slopes.T, square)
    largest = 0.0
    for w in range(weak):
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


@allocating(i8(integers, vector, vector, matrix, matrix, matrix, vector))
def find_branch(
    search: Integers, z: Vector, rate: Vector, left: Matrix, null: Matrix, passing: Matrix,
    x: Vector,
) -> int:  # fmt: skip
    """Direction of the branch nearest to a motion, in a singular position; returns the iterations.

    Branches have directions N x with uᵀ J'(N x) N x = 0 for all left vectors u. Newton's method
    with steps of least norm starts from the direction of the motion. `z` is the position and `rate`
    dz/ds of the motion, (n + 1,); `left` (rows, weak) are orthonormal left vectors, `null` (n + 1,
    free) null vectors N. `passing` (weak, free) becomes the rate of the complement along the
    motion; `x` (free,) the branch's direction less that of the motion, in terms of null vectors.
    """
    wide, free = null.shape
    weak = left.shape[1]
    direction, missed = st.step_of(search), view(st.residuals_of(search), 0, weak)
    slopes, square = np.empty((weak, free)), np.empty((weak, weak))
    multiply(null.T, rate, x)
    for iteration in range(_ITERATIONS):
        multiply(null, x, direction)
        differentiate_complement(search, z, left, null, 0, slopes)
        if iteration == 0:
            passing[:, :] = slopes
        if newton_step(slopes, square, missed, x) < _CONVERGED:
            break
    for f in range(free):
        for j in range(wide):
            x[f] -= null[j, f] * rate[j]
    return int(iteration + 1)
