"""Where a machine moves in the next instants: its coordinates as a polynomial in time."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from runtime.core.jit import compiled, inner
from runtime.core.signatures import f8, matrix, none, vector

FloatArray = NDArray[np.float64]

_PASSES = 4  # safety: Newton iterations for the nearest point of a motion
_QUINTIC = np.array([[10.0, -4.0, 0.5], [-15.0, 7.0, -1.0], [6.0, -3.0, 0.5]])
"""Coefficients of the powers 3 to 5 by what the lower ones leave of q, v and a at the end."""


class Motion(NamedTuple):
    """A motion near an instant: q(t + s) = Σ s^i series_i; `series` has shape (k + 1, n)."""

    t: float
    series: FloatArray

    @property
    def q(self) -> FloatArray:
        """The position now."""
        q: FloatArray = self.series[0]
        return q

    @property
    def v(self) -> FloatArray:
        """The velocity now."""
        v: FloatArray = self.series[1]
        return v

    def scaled(self, scale: FloatArray, speed: float) -> FloatArray:
        """The series of z = (q / scale, t speed), shape (k + 1, n + 1)."""
        n = scale.size
        series = np.zeros((len(self.series), n + 1))
        series[:, :n] = self.series / scale
        series[0, n], series[1, n] = self.t * speed, speed
        return series


def taylor(t: float, q: FloatArray, v: FloatArray, a: FloatArray) -> Motion:
    """The motion with these derivatives."""
    return Motion(t, np.stack([q, v, 0.5 * a]))


def hermite(
    t: float, h: float, start: tuple[FloatArray, ...], end: tuple[FloatArray, ...]
) -> Motion:
    """The quintic with these q, v and a at both ends of a step."""
    q0, v0, a0 = start
    series = np.empty((6, q0.size))
    series[0], series[1], series[2] = q0, v0, 0.5 * a0
    left = np.stack(
        [end[0] - q0 - h * v0 - 0.5 * h * h * a0, h * (end[1] - v0 - h * a0), h * h * (end[2] - a0)]
    )
    series[3:] = (_QUINTIC @ left) / np.array([[h**3], [h**4], [h**5]])
    return Motion(t, series)


@inner
def value(series: FloatArray, s: float, j: int) -> float:
    """Component j of a series after the time s."""
    total = 0.0
    for i in range(series.shape[0] - 1, -1, -1):
        total = total * s + series[i, j]
    return total


@inner
def slope(series: FloatArray, s: float, j: int) -> float:
    """The derivative of component j of a series after the time s."""
    total = 0.0
    for i in range(series.shape[0] - 1, 0, -1):
        total = total * s + i * series[i, j]
    return total


@compiled(none(matrix, f8, vector, vector))
def moved(series: FloatArray, s: float, z: FloatArray, rate: FloatArray) -> None:
    """Write z and dz/ds after the time s, (n + 1,)."""
    for j in range(series.shape[1]):
        z[j], rate[j] = value(series, s, j), slope(series, s, j)


@compiled(f8(matrix, f8, vector))
def nearest(series: FloatArray, s: float, z: FloatArray) -> float:
    """When a motion is nearest to z, in q, by Newton's iteration from the time `s` on."""
    for _ in range(_PASSES):
        along, square = 0.0, 0.0
        for j in range(series.shape[1] - 1):
            rate = slope(series, s, j)
            along += (value(series, s, j) - z[j]) * rate
            square += rate * rate
        s -= along / square
    return float(s)


@compiled(f8(matrix, f8, vector))
def distance(series: FloatArray, s: float, z: FloatArray) -> float:
    """How far a motion is from z after the time s, in q."""
    total = 0.0
    for j in range(series.shape[1] - 1):
        total += (value(series, s, j) - z[j]) ** 2
    return float(np.sqrt(total))
