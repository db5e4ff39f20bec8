"""Gauss-Newton's iteration for a singular position: compiled.

The unknown is z; the equations are those of the rows that keep their strength, and the complement
of the others, which vanishes entry by entry (see `search`).
"""

import numpy as np

from runtime.core.array_views import floats_at, integers_at
from runtime.core.jit import compiled, inner
from runtime.core.signatures import Integers, Matrix, Vector, f8, i8, integers, matrix, vector
from runtime.singularity.complement_derivative import curve
from runtime.singularity.schur_complement import (
    cholesky,
    eliminated,
    gram,
    lefts,
    move,
    nulls,
    orthonormal,
    solved,
)
from runtime.singularity.search_table import (
    COLUMN_ORDER,
    COORDINATES,
    GAPS,
    ORIGIN,
    ROW_ORDER,
    ROWS,
    STEP,
    unit_gaps,
)

_ITERATIONS = 40  # safety: Gauss-Newton iterations
_KEEP = 5  # measured: iterations with the same second derivatives, except for the first one's
_CONVERGED = 1e-12  # accuracy: scaled change at which they have converged
# safety: of a coordinate's size; a root further from the start of the search is another one
_FAR = 0.5
_FLAT = 1e-6  # accuracy: rest of the complement at a singular configuration


@inner
def complement(
    table: Integers, speed: float, z: Vector, strong: int, a: Matrix, gaps: Vector
) -> bool:
    """Eliminate the strong rows at z; false where a pivot vanishes."""
    unit_gaps(table, speed, z, gaps)
    return bool(eliminated(table, speed, z, strong, a, gaps))


@inner
def vectors(table: Integers, a: Matrix, strong: int, left: Matrix, null: Matrix) -> None:
    """Left vectors and null vectors where the strong rows were eliminated."""
    lefts(a, strong, integers_at(table, ROW_ORDER, table[ROWS]), left)
    nulls(a, strong, integers_at(table, COLUMN_ORDER, table[COORDINATES] + 1), null)


@inner
def normalised(
    a: Matrix, strong: int, left: Matrix, null: Matrix, square: Matrix, normal: Matrix
) -> bool:
    """Make the complement in `a` one between orthonormal vectors, R_u⁻ᵀ G R_z⁻¹; false: it cannot.

    `square`, (weak, weak), and `normal`, (free, free), receive the Cholesky factors of the left and
    the null vectors' products.
    """
    weak, free = left.shape[1], null.shape[1]
    gram(left, square)
    gram(null, normal)
    if not (cholesky(square) and cholesky(normal)):
        return False
    for w in range(weak):
        for f in range(free):
            total = a[strong + w, strong + f]
            for k in range(f):
                total -= normal[f, k] * a[strong + w, strong + k]
            a[strong + w, strong + f] = total / normal[f, f]
    for w in range(weak):
        for k in range(w):
            for f in range(free):
                a[strong + w, strong + f] -= square[w, k] * a[strong + k, strong + f]
        for f in range(free):
            a[strong + w, strong + f] /= square[w, w]
    return True


@inner
def widest(gaps: Vector, strong: int, lower: Matrix) -> float:
    """The largest gap of the orthonormal row combinations that are lost."""
    largest = 0.0
    for w in range(lower.shape[0]):
        total = gaps[strong + w]
        for k in range(w):
            total -= lower[w, k] * gaps[strong + k]
        gaps[strong + w] = total / lower[w, w]
        largest = max(largest, abs(gaps[strong + w]))
    return float(largest)


@compiled(f8(integers, f8, vector, matrix, matrix, matrix, matrix, matrix, matrix, matrix, vector))
def root(
    table: Integers,
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
        The largest gap of a row combination that is lost, or -1 where there is no such position.
    """
    rows, wide = table[ROWS], table[COORDINATES] + 1
    weak, free = left.shape[1], null.shape[1]
    strong = rows - weak
    order = integers_at(table, COLUMN_ORDER, wide)
    step, gaps = floats_at(table, STEP, wide), floats_at(table, GAPS, rows)
    origin = floats_at(table, ORIGIN, wide)
    for j in range(wide):
        origin[j] = z[j]
    for iteration in range(_ITERATIONS):
        if not complement(table, speed, z, strong, a, gaps):
            return -1.0
        if iteration % _KEEP == 0 or iteration == 1:
            vectors(table, a, strong, left, null)
            if not curve(table, speed, z, left, null, step, sums, form, normal):
                return -1.0
        for f in range(free):
            x[f] = 0.0
        for w in range(weak):
            for g in range(free):
                for f in range(free):
                    x[f] -= form[w * free + g, f] * a[strong + w, strong + g]
        solved(normal, x)
        for f in range(free):
            step[strong + f] = x[f]
        move(a, strong, gaps, step)
        moved, size, away = 0.0, 0.0, 0.0
        for s in range(wide):
            j = order[s]
            z[j] += step[s]
            moved += step[s] ** 2
            size += z[j] ** 2
            away = max(away, abs(z[j] - origin[j]))
        if not (away < _FAR and moved < np.inf):
            return -1.0
        if moved < (_CONVERGED * (1.0 + np.sqrt(size))) ** 2:
            break
    if not complement(table, speed, z, strong, a, gaps):
        return -1.0
    vectors(table, a, strong, left, null)
    if not normalised(a, strong, left, null, square, normal):
        return -1.0
    for i in range(strong, rows):
        for j in range(strong, wide):
            if not abs(a[i, j]) <= _FLAT:
                return -1.0
    orthonormal(normal, null)
    orthonormal(square, left)
    return widest(gaps, strong, square)


@compiled(i8(integers, matrix, matrix, matrix, matrix, matrix))
def weak_part(
    table: Integers, a: Matrix, left: Matrix, null: Matrix, square: Matrix, normal: Matrix
) -> int:
    """Make the complement in an eliminated matrix one between orthonormal vectors; 0: it cannot.

    Its singular values are then the small ones of the matrix but for the square of what they are
    over the others: without the complement the matrix had these vectors for its singular ones.
    """
    strong = left.shape[0] - left.shape[1]
    vectors(table, a, strong, left, null)
    return int(normalised(a, strong, left, null, square, normal))
