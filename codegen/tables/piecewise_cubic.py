"""Functions by cubic pieces, and the curves of each kind through points: plain numbers.

The coefficients are computed with Python's own floats, one operation after the other: those of a
linear-algebra library differ in the last digit from machine to machine, and with them would the
generated text.
"""

import hashlib
import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, NamedTuple

MARGIN = 1e-9  # accuracy: rounding of a law's argument beyond its ends, in parts of its length

Row = tuple[float, float, float, float]
Beyond = Literal["stop", "hold", "extrapolate"]
Role = Literal["values", "end", "knots", "range"]


@dataclass(frozen=True)
class Table:
    """A function given by points, a cubic between two knots."""

    name: str  # an identifier
    knots: tuple[float, ...]  # ascending; the last of a periodic table is the first, a period later
    rows: tuple[Row, ...]  # (c0, c1, c2, c3): c0 + c1 s + c2 s² + c3 s³ with s from the left knot
    periodic: bool
    # Beyond the ends of one that does not repeat: undefined (nan), the value at the end, or the
    # cubic of the last piece.
    beyond: Beyond = "stop"
    smooth: int = 2  # how many derivatives are continuous at the knots
    kind: str = "spline"
    # "end": what another table is at its ends; "knots", "range": a switching function of another
    role: Role = "values"

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the numbers."""
        numbers: tuple[Any, ...] = (self.knots, self.rows, self.periodic)
        if (more := (self.beyond, self.smooth, self.role)) != ("stop", 2, "values"):
            numbers += more
        return hashlib.sha256(repr(numbers).encode()).hexdigest()

    @property
    def first(self) -> float:
        """Where it begins."""
        return self.knots[0]

    @property
    def last(self) -> float:
        """Where it ends, or begins to repeat."""
        return self.knots[-1]

    @property
    def length(self) -> float:
        """From the first point to the last."""
        return self.last - self.first

    @property
    def stops(self) -> bool:
        """Whether it is undefined beyond its ends."""
        return not self.periodic and self.beyond == "stop"

    @property
    def held(self) -> tuple[float, float] | None:
        """The values before its first and behind its last point, where it holds them."""
        if self.periodic or self.beyond != "hold":
            return None
        c0, c1, c2, c3 = self.rows[-1]
        s = self.knots[-1] - self.knots[-2]
        return self.rows[0][0], c0 + s * (c1 + s * (c2 + s * c3))

    def __call__(self, x: Any, order: int = 0) -> Any:
        """The value or a derivative at a number of any kind; complex numbers by their real part."""
        at = float(getattr(x, "real", x))
        if math.isnan(at):
            return math.nan
        if self.periodic:
            turns = math.floor((at - self.first) / self.length)
            x, at = x - turns * self.length, at - turns * self.length
        elif self.stops and not -MARGIN <= (at - self.first) / self.length <= 1 + MARGIN:
            return math.nan
        elif (held := self.held) and not self.first <= at <= self.last:
            return (held[int(at > self.last)] if order == 0 else 0.0) + 0 * x
        inner = bisect_right(self.knots, at, 1, len(self.knots) - 1) - 1
        s, row = x - self.knots[inner], self.rows[inner]
        return derivative_at(row, s, order)


class Excess(NamedTuple):
    """The place furthest outside of the values at the knots."""

    at: float
    value: float
    share: float  # of their range


def excess(table: Table) -> Excess | None:
    """By how much a table leaves the range of its points; None where it stays inside."""
    ends = [row[0] for row in table.rows]
    ends.append(derivative_at(table.rows[-1], table.knots[-1] - table.knots[-2], 0))
    low, high = min(ends), max(ends)
    worst = None
    for (left, right), row in zip(pairwise(table.knots), table.rows, strict=True):
        for s in _turning_places(row, right - left):
            value = derivative_at(row, s, 0)
            beyond = max(value - high, low - value)
            if beyond > 0.0 and (worst is None or beyond > worst.share):
                worst = Excess(left + s, value, beyond)
    return worst and worst._replace(share=worst.share / (high - low) if high > low else math.inf)


def _turning_places(row: Row, length: float) -> Iterator[float]:
    """Where the slope of a piece vanishes inside of it: c1 + 2 c2 s + 3 c3 s² = 0."""
    _, c1, c2, c3 = row
    under = c2 * c2 - 3 * c1 * c3
    if under < 0.0:
        return
    half = -(c2 + math.copysign(math.sqrt(under), c2))
    for top, bottom in ((half, 3 * c3), (c1, half)):
        if bottom != 0.0 and 0.0 < top / bottom < length:
            yield top / bottom


def derivative_at(row: Row, s: Any, order: int) -> Any:
    """A derivative of a piece, `s` from its left knot."""
    c0, c1, c2, c3 = row
    if order == 0:
        return c0 + s * (c1 + s * (c2 + s * c3))
    if order == 1:
        return c1 + s * (2 * c2 + s * (3 * c3))
    return 2 * c2 + s * (6 * c3) if order == 2 else 6 * c3 + 0 * s


Kind = Literal["linear", "pchip", "akima", "spline"]
Ends = Literal["not-a-knot", "natural"]

# measured: of the largest change of slope of the chords; smaller changes are ties, as in SciPy
_TIE = 1e-9

SMOOTH: dict[Kind, int] = {"linear": 0, "pchip": 1, "akima": 1, "spline": 2}
"""How many derivatives of a kind are continuous."""


def fit(
    name: str, x: Sequence[float], y: Sequence[float], periodic: bool, kind: Kind = "spline",
    ends: Ends = "not-a-knot", beyond: Beyond = "stop",
) -> Table:  # fmt: skip
    """The curve of a `kind` through points.

    Of x, strictly ascending, as many as `codegen.tables.table_function.FEWEST` asks for; of a
    periodic one the last y is the first. `ends` is the condition of a spline that does not repeat:
    at the ends the third derivative is continuous one knot further in, or the second is zero.
    """
    h = [b - a for a, b in pairwise(x)]
    rise = [(b - a) / step for (a, b), step in zip(pairwise(y), h, strict=True)]
    rows: list[Row] = [(y[k], m, 0.0, 0.0) for k, m in enumerate(rise)]
    if kind != "linear":
        if kind == "spline":
            slopes = _periodic_slopes(h, rise) if periodic else _open_slopes(h, rise, ends)
        elif kind == "pchip":
            slopes = _monotone_slopes(h, rise, periodic)
        else:
            slopes = _akima_slopes(rise, periodic)
        rows = [_piece(y[k], step, rise[k], *slopes[k : k + 2]) for k, step in enumerate(h)]
    if periodic:
        beyond = "stop"  # it has no ends
    return Table(name, tuple(x), tuple(rows), periodic, beyond, SMOOTH[kind], kind)


def _piece(value: float, h: float, rise: float, left: float, right: float) -> Row:
    """The cubic with a value at the left knot and slopes at both."""
    bend = (left + right - 2 * rise) / h
    return value, left, (rise - left) / h - bend, bend / h


def _open_slopes(h: list[float], rise: list[float], ends: Ends) -> list[float]:
    """Slopes at the knots of an open curve, for a condition at its ends."""
    inner = zip(pairwise(h), pairwise(rise), strict=True)
    sides = [3 * (b * c + a * d) for (a, b), (c, d) in inner]
    middle = [2 * (a + b) for a, b in pairwise(h)]
    if ends == "natural":
        return _tridiagonal(
            [0.0, *h[1:], 1.0], [2.0, *middle, 2.0], [1.0, *h[:-1], 0.0],
            [3 * rise[0], *sides, 3 * rise[-1]],
        )  # fmt: skip
    first, last = h[0] + h[1], h[-1] + h[-2]
    start = ((h[0] + 2 * first) * h[1] * rise[0] + h[0] ** 2 * rise[1]) / first
    end = (h[-1] ** 2 * rise[-2] + (2 * last + h[-1]) * h[-2] * rise[-1]) / last
    return _tridiagonal(
        [0.0, *h[1:], last], [h[1], *middle, h[-2]], [first, *h[:-1], 0.0], [start, *sides, end]
    )


def _periodic_slopes(h: list[float], rise: list[float]) -> list[float]:
    """Slopes at the knots of a closed curve: a cyclic system, by Sherman and Morrison's formula."""
    before, rise_before = [h[-1], *h[:-1]], [rise[-1], *rise[:-1]]
    diagonal = [2 * (a + b) for a, b in zip(before, h, strict=True)]
    rows = zip(before, h, rise_before, rise, strict=True)
    right = [3 * (b * c + a * d) for a, b, c, d in rows]
    corner, other, gamma = h[0], before[-1], -diagonal[0]
    diagonal[0] -= gamma
    diagonal[-1] -= corner * other / gamma
    x = _tridiagonal(h, diagonal, before, right)
    z = _tridiagonal(h, diagonal, before, [gamma, *[0.0] * (len(h) - 2), other])
    part = (x[0] + corner * x[-1] / gamma) / (1 + z[0] + corner * z[-1] / gamma)
    slopes = [a - part * b for a, b in zip(x, z, strict=True)]
    return [*slopes, slopes[0]]


