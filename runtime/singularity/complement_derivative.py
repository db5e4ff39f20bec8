"""Derivatives of what a singular position loses: differences of Jacobians between its vectors.

The derivative of Schur's complement in the direction of a null vector is uᵀ J' z, between the left
vectors u and the null vectors z (see `complement`).
"""

import numpy as np

from runtime.core.array_views import floats_at, integers_at, view
from runtime.core.jit import compiled, inner
from runtime.core.signatures import Integers, Matrix, Vector, f8, i8, integers, matrix, vector
from runtime.singularity.schur_complement import cholesky, gram, solved
from runtime.singularity.search_table import (
    AHEAD,
    ALL_ROWS,
    ASIDE,
    BEHIND,
    COORDINATES,
    ENTRY_COLUMNS,
    ENTRY_ROWS,
    GAPS,
    LENGTHS,
    NONZEROS,
    ROWS,
    STEP,
    entries,
)

_ITERATIONS = 40  # safety: Newton iterations
_CONVERGED = 1e-12  # accuracy: scaled change at which they have converged
_DIFFERENCE = 6e-6  # accuracy: eps ** (1/3), the relative size of a central difference
_LEAST = 1e-13  # accuracy: of the largest; squares of singular values below this determine nothing


@inner
def bend(
    table: Integers, speed: float, z: Vector, direction: Vector, left: Matrix, sums: Matrix
) -> None:
    """uᵀ J' in a direction from z, for all left vectors: `sums`, (n + 1, weak)."""
    rows, wide, weak = table[ROWS], table[COORDINATES] + 1, left.shape[1]
    size = table[NONZEROS] + table[ALL_ROWS]
    ahead, behind = floats_at(table, AHEAD, size), floats_at(table, BEHIND, size)
    at_row, at_column = (
        integers_at(table, ENTRY_ROWS, size),
        integers_at(table, ENTRY_COLUMNS, size),
    )
    lengths, aside = floats_at(table, LENGTHS, rows), floats_at(table, ASIDE, wide)
    total = 0.0
    for j in range(wide):
        total += direction[j] ** 2
    delta = _DIFFERENCE / max(np.sqrt(total), 1e-300)
    for j in range(wide):
        aside[j] = z[j] + delta * direction[j]
    entries(table, speed, aside, ahead)
    for j in range(wide):
        aside[j] = z[j] - delta * direction[j]
    entries(table, speed, aside, behind)
    for j in range(wide):
        for w in range(weak):
            sums[j, w] = 0.0
    for e in range(size):
        i, j = at_row[e], at_column[e]
        if i < rows and ahead[e] != behind[e]:
            slope = (ahead[e] - behind[e]) / (2.0 * delta * lengths[i])
            for w in range(weak):
                sums[j, w] += slope * left[i, w]


@inner
def between(sums: Matrix, null: Matrix, first: int, every: int, out: Matrix) -> None:
    """The derivative uᵀ J' z of each left vector, in rows `first`, `first` + `every`, ..."""
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
def curve(
    table: Integers,
    speed: float,
    z: Vector,
    left: Matrix,
    null: Matrix,
    direction: Vector,
    sums: Matrix,
    form: Matrix,
    normal: Matrix,
) -> bool:
    """Derivatives of the complement, (weak free, free), and the factors of their normal equations.

    What the derivatives leave open is to be as little as possible in z.
    """
    wide, free = null.shape
    for g in range(free):
        for j in range(wide):
            direction[j] = null[j, g]
        bend(table, speed, z, direction, left, sums)
        between(sums, null, g, free, form)
    gram(form, normal)
    largest = 0.0
    for f in range(free):
        largest = max(largest, normal[f, f])
    if not largest > 0.0:
        return False
    for j in range(wide):
        for i in range(free):
            if null[j, i] != 0.0:
                for k in range(i + 1):
                    normal[i, k] += _LEAST * largest * null[j, i] * null[j, k]
    return cholesky(normal)


@inner
def returned(slopes: Matrix, square: Matrix, missed: Vector, x: Vector) -> float:
    """Take the least step of Newton's for a root of xᵀ form x; the step's length over that of x.

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
        square[w, w] += _LEAST * largest
    if not cholesky(square):
        return 0.0
    solved(square, missed)
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
def branch(
    table: Integers,
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
    """The direction of the branch nearest to a motion, in a singular position.

    Branches have directions N x with uᵀ J'(N x) N x = 0, for all left vectors u: by Newton's
    iteration, with the least steps, from the direction of the motion.

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
        Out: what the motion lacks to the branch, in terms of null vectors.

    Returns
    -------
    int
        Iterations.
    """
    wide, free = null.shape
    weak = left.shape[1]
    direction = floats_at(table, STEP, table[COORDINATES] + 1)
    missed = view(floats_at(table, GAPS, table[ROWS]), 0, weak)
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
        bend(table, speed, z, direction, left, sums)
        between(sums, null, 0, 1, slopes)
        if iteration == 0:
            for w in range(weak):
                for f in range(free):
                    passing[w, f] = slopes[w, f]
        done = iteration + 1
        if returned(slopes, square, missed, x) < _CONVERGED:
            break
    for f in range(free):
        for j in range(wide):
            x[f] -= null[j, f] * rate[j]
    return done
