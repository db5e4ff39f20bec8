"""One explicit function of time, looked at part by part: its bounds, kinks, poles and crowds.

The time is halved until the bounds of the values in each quarter of an interval are about those at
the quarter's ends: then nothing hides in it. What is left at the clock's resolution is an instant
at which pieces meet, a jump or a pole.
"""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

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
from runtime.explicit_time.interval_arithmetic import BREAK, CHOICE, OPERATIONS, enclose
from runtime.linalg.vectors import copy_vector
from runtime.mechanism.table_rows import TimeFunction

Function = Any  # the first five arguments of `enclose`, and the rows that may bend sharply
FUNCTION = tuple_type((integer_matrix, vector, vector, vector, matrix, integers))

# measured: of the range of a value; its largest change in a quarter of an interval, and the largest
# part of this change that the two ends do not show
_VARIED, _HIDDEN = 0.25, 0.1
_LEAST = 1e-2  # safety: of a value's size; least range that is assumed
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


_MOST_MARKS = 4096  # safety: of one function, in one part of a run
_WIDE = 1e-6  # safety: of the run; a longer undecided interval holds many instants
_BLUR = 1e-8  # accuracy: of the run; breaks nearer to each other are one, split by rounding
_SLOWER = 0.85  # measured: ratio of distances between marks, after a doubling, that accumulate
FAR = 1000.0  # safety: distances of a kink's sides from the kink; so far away a pole does not show
GROWTH = 300.0  # safety: growth of a value from there to a side of the kink; that of a pole is 1000
_STEEP = 1e6  # safety: times the typical value of a function; no step goes nearer to its pole
_NEAR_POLE = 0.05  # safety: of the run; a run ends no earlier before a pole
_STEP = 0.5  # safety: ratio of the changes of a place in a time and in 1000 times it; a jump has 1
_SEEN = 64  # measured: instants at which the typical value of a function is taken


class FunctionArrays:
    """A function as the arrays that `enclose` takes.

    `begin` says where in p the values of leaves stand that are neither parameters nor the time.
    """

    def __init__(
        self,
        rows: tuple[tuple[Any, ...], ...],
        watched: tuple[int, ...] = (),
        begin: Mapping[str, int] = MappingProxyType({}),
    ) -> None:
        self.code = np.zeros((len(rows), 4), np.int64)
        self.numbers = np.zeros(len(rows))
        knots: list[float] = []
        pieces: list[Sequence[float]] = []
        for k, (name, *args) in enumerate(rows):
            self.code[k, 0] = OPERATIONS.index("p" if name in begin else name)
            if name == "const":
                self.numbers[k] = args[0]
            elif name == "table":
                at, (places, table), order, periodic, *beyond = args
                self.code[k, 1:] = at, len(knots), len(table)
                self.numbers[k] = places[-1] - places[0] if periodic else -1.0 if beyond else 0.0
                knots += places
                pieces += [_derivative(row, order) for row in table] + [(0.0,) * 4]
            elif args:
                self.code[k, 1 : 1 + len(args)] = np.add(args, begin.get(name, 0))
                self.code[k, 1 + len(args) :] = args[0]
        self.knots = np.array(knots)
        self.pieces = np.array(pieces, dtype=np.float64).reshape(-1, 4)
        self.watched = np.array(watched, dtype=np.int64)

    def value(self, t: float, p: Vector) -> float:
        """Its value at one instant; where it is undecided, one of its bounds."""
        low, high, steps = np.zeros((3, len(self.code)))
        enclose(self.code, self.numbers, p, self.knots, self.pieces, t, t, low, high, steps)
        return float(low[-1])


def _derivative(row: Sequence[float], order: int) -> Sequence[float]:
    """The coefficients of a derivative of a cubic."""
    for _ in range(order):
        row = (row[1], 2.0 * row[2], 3.0 * row[3], 0.0)
    return row


