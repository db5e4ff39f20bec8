"""The motion of a machine near an instant: its coordinates as a polynomial in time."""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from runtime.core.arrays import Matrix, Vector, f8, matrix, none, vector
from runtime.core.jit import compiled, inner

_PASSES = 4  # safety: of Newton's method for the instant of the least distance


class Motion(NamedTuple):
    """A motion near an instant: q(t + s) = Σ s^i series_i; `series` has shape (k + 1, n)."""

    t: float
    series: Matrix

    @property
    def position(self) -> Vector:
        """q now, (n,); z of a scaled motion."""
        position: Vector = self.series[0]
        return position

    @property
    def velocity(self) -> Vector:
        """The rate of the position now, (n,)."""
        velocity: Vector = self.series[1]
        return velocity

    def at(self, s: float) -> tuple[Vector, Vector]:
        """Position and velocity after the time s, each (n,)."""
        q, v = np.empty((2, self.series.shape[1]))
        evaluate(self.series, s, q, v)
        return q, v

    def scaled(self, scale: Vector, speed: float) -> "Motion":
        """The motion of z = (q / scale, t speed), its series of shape (k + 1, n + 1)."""
        n = scale.size
        series = np.zeros((len(self.series), n + 1))
        series[:, :n] = self.series / scale
        series[0, n], series[1, n] = self.t * speed, speed
        return Motion(self.t, series)


def taylor(t: float, q: Vector, v: Vector, a: Vector) -> Motion:
    """The quadratic with this position, velocity and acceleration."""
    return Motion(t, np.array((q, v, 0.5 * a)))


def hermite(t: float, h: float, start: tuple[Vector, ...], end: tuple[Vector, ...]) -> Motion:
    """The quintic with these q, v and a at both ends of a step of length h."""
    return interpolate(t, h, (0, 0, 0, 1, 1, 1), (0, 1, 2, 0, 1, 2), np.array((*start, *end)))


def interpolate(
    t: float, unit: float, nodes: Sequence[float], orders: Sequence[int], values: Matrix
) -> Motion:
    """The polynomial of degree k - 1 in time with these derivatives (Birkhoff's interpolation).

    The derivative of order `orders` (k,), 0 being the position, is `values` (k, n) at the instants
    t + unit · `nodes`, s. (G. G. Lorentz, K. Jetter, S. D. Riemenschneider, Birkhoff Interpolation,
    1983, chapter 1.)
    """
    units = unit ** np.array(orders)[:, None]
    coefficients = _fit(tuple(nodes), tuple(orders)) @ (values * units)
    return Motion(t, coefficients / unit ** np.arange(len(nodes))[:, None])


@lru_cache(maxsize=8)
def _fit(nodes: tuple[float, ...], orders: tuple[int, ...]) -> Matrix:
    """The matrix that makes coefficients of derivatives; most fits share a few of them."""
    x, order, power = np.array(nodes)[:, None], np.array(orders)[:, None], np.arange(len(nodes))
    factors = np.ones((len(nodes), len(nodes)))
    for d in range(max(orders, default=0)):
        factors *= np.where(d < order, np.maximum(power - d, 0), 1)
    inverse: Matrix = np.linalg.inv(factors * x ** np.maximum(power - order, 0))
    return inverse


@inner
def value(series: Matrix, s: float, j: int) -> float:
    """Component j of a series after the time s."""
    total = 0.0
    for i in range(series.shape[0] - 1, -1, -1):
        total = total * s + series[i, j]
    return total


@inner
def slope(series: Matrix, s: float, j: int) -> float:
    """The derivative of component j of a series after the time s."""
    total = 0.0
    for i in range(series.shape[0] - 1, 0, -1):
        total = total * s + i * series[i, j]
    return total


@compiled(none(matrix, f8, vector, vector))
def evaluate(series: Matrix, s: float, z: Vector, rate: Vector) -> None:
    """Write z and dz/ds after the time s, (n + 1,)."""
    for j in range(series.shape[1]):
        z[j], rate[j] = value(series, s, j), slope(series, s, j)


@compiled(f8(matrix, f8, vector))
def nearest_time(series: Matrix, s: float, z: Vector) -> float:
    """The time at which a motion is nearest to z, which leaves out time, by Newton's method."""
    for _ in range(_PASSES):
        along, square = 0.0, 0.0
        for j in range(z.size):
            rate = slope(series, s, j)
            along += (value(series, s, j) - z[j]) * rate
            square += rate * rate
        s -= along / square
    return float(s)


@compiled(f8(matrix, f8, vector))
def distance(series: Matrix, s: float, z: Vector) -> float:
    """Distance of a motion from z, as in `nearest_time`, after the time s."""
    total = 0.0
    for j in range(z.size):
        total += (value(series, s, j) - z[j]) ** 2
    return float(np.sqrt(total))
