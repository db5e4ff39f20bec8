"""Where a machine moves in the next instants: its coordinates as a polynomial in time."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


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

    def at(self, s: float) -> FloatArray:
        """q after the time s."""
        q: FloatArray = s ** np.arange(len(self.series)) @ self.series
        return q

    def rate(self, s: float) -> FloatArray:
        """Its derivative."""
        powers = np.arange(1, len(self.series))
        v: FloatArray = (powers * s ** (powers - 1)) @ self.series[1:]
        return v


def taylor(t: float, q: FloatArray, v: FloatArray, a: FloatArray) -> Motion:
    """The motion with these derivatives."""
    return Motion(t, np.stack([q, v, 0.5 * a]))


def hermite(
    t: float, h: float, start: tuple[FloatArray, ...], end: tuple[FloatArray, ...]
) -> Motion:
    """The quintic with these q, v and a at both ends of a step."""
    q0, v0, a0 = start
    left = np.stack([end[0] - q0 - h * v0 - 0.5 * h * h * a0, end[1] - v0 - h * a0, end[2] - a0])
    right = np.array(
        [[h**3, h**4, h**5], [3 * h**2, 4 * h**3, 5 * h**4], [6 * h, 12 * h**2, 20 * h**3]]
    )
    units = h ** np.arange(3.0)
    rest = np.linalg.solve(units[:, None] * right, units[:, None] * left)
    return Motion(t, np.vstack([q0, v0, 0.5 * a0, rest]))
