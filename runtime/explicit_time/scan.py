"""Search of a run's time for the places where an explicit function of time bends, jumps or ends.

The time is halved until the bounds of the values in each quarter of an interval are about
those at the quarter's ends: then nothing hides in it. What is left at the clock's
resolution is an instant at which pieces meet, a jump or a pole.
"""

import math
from typing import Any

from runtime.core.arrays import (
    Integers,
    Matrix,
    Vector,
    f8,
    i8,
    integer_matrix,
    integers,
    matrix,
    tuple_type,
    vector,
)
from runtime.core.jit import compiled, inner
from runtime.explicit_time.interval_arithmetic import BREAK, enclose
from runtime.linalg.vectors import copy_vector

Function = Any  # the first five arguments of `enclose`, and the rows that may bend sharply
FUNCTION = tuple_type((integer_matrix, vector, vector, vector, matrix, integers))

# measured: of the range of a value; what it may do in a quarter of an interval, and what it may do
# there beyond what its two ends show
_VARIED, _HIDDEN = 0.25, 0.1
_LEAST = 1e-2  # safety: of a value's size; a smaller range counts as that
_QUARTERS = 4  # measured: parts of an interval at whose ends a function is seen
_SAMPLES = 64  # measured: instants at which the ranges of values are seen before the search
_MOST = 250_000  # safety: intervals that are looked at in one call
SMOOTH = 0  # code of a mark: the end of an interval, in which nothing hides
_BENT = 4  # code: in an interval something may hide, although no condition is undecided in it
_LOW, _HIGH, _SPARE, _LEAST_SEEN, _MOST_SEEN, _FIRST, _LAST, _BEFORE, _HERE, _STEPS = range(10)
ROWS = 10  # layout: of the scratch of a scan


@inner
def ends_are_representative(work: Matrix, watched: Integers) -> bool:
    """Whether values in an interval are about those at its ends, rows FIRST and LAST."""
    for k in watched:
        low, high = work[_LOW, k], work[_HIGH, k]
        if math.isnan(low) or low == high:
            continue  # it has none, or one, which may be infinite
        first, last = work[_FIRST, k], work[_LAST, k]
        least, most = work[_LEAST_SEEN, k], work[_MOST_SEEN, k]
        size = max(most - least, _LEAST * max(abs(least), abs(most)))
        hidden = max(high - max(first, last), min(first, last) - low)
        if not (high - low <= _VARIED * size and hidden <= _HIDDEN * size):
            return False
    return True


@inner
def look(f: Function, t: float, work: Matrix, row: int) -> None:
    """Write the values at an instant into a row, and note their range so far."""
    code, numbers, p, knots, pieces, watched = f
    enclose(code, numbers, p, knots, pieces, t, t, work[row], work[_SPARE], work[_STEPS])
    for k in watched:
        if math.isfinite(work[row, k]):
            work[_LEAST_SEEN, k] = min(work[_LEAST_SEEN, k], work[row, k])
            work[_MOST_SEEN, k] = max(work[_MOST_SEEN, k], work[row, k])


@inner
def examine(f: Function, a: float, b: float, start: int, work: Matrix) -> int:
    """0 where nothing hides from a to b, else the codes of what is undecided, or BENT.

    Row `start` has the values at a; row LAST receives those at b, if nothing hides.
    """
    code, numbers, p, knots, pieces, watched = f
    copy_vector(work[start], work[_FIRST])
    left = a
    for quarter in range(1, _QUARTERS + 1):
        right = b if quarter == _QUARTERS else a + (b - a) * quarter / _QUARTERS
        low, high = work[_LOW], work[_HIGH]
        undecided = enclose(code, numbers, p, knots, pieces, left, right, low, high, work[_STEPS])
        if undecided != 0:
            return undecided
        look(f, right, work, _LAST)
        if not ends_are_representative(work, watched):
            return _BENT
        copy_vector(work[_LAST], work[_FIRST])
        left = right
    return 0


@compiled(i8(FUNCTION, f8, f8, f8, matrix, integers, matrix, vector))
def scan(
    f: Function, t0: float, t1: float, finest: float, marks: Matrix, kinds: Integers, work: Matrix,
    stack: Vector,
) -> int:  # fmt: skip
    """Fill `marks`, (begin, end) each, and their `kinds`, from t0 to t1; their number.

    A mark of the kind SMOOTH is the end of an interval in which nothing hides; one of another kind,
    CHOICE or BREAK or both, an instant at which nothing finer than `finest`, s, could be decided.
    The search ends early where `marks` is full or much was looked at; the row behind the last mark
    begins with the instant up to which it came. `work`, (ROWS, values), and `stack` are scratch.
    """
    work[_LEAST_SEEN, :], work[_MOST_SEEN, :] = math.inf, -math.inf
    for k in range(_SAMPLES + 1):
        look(f, t0 + (t1 - t0) * k / _SAMPLES, work, _LAST)
    count, top, looks = 0, 0, 0
    left = joined = t0  # where the interval begins, and those that were found smooth before it
    stack[0] = t1
    look(f, t0, work, _HERE)
    copy_vector(work[_HERE], work[_BEFORE])
    while top >= 0 and count < len(marks) - 1 and looks < _MOST:
        right, last = stack[top], count - 1
        looks += 1
        found = examine(f, left, right, _HERE, work)
        if found == 0:
            # One with the intervals before, if nothing hides in them all.
            if joined < left and examine(f, joined, right, _BEFORE, work) != 0:
                marks[count, 0] = marks[count, 1] = joined = left
                kinds[count] = SMOOTH
                count += 1
                copy_vector(work[_HERE], work[_BEFORE])
            left = right
            look(f, right, work, _HERE)
            top -= 1
            continue
        clustered = last >= 0 and kinds[last] != SMOOTH and marks[last, 1] == left
        if clustered and right - left <= marks[last, 1] - marks[last, 0]:
            marks[last, 1] = right
            kinds[last] |= found & ~_BENT
        elif right - left <= finest or top + 1 >= stack.size:
            marks[count, 0], marks[count, 1] = left, right
            kinds[count] = BREAK if found == _BENT else found
            count += 1
        else:
            top += 1
            stack[top] = 0.5 * (left + right)
            continue
        left = joined = right
        look(f, right, work, _HERE)
        copy_vector(work[_HERE], work[_BEFORE])
        top -= 1
    if top >= 0 and count > 1 and kinds[count - 1] != SMOOTH and marks[count - 1, 1] == left:
        count -= 1  # what is undecided there may go on
        left = marks[count, 0]
    marks[count, 0] = left if top >= 0 else t1
    return count
