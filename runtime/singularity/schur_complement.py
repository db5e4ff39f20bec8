"""What elimination leaves of a Jacobian: Schur's complement, left vectors and null vectors.

In a given order of pivots, found where the Jacobian was close by, the first rows and columns are
eliminated; those behind them are the weak rows and the free columns. The complement vanishes where
the weak rows follow from the others. Row combinations u with uᵀ J = complement, in the free columns
alone, have 1 in one weak row; vectors z that the first rows take to zero have 1 in one free column.
Nothing but non-zeros is worked on.
"""

from runtime.core.array_views import floats_at, integers_at
from runtime.core.jit import inner
from runtime.core.signatures import Integers, Matrix, Vector
from runtime.singularity.search_table import (
    ALL_ROWS,
    COLUMN_PLACE,
    COORDINATES,
    ENTRY_COLUMNS,
    ENTRY_ROWS,
    LENGTHS,
    NONZEROS,
    ROW_PLACE,
    ROWS,
    VALUES,
    entries,
)

_LEAST = 1e-13  # accuracy: a pivot below this, rows of unit length, is zero
_NOTHING = 1e-14  # accuracy: entries below this, in vectors with an entry 1, are rounding


@inner
def eliminated(
    table: Integers, speed: float, z: Vector, strong: int, a: Matrix, gaps: Vector
) -> bool:
    """Eliminate the first `strong` places of the Jacobian at z from it and from `gaps`.

    Parameters
    ----------
    a : (rows, n + 1)
        Out: rows and columns in the order of their places, as factors; behind the first `strong`
        ones the complement.
    gaps : (rows,)
        Values of the rows; in the order of their places, the first ones' shares are taken off the
        others.

    Returns
    -------
    bool
        False where a pivot vanishes.
    """
    rows, wide = table[ROWS], table[COORDINATES] + 1
    size = table[NONZEROS] + table[ALL_ROWS]
    values, lengths = floats_at(table, VALUES, size), floats_at(table, LENGTHS, rows)
    at_row, at_column = (
        integers_at(table, ENTRY_ROWS, size),
        integers_at(table, ENTRY_COLUMNS, size),
    )
    row_place = integers_at(table, ROW_PLACE, rows)
    column_place = integers_at(table, COLUMN_PLACE, wide)
    entries(table, speed, z, values)
    for i in range(rows):
        for j in range(wide):
            a[i, j] = 0.0
    for e in range(size):
        i = at_row[e]
        if i < rows:
            a[row_place[i], column_place[at_column[e]]] += values[e] / lengths[i]
    for s in range(strong):
        pivot = a[s, s]
        if not abs(pivot) > _LEAST:
            return False
        for i in range(s + 1, rows):
            if a[i, s] != 0.0:
                share = a[i, s] / pivot
                a[i, s] = share
                for j in range(s + 1, wide):
                    a[i, j] -= share * a[s, j]
                gaps[i] -= share * gaps[s]
    return True


@inner
def move(a: Matrix, strong: int, gaps: Vector, step: Vector) -> None:
    """Complete `step`, (n + 1,) in the order of places, by what closes the first rows' gaps."""
    wide = a.shape[1]
    for s in range(strong - 1, -1, -1):
        total = gaps[s]
        for j in range(s + 1, wide):
            total += a[s, j] * step[j]
        step[s] = -total / a[s, s]


@inner
def lefts(a: Matrix, strong: int, order: Integers, u: Matrix) -> None:
    """The left vectors, (rows, weak); `order` says which row is where."""
    rows, weak = u.shape
    for s in range(rows):
        i = order[s]
        for w in range(weak):
            if s < strong:
                u[i, w] = -a[strong + w, s]
            else:
                u[i, w] = 1.0 if s == strong + w else 0.0
    for s in range(strong - 1, -1, -1):
        i = order[s]
        for w in range(weak):
            if abs(u[i, w]) < _NOTHING:
                u[i, w] = 0.0
        for k in range(s):
            share = a[s, k]
            if share != 0.0:
                for w in range(weak):
                    u[order[k], w] -= share * u[i, w]


@inner
def nulls(a: Matrix, strong: int, order: Integers, z: Matrix) -> None:
    """The null vectors, (n + 1, free); `order` says which column is where."""
    wide, free = z.shape
    for s in range(strong, wide):
        for f in range(free):
            z[order[s], f] = 1.0 if s == strong + f else 0.0
    for s in range(strong - 1, -1, -1):
        i = order[s]
        for f in range(free):
            z[i, f] = a[s, strong + f]
        for j in range(s + 1, strong):
            share = a[s, j]
            if share != 0.0:
                for f in range(free):
                    z[i, f] += share * z[order[j], f]
        for f in range(free):
            z[i, f] /= -a[s, s]
            if abs(z[i, f]) < _NOTHING:
                z[i, f] = 0.0


@inner
def gram(vectors: Matrix, out: Matrix) -> None:
    """Products of all pairs of columns: the lower half of `out`."""
    count, width = vectors.shape
    for i in range(width):
        for j in range(i + 1):
            out[i, j] = 0.0
    for s in range(count):
        for i in range(width):
            if vectors[s, i] != 0.0:
                for j in range(i + 1):
                    out[i, j] += vectors[s, i] * vectors[s, j]


@inner
def cholesky(a: Matrix) -> bool:
    """Overwrite the lower half by its Cholesky factor; false where it has none."""
    for i in range(a.shape[0]):
        for j in range(i + 1):
            total = a[i, j]
            for k in range(j):
                total -= a[i, k] * a[j, k]
            if i != j:
                a[i, j] = total / a[j, j]
            elif total > 0.0:
                a[i, i] = total**0.5
            else:
                return False
    return True


@inner
def solved(factor: Matrix, x: Vector) -> None:
    """Overwrite x with the solution of L Lᵀ y = x."""
    size = x.size
    for i in range(size):
        for j in range(i):
            x[i] -= factor[i, j] * x[j]
        x[i] /= factor[i, i]
    for i in range(size - 1, -1, -1):
        x[i] /= factor[i, i]
        for j in range(i):
            x[j] -= factor[i, j] * x[i]


@inner
def orthonormal(factor: Matrix, vectors: Matrix) -> None:
    """Make columns orthonormal, with the Cholesky factor of their products."""
    count, width = vectors.shape
    for s in range(count):
        for i in range(width):
            total = vectors[s, i]
            for j in range(i):
                total -= factor[i, j] * vectors[s, j]
            vectors[s, i] = total / factor[i, i]