def _tridiagonal(
    lower: list[float], diagonal: list[float], upper: list[float], right: list[float]
) -> list[float]:
    """The solution by elimination from the top."""
    pivots, sides = [diagonal[0]], [right[0]]
    for k in range(1, len(diagonal)):
        factor = lower[k] / pivots[-1]
        pivots.append(diagonal[k] - factor * upper[k - 1])
        sides.append(right[k] - factor * sides[-1])
    x = [sides[-1] / pivots[-1]]
    for k in range(len(diagonal) - 2, -1, -1):
        x.append((sides[k] - upper[k] * x[-1]) / pivots[k])
    return x[::-1]


def _monotone_slopes(h: list[float], rise: list[float], periodic: bool) -> list[float]:
    """Slopes of the curve that is monotone where the data are, "pchip".

    F. N. Fritsch and J. Butland, SIAM Journal on Scientific and Statistical Computing 5, 1984,
    300-304; at the ends C. Moler, Numerical Computing with MATLAB, 2004, section 3.6.
    """
    if len(h) == 1:
        return [rise[0], rise[0]]
    inner = [_mean(*steps, *chords) for steps, chords in _neighbours(h, rise)]
    if periodic:
        joint = _mean(h[-1], h[0], rise[-1], rise[0])
        return [joint, *inner, joint]
    return [_end(*h[:2], *rise[:2]), *inner, _end(*h[:-3:-1], *rise[:-3:-1])]


