"""Curves through the points of a table: cubic splines, and others by kind.

The coefficients are computed with Python's own floats, one operation after the other: those of a
linear-algebra library differ in the last digit from machine to machine, and with them would the
generated text.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

from codegen.tables.piecewise_cubic import Beyond, Row, Table

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