class FunctionScan:
    """What a function asks of a run from t0 to t1, s; it is known up to `reach`."""

    def __init__(self, function: TimeFunction, p: Vector, t0: float, t1: float) -> None:
        self.role, self.is_place = function.role, bool(function.along)
        self.t0, self.t1, self.reach, self.p = t0, t1, t0, p
        self.bounds = np.zeros(0)  # known and not yet given away, as are
        self.kinks: list[tuple[float, float]] = []
        self.crowd: tuple[float, float] | None = None
        self._arrays = FunctionArrays(function.rows, function.watched)
        self._marks = np.zeros((_MOST_MARKS, 2))
        self._kinds = np.zeros(_MOST_MARKS, np.int64)
        self._work = np.zeros((ROWS, len(self._arrays.code)))
        self._parts, self._next = 0, 1
        self._doublings = [t0, t0, t0]  # where a quarter, half and all of the marks end

    def scan_next_part(self, finest: float) -> None:
        """Look at the next part, as finely as `finest`, s."""
        begin = self.reach
        self.reach, count = self._scan(begin, finest)
        marks, kinds = self._marks[:count].copy(), self._kinds[:count]
        bounds, kinks = self._bounds_and_kinks(marks, kinds, 4.0 * finest)
        self._parts += 1
        if self.reach < self.t1 and self._parts >= self._next:
            if self._parts == 1 and count > 3:
                ends = [float(marks[k, 0]) for k in ((count - 1) // 4, (count - 1) // 2)]
                self._doublings = [*ends, self.reach]
            else:
                self._doublings = [*self._doublings[1:], self.reach]
            self._next *= 2
            self.crowd = self.crowd or self._accumulation(finest)
        self.bounds, self.kinks = np.append(self.bounds, bounds), [*self.kinks, *kinks]

    def pop_until(self, end: float) -> tuple[Vector, list[tuple[float, float]]]:
        """Remove the bounds and kinks until `end`, and return them."""
        bounds, kinks = self.bounds, self.kinks
        self.bounds = bounds[bounds >= end]
        self.kinks = [kink for kink in kinks if kink[0] > end]
        return bounds[bounds < end], kinks[: len(kinks) - len(self.kinks)]

    def steep_from(self, instant: float, clock: float) -> float | None:
        """Where a function that grows without bound up to an instant becomes steep, s; or None.

        From there on it is a million times as large as it is typically.
        """
        near, far = (self._size(instant - way * clock) for way in (1.0, FAR))
        if not near > GROWTH * far:
            return None
        seen = [self._size(t) for t in np.linspace(self.t0, self.t1, _SEEN + 1)]
        sizes = [size for size in seen if 0.0 < size < np.inf]
        typical = (
            float(np.median(sizes)) if sizes else self._size(instant - (self.t1 - self.t0) / _SEEN)
        )
        way, most = FAR * clock, min(_NEAR_POLE * (self.t1 - self.t0), instant - self.t0)
        if not self._size(instant - way) > _STEEP * typical:
            return None
        while way < most and self._size(instant - 2.0 * way) > _STEEP * typical:
            way *= 2.0
        return instant - min(way, most)

    def jump(self, before: float, after: float) -> float:
        """By how much a place jumps between two instants; 0 for other functions, and for a bend."""
        if not self.is_place:
            return 0.0
        far = FAR * (after - before)
        near, wide = (
            abs(self._value(after + way) - self._value(before - way)) for way in (0.0, far)
        )
        return near if near > _STEP * wide else 0.0

    def breaks_within(self, a: float, b: float) -> bool:
        """Whether a law may break from a to b, s."""
        f, (low, high, steps) = self._arrays, self._work[:3]
        undecided = enclose(f.code, f.numbers, self.p, f.knots, f.pieces, a, b, low, high, steps)
        return self.role == "law" and undecided != 0

    def _value(self, t: float) -> float:
        """f(t), where it has one value."""
        self._size(t)
        return float(self._work[0, -1])

    def _size(self, t: float) -> float:
        """|f(t)|, not a number where it has no value."""
        a, (low, high, steps) = self._arrays, self._work[:3]
        enclose(a.code, a.numbers, self.p, a.knots, a.pieces, t, t, low, high, steps)
        return max(abs(float(low[-1])), abs(float(high[-1])))

    def _scan(self, begin: float, finest: float) -> tuple[float, int]:
        """Fill marks and kinds from `begin` on; up to where, and how many."""
        a = self._arrays
        arrays = a.code, a.numbers, self.p, a.knots, a.pieces, a.watched
        count = scan(
            arrays, begin, self.t1, finest, self._marks, self._kinds, self._work, np.zeros(64)
        )
        return float(self._marks[count, 0]), count

    def _bounds_and_kinks(
        self, marks: Matrix, kinds: Integers, clock: float
    ) -> tuple[Vector, list[tuple[float, float]]]:
        """Bounds and kinks among marks; a place where nothing is decided is a crowd."""
        span = self.t1 - self.t0
        wide = marks[:, 1] - marks[:, 0] > _WIDE * span
        blurred = self._without_blur(marks[(kinds & BREAK != 0) & ~wide])
        exact = marks[(kinds == CHOICE) & ~wide]
        if self.role != "law":  # the run's own switches choose, and stop at what does not jump
            exact = exact[[self.jump(a - clock, b + clock) > 0.0 for a, b in exact.tolist()]]
        if wide.any():
            begin = float(marks[wide, 0][0])
            exact = np.vstack([exact, [[begin, begin]]])
            self.crowd = self.crowd or (begin, begin)
        kinks = sorted((float(a), float(b)) for a, b in (*blurred, *exact))
        return marks[kinds == SMOOTH, 0], kinks

    def _without_blur(self, places: Matrix) -> list[tuple[float, float]]:
        """Places at which a function breaks; those that rounding alone separates as one."""
        near, merged = _BLUR * (self.t1 - self.t0), list[tuple[float, float]]()
        for low, high in places.tolist():
            if merged and low - merged[-1][1] <= near:
                merged[-1] = merged[-1][0], high
            else:
                merged.append((low, high))
        return merged

    def _accumulation(self, finest: float) -> tuple[float, float] | None:
        """Where marks are too many, and the instant before t1 at which they accumulate; or None.

        The k-th of them stands at t* - C k^-a, a > 0: its way shrinks by 2^-a from one doubling of
        k to the next, where that of marks at equal distances doubles. A burst of changes does the
        same at first, and is told from them by two more doublings.
        """
        quarter, half, end = self._doublings
        reach, parts = end, self._parts
        while (ratio := _ratio(quarter, half, reach)) < _SLOWER:
            limit = reach + (reach - half) * ratio / (1.0 - ratio)
            if limit >= self.t1:
                return None
            if parts == 4 * self._parts:
                return end, limit
            quarter, half = half, reach
            for _ in range(parts):
                if reach >= self.t1:
                    return None
                reach, _ = self._scan(reach, finest)
            parts *= 2
        return None


def _ratio(quarter: float, half: float, end: float) -> float:
    """By how much the way of marks grows from one doubling to the next."""
    return (end - half) / (half - quarter) if half > quarter else 1.0
