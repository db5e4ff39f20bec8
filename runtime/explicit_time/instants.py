"""The instants that explicit functions of time set for a run: where steps end, and where it ends.

They are known beforehand, for nothing but the time and the parameters decides on them.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from runtime.core.array_types import Matrix, Vector
from runtime.explicit_time.interval_evaluation import BREAK, CHOICE, OPERATIONS
from runtime.explicit_time.scan import ROWS, SMOOTH, scan
from runtime.mechanism.module_tables import Description
from runtime.mechanism.table_rows import TimeFunction

_MOST_MARKS = 4096  # safety: of one function in a run
_CLOCK = 16.0 * np.finfo(float).eps  # accuracy: of the time; distance of a kink's two sides from it
_WIDE = 1e-6  # safety: of the run; a longer place where nothing is decided holds many instants
_BLUR = 1e-8  # accuracy: of the run; distance in which rounding alone makes two breaks of one
_SLOWER = 0.85  # measured: ratio of the ways of marks from doubling to doubling that accumulate
_NEAR_END = (
    0.1  # measured: of an interval; a step that begins there may go on to the next one's end
)


class Kink(NamedTuple):
    """An instant at which functions of time may bend or jump."""

    before: float  # s; the last instant of the pieces before it
    after: float  # the first of those behind it
    element: str

    @property
    def title(self) -> str:
        """As events name it."""
        return f"{self.element}: next piece of its function of time"


class TimeInstants(NamedTuple):
    """What explicit functions of time ask of a run."""

    bounds: Vector  # instants at which steps end, so that nothing hides in one, s
    kinks: tuple[Kink, ...]  # in their order
    # instant from which on changes are too many to be followed, s, where they accumulate, the
    # element; None: nowhere
    crowd: tuple[float, float, str] | None = None


class _Marks(NamedTuple):
    """What a scan found in one function."""

    element: str
    bounds: Vector
    kinks: list[tuple[float, float]]
    crowd: tuple[float, float] | None


def time_instants(description: Description, p: Vector, t0: float, t1: float) -> TimeInstants:
    """The instants between t0 and t1, s, with the parameters `p`."""
    if not (t0 < t1 < np.inf):
        return TimeInstants(np.zeros(0), ())
    found = [
        _marks(_Code(function), function, p, t0, t1) for function in description.time_functions
    ]
    clock = float(_CLOCK * max(abs(t0), abs(t1)))
    kinks: list[Kink] = []
    for low, high, element in sorted((*pair, m.element) for m in found for pair in m.kinks):
        middle = 0.5 * (low + high)
        before, after = middle - clock, middle + clock
        if after < t0 or after >= t1 - clock:
            continue
        before = max(before, t0)
        if kinks and before <= kinks[-1].after:
            kinks[-1] = kinks[-1]._replace(after=after)
        else:
            kinks.append(Kink(before, after, element))
    crowds = [(*m.crowd, m.element) for m in found if m.crowd is not None]
    bounds = _walk([m.bounds for m in found], t0, t1)
    return TimeInstants(bounds, tuple(kinks), min(crowds, default=None))


class _Code:
    """A function as the arrays that `enclose` takes."""

    def __init__(self, function: TimeFunction) -> None:
        rows = function.rows
        self.code = np.zeros((len(rows), 4), np.int64)
        self.numbers = np.zeros(len(rows))
        knots: list[float] = []
        pieces: list[Sequence[float]] = []
        for k, (name, *args) in enumerate(rows):
            self.code[k, 0] = OPERATIONS.index(name)
            if name == "const":
                self.numbers[k] = args[0]
            elif name == "table":
                at, (places, table), order, periodic = args
                self.code[k, 1:] = at, len(knots), len(table)
                self.numbers[k] = places[-1] - places[0] if periodic else 0.0
                knots += places
                pieces += [_derivative(row, order) for row in table] + [(0.0,) * 4]
            elif args:
                self.code[k, 1 : 1 + len(args)] = args
                self.code[k, 1 + len(args) :] = args[0]
        self.knots = np.array(knots)
        self.pieces = np.array(pieces, dtype=np.float64).reshape(-1, 4)
        self.watched = np.array(function.watched, dtype=np.int64)


def _derivative(row: Sequence[float], order: int) -> Sequence[float]:
    """The coefficients of a derivative of a cubic."""
    for _ in range(order):
        row = (row[1], 2.0 * row[2], 3.0 * row[3], 0.0)
    return row


def _marks(code: _Code, function: TimeFunction, p: Vector, t0: float, t1: float) -> _Marks:
    """Scan one function."""
    marks, kinds = np.zeros((_MOST_MARKS, 2)), np.zeros(_MOST_MARKS, np.int64)
    work, stack = np.zeros((ROWS, len(code.code))), np.zeros(64)
    finest = 0.25 * _CLOCK * max(abs(t0), abs(t1))
    arrays = code.code, code.numbers, p, code.knots, code.pieces, code.watched
    count = scan(arrays, t0, t1, finest, marks, kinds, work, stack)
    marks, kinds = marks[:count], kinds[:count]
    wide = marks[:, 1] - marks[:, 0] > _WIDE * (t1 - t0)
    blurred = _merged(marks[(kinds & BREAK != 0) & ~wide], t0, t1)
    law = function.role == "law"
    exact = marks[(kinds == CHOICE) & ~wide] if law else marks[:0]
    crowd = _accumulation(marks[:, 0], t1) if count == _MOST_MARKS - 1 else None
    if wide.any():
        begin = float(marks[wide, 0][0])
        exact = np.vstack([exact, [[begin, begin]]])
        crowd = crowd or (begin, begin)
    kinks = [(float(a), float(b)) for a, b in (*blurred, *exact)]
    return _Marks(function.name, marks[kinds == SMOOTH, 0], kinks, crowd)


def _merged(places: Matrix, t0: float, t1: float) -> list[tuple[float, float]]:
    """Places at which a function breaks; those that rounding alone separates as one."""
    near, merged = _BLUR * (t1 - t0), list[tuple[float, float]]()
    for low, high in places.tolist():
        if merged and low - merged[-1][1] <= near:
            merged[-1] = merged[-1][0], high
        elif low - t0 > near:
            merged.append((low, high))
    return merged


def _accumulation(marks: Vector, t1: float) -> tuple[float, float] | None:
    """The last mark, and the instant before t1 at which marks accumulate; None where they do not.

    The k-th of them stands at t* - C k^-a, a > 0: its way shrinks by 2^-a from one doubling of k to
    the next, where that of marks at equal distances doubles.
    """
    last = len(marks) - 1
    quarter, half, end = (float(marks[k]) for k in (last // 4, last // 2, last))
    ratio = (end - half) / (half - quarter)
    if ratio >= _SLOWER:
        return None
    limit = end + (end - half) * ratio / (1.0 - ratio)
    return (end, limit) if limit < t1 else None


def _walk(bounds: list[Vector], t0: float, t1: float) -> Vector:
    """Instants in order, no two of them nearer than the intervals of all functions ask for."""
    edges = [np.concatenate([[t0], found, [t1]]) for found in bounds]
    places, t, stops = [1] * len(edges), t0, []
    while t < t1:
        end = t1
        for i, edge in enumerate(edges):
            while edge[places[i]] - t <= _NEAR_END * (edge[places[i]] - edge[places[i] - 1]):
                if places[i] == len(edge) - 1:
                    break
                places[i] += 1
            end = min(end, float(edge[places[i]]))
        t = end if end > t else t1
        stops.append(t)
    return np.array(stops[:-1])