def _neighbours(
    h: list[float], rise: list[float]
) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    return list(zip(pairwise(h), pairwise(rise), strict=True))


def _mean(before: float, behind: float, left: float, right: float) -> float:
    """The weighted harmonic mean of two chords' slopes; 0 where they differ in sign."""
    if left == 0.0 or right == 0.0 or (left < 0.0) != (right < 0.0):
        return 0.0
    one, other = 2 * behind + before, behind + 2 * before
    return (one + other) / (one / left + other / right)


def _end(h0: float, h1: float, m0: float, m1: float) -> float:
    """The slope of the parabola through three points at the first, as far as it keeps the shape."""
    slope = ((2 * h0 + h1) * m0 - h0 * m1) / (h0 + h1)
    if m0 == 0.0 or slope == 0.0 or (slope < 0.0) != (m0 < 0.0):
        return 0.0
    turns = m1 == 0.0 or (m0 < 0.0) != (m1 < 0.0)
    return 3 * m0 if turns and abs(slope) > 3 * abs(m0) else slope


def _akima_slopes(rise: list[float], periodic: bool) -> list[float]:
    """Slopes of the chords beside each point, weighted by the changes of slope beyond.

    H. Akima, Journal of the ACM 17, 1970, 589-602.
    """
    if periodic:
        m = [*rise[-2:], *rise, *rise[:2]] if len(rise) > 1 else rise * 5
    else:
        m = list(rise)
        for _ in range(2):
            first, last = (2 * m[0] - m[1], 2 * m[-1] - m[-2]) if len(m) > 1 else (m[0], m[0])
            m = [first, *m, last]
    change = [abs(b - a) for a, b in pairwise(m)]
    weights = [(change[k + 2], change[k]) for k in range(len(rise) + 1)]
    largest = max(a + b for a, b in weights)
    slopes = []
    for k, (left, right) in enumerate(weights):
        if left + right > _TIE * largest:
            slopes.append((left * m[k + 1] + right * m[k + 2]) / (left + right))
        else:
            slopes.append(0.5 * (m[k] + m[k + 3]))
    return slopes
