"""The positions of a driven machine as a curve, followed by its length and not by time.

z = (q / scale, t rate). On the curve [Phi_q, Phi_t] keeps its rank where Phi_q alone does not: a
fold, in which t turns back, is a point like any other, and so is a sharp bend close to a position
in which two such curves would cross. Each step goes along the tangent and returns in the plane
across it (H. B. Keller's pseudo-arclength). The determinant of [Phi_q, Phi_t; tangent] keeps its
sign on one curve: a step that changes it has landed on another one.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from runtime.mechanism.dense_equations import FloatArray, row_lengths
from runtime.singularity.scaled_constraints import ScaledConstraints

_LARGEST = 0.2  # measured: longest step along the curve, scaled
# accuracy: shortest step along the curve, scaled: √EPS, within which curves that cross are one
_SMALLEST = 1e-8
_STRAIGHT = 0.995  # measured: cosine of two tangents above which the next step may grow
_BENT = 0.95  # measured: cosine of two tangents below which a step is too long
_ITERATIONS = 8  # safety: Newton iterations of a corrector
_MOST_STEPS = 4000  # safety: steps of one trace
_ROOT = 200  # safety: iterations of the search for a root along the curve


class Point(NamedTuple):
    """A point of the curve and the unit tangent there, both (n + 1,); `sign` of the determinant."""

    z: FloatArray
    tangent: FloatArray
    sign: float


class Piece(NamedTuple):
    """From `start` along its tangent by the length `h`, to `end`."""

    start: Point
    h: float
    end: Point


class Trace(NamedTuple):
    """A stretch of the curve; it ends in a fold, where it was to end, or, `lost`, nowhere."""

    pieces: list[Piece]
    folded: bool
    lost: bool


class Curve:
    """The curve of positions near a state."""

    def __init__(
        self, constraints: ScaledConstraints, t: float, q: FloatArray, rate: float
    ) -> None:
        self.constraints, self.rate = constraints, rate
        matrix = constraints.dense(constraints.entries(t, q, 1.0 / rate))
        self.lengths = row_lengths(matrix[:, :-1])

    def z(self, t: float, q: FloatArray) -> FloatArray:
        """Place of a position."""
        return np.append(q / self.constraints.scale, t * self.rate)

    def position(self, z: FloatArray) -> tuple[float, FloatArray]:
        """t in s and q, shape (n,)."""
        return float(z[-1]) / self.rate, z[:-1] * self.constraints.scale

    def velocity(self, point: Point) -> FloatArray:
        """dq/dt, shape (n,)."""
        v: FloatArray = point.tangent[:-1] / point.tangent[-1] * self.rate * self.constraints.scale
        return v

    def matrix(self, z: FloatArray) -> FloatArray:
        """[Phi_q, Phi_t] by z, rows of unit length at the start, shape (m, n + 1)."""
        t, q = self.position(z)
        entries = self.constraints.entries(t, q, 1.0 / self.rate)
        return self.constraints.dense(entries) / self.lengths[:, None]

    def gaps(self, z: FloatArray) -> FloatArray:
        """Phi, in units of the same rows, shape (m,)."""
        gaps: FloatArray = self.constraints.gaps(*self.position(z)) / self.lengths
        return gaps

    def narrowness(self, point: Point) -> float:
        """The smallest singular value of Phi_q."""
        return float(np.linalg.svd(self.matrix(point.z)[:, :-1], compute_uv=False)[-1])

    def point(self, z: FloatArray, along: FloatArray) -> Point | None:
        """The point at z, its tangent in the direction of `along`; None beyond the numbers."""
        matrix = self.matrix(z)
        if not np.isfinite(matrix).all():
            return None
        tangent = np.linalg.svd(matrix)[2][-1]
        tangent = tangent if float(tangent @ along) >= 0.0 else -tangent
        return Point(z, tangent, float(np.linalg.slogdet(np.vstack([matrix, tangent]))[0]))

    def across(self, start: Point, h: float) -> Point | None:
        """The point that lies `h` along the tangent at `start`, and then across; None if none."""
        z = start.z + h * start.tangent
        before = np.inf
        for _ in range(_ITERATIONS):
            right = np.append(-self.gaps(z), 0.0)
            square = np.vstack([self.matrix(z), start.tangent])
            if not (np.isfinite(square).all() and np.isfinite(right).all()):
                return None
            step = np.linalg.lstsq(square, right, rcond=1e-14)[0]
            size = float(np.linalg.norm(step))
            if size > max(abs(h), 1e-12):
                return None
            z = z + step
            if size < 1e-15 * (1.0 + float(np.linalg.norm(z))) or size > 0.5 * before < 1e-10:
                break
            before = size
        else:
            if size > 1e-12:
                return None
        return self.point(z, start.tangent)

    def trace(
        self, begin: Point, ahead: float, until: Callable[[Point], bool],
        avoid: FloatArray | None = None,
    ) -> Trace:  # fmt: skip
        """Follow the curve from `begin` until it folds back in time, or `until` says to stop.

        `ahead` is 1 where time is to grow, else -1. `avoid`: a place that the curve misses; steps
        are not longer than half the way to it.
        """
        pieces: list[Piece] = []
        point, h = begin, 0.01
        for _ in range(_MOST_STEPS):
            if avoid is not None:
                h = min(h, max(0.5 * float(np.linalg.norm(point.z - avoid)), _SMALLEST))
            there = self.across(point, h)
            turned = np.nan if there is None else float(there.tangent @ point.tangent)
            if there is None or there.sign != point.sign or turned < _BENT:
                h *= 0.5
                if h < _SMALLEST:
                    return Trace(pieces, False, True)
                continue
            if ahead * there.tangent[-1] <= 0.0:
                s = self.locate(point, h, lambda there: float(there.tangent[-1]))
                pieces.append(Piece(point, s, self.across(point, s) or there))
                return Trace(pieces, True, False)
            pieces.append(Piece(point, h, there))
            if until(there):
                return Trace(pieces, False, False)
            if turned > _STRAIGHT:
                h = min(1.5 * h, _LARGEST)
            point = there
        return Trace(pieces, False, True)

    def at_time(self, piece: Piece, t: float) -> Point:
        """The point of a piece at the instant t, which lies within it."""
        s = self.locate(piece.start, piece.h, lambda there: float(there.z[-1]) - t * self.rate)
        return self.across(piece.start, s) or piece.end

    def locate(self, start: Point, h: float, function: Callable[[Point], float]) -> float:
        """Length from `start` at which a function, of the other sign at `h`, of points vanishes.

        Regula falsi with the Illinois rule, a bisection every fourth time: it ends with neighbours.
        """

        def value(s: float) -> float:
            there = self.across(start, s)
            return np.nan if there is None else function(there)

        low, high, f_low, f_high = 0.0, h, function(start), value(h)
        if f_low == 0.0 or f_high == 0.0 or not np.isfinite(f_high):
            return low if f_low == 0.0 else high
        for iteration in range(_ROOT):
            if high - low <= 4e-16 * high:
                break
            middle = high - f_high * (high - low) / (f_high - f_low)
            if iteration % 4 == 3 or not low < middle < high:
                middle = 0.5 * (low + high)
            f = value(middle)
            if f == 0.0 or not np.isfinite(f):
                return middle
            if (f > 0.0) == (f_high > 0.0):
                high, f_high, f_low = middle, f, 0.5 * f_low
            else:
                low, f_low, f_high = middle, f, 0.5 * f_high
        return 0.5 * (low + high)
