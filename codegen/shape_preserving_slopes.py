"""Slopes at the points of a table that follow the data nearby: little or nothing overshoots.

As in `codegen.cubic_spline`, one operation of Python's own floats after the other. `h` are the
distances of the points and `rise` the slopes of the chords between them.
"""

from itertools import pairwise

# measured: of the largest change of slope of the chords; smaller changes are ties, as in SciPy
_TIE = 1e-9


def monotone_slopes(h: list[float], rise: list[float], periodic: bool) -> list[float]:
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


def akima_slopes(rise: list[float], periodic: bool) -> list[float]:
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
