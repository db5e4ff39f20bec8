"""Cubic splines through points: plain numbers, which every stage may hold.

The coefficients are computed with Python's own floats, one operation after the other: those of a
linear-algebra library differ in the last digit from machine to machine, and with them would the
generated text.
"""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

MARGIN = 1e-9  # accuracy: rounding of a law's argument beyond its ends, in parts of its length

Row = tuple[float, float, float, float]


@dataclass(frozen=True)
class Table:
    """A function given by points: twice continuously differentiable, a cubic between two knots."""

    name: str  # an identifier
    knots: tuple[float, ...]  # ascending; the last of a periodic table is the first, a period later
    rows: tuple[Row, ...]  # (c0, c1, c2, c3): c0 + c1 s + c2 s² + c3 s³ with s from the left knot
    periodic: bool  # one that does not repeat is undefined (nan) beyond its ends

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the numbers."""
        return hashlib.sha256(repr((self.knots, self.rows, self.periodic)).encode()).hexdigest()

    def __call__(self, x: Any, order: int = 0) -> Any:
        """The value or a derivative at a number of any kind; complex numbers by their real part."""
        first, last = self.knots[0], self.knots[-1]
        at = float(getattr(x, "real", x))
        if self.periodic:
            turns = math.floor((at - first) / (last - first))
            x, at = x - turns * (last - first), at - turns * (last - first)
        elif not -MARGIN * (last - first) <= at - first <= (1 + MARGIN) * (last - first):
            return math.nan
        inner = sum(knot <= at for knot in self.knots[1:-1])
        s, (c0, c1, c2, c3) = x - self.knots[inner], self.rows[inner]
        if order == 0:
            return c0 + s * (c1 + s * (c2 + s * c3))
        if order == 1:
            return c1 + s * (2 * c2 + s * (3 * c3))
        return 2 * c2 + s * (6 * c3) if order == 2 else 6 * c3 + 0 * s


def fit(name: str, x: Sequence[float], y: Sequence[float], periodic: bool) -> Table:
    """The interpolating cubic spline: periodic, or with the not-a-knot condition at both ends.

    At least four points; x strictly ascending, and of a periodic one the last y the first.
    """
    h = [b - a for a, b in pairwise(x)]
    rise = [(b - a) / step for (a, b), step in zip(pairwise(y), h, strict=True)]
    slopes = _periodic_slopes(h, rise) if periodic else _open_slopes(h, rise)
    rows = []
    for k, step in enumerate(h):
        bend = (slopes[k] + slopes[k + 1] - 2 * rise[k]) / step
        rows.append((y[k], slopes[k], (rise[k] - slopes[k]) / step - bend, bend / step))
    return Table(name, tuple(x), tuple(rows), periodic)


def _open_slopes(h: list[float], rise: list[float]) -> list[float]:
    """Slopes at the knots, the third derivative continuous at the second and the last but one."""
    first, last = h[0] + h[1], h[-1] + h[-2]
    start = ((h[0] + 2 * first) * h[1] * rise[0] + h[0] ** 2 * rise[1]) / first
    end = (h[-1] ** 2 * rise[-2] + (2 * last + h[-1]) * h[-2] * rise[-1]) / last
    inner = zip(pairwise(h), pairwise(rise), strict=True)
    return _tridiagonal(
        [0.0, *h[1:], last],
        [h[1], *(2 * (a + b) for a, b in pairwise(h)), h[-2]],
        [first, *h[:-1], 0.0],
        [start, *(3 * (b * c + a * d) for (a, b), (c, d) in inner), end],
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
