"""A machine of one degree of freedom from the closed-form motion of its bodies.

One variable θ says where everything is. Then the energy is I(θ) θ̇² / 2 + V(θ), and the generalized
force along θ is I θ̈ + I' θ̇² / 2 + V': inverse dynamics without reactions, and dynamics by the
theorem of energy.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from models.studies.linkage import Track

FloatArray = npt.NDArray[np.float64]


class Mover(NamedTuple):
    """A body: mass in kg, inertia in kg m², path of its centre (complex) and angle over θ."""

    mass: float
    inertia: float
    centre: Track
    angle: Track


def inertia(movers: Sequence[Mover]) -> tuple[FloatArray, FloatArray]:
    """I = Σ m |r'|² + J φ'², 2 E_kin / θ̇², and its derivative in θ."""
    total = sum(m.mass * np.abs(m.centre.first) ** 2 + m.inertia * m.angle.first**2 for m in movers)
    slope = sum(
        2 * m.mass * (m.centre.first * np.conj(m.centre.second)).real
        + 2 * m.inertia * m.angle.first * m.angle.second
        for m in movers
    )
    return total, slope


def potential(movers: Sequence[Mover], g: float) -> tuple[FloatArray, FloatArray]:
    """V = Σ m g y, J, with gravity g along -y, m/s², and its derivative in θ."""
    height = sum(m.mass * g * m.centre.at.imag for m in movers)
    slope = sum(m.mass * g * m.centre.first.imag for m in movers)
    return height, slope


def force(movers: Sequence[Mover], g: float, rate: FloatArray, second: FloatArray) -> FloatArray:
    """What must act along θ, J per unit of θ, for θ̇ = `rate` and θ̈ = `second`."""
    total, slope = inertia(movers)
    return total * second + 0.5 * slope * rate**2 + potential(movers, g)[1]


def period(slowness: Callable[[FloatArray], FloatArray], left: float, right: float) -> float:
    """Time from one turning point to the other and back, s: 2 ∫ dθ/θ̇.

    θ = middle + half sin w takes the roots from both ends; what is left is smooth and, continued by
    reflection, periodic in w, so that the midpoint rule converges faster than any power.

    Parameters
    ----------
    slowness
        1/|θ̇| at each θ, s per unit of θ.
    left, right
        The turning points.
    """
    count = 400
    w = np.pi * ((np.arange(count) + 0.5) / count - 0.5)
    middle, half = (left + right) / 2, (right - left) / 2
    return float(2 * np.sum(slowness(middle + half * np.sin(w)) * half * np.cos(w)) * np.pi / count)


def duration(slowness: Callable[[FloatArray], FloatArray], left: float, right: float) -> float:
    """Time from rest at `left` to `right`, s, by Gauss's rule: θ̇ grows as the root of θ - left."""
    edges = np.sqrt(np.linspace(0.0, right - left, 2 + int(16 * (right - left) / np.pi)))
    nodes, weights = np.polynomial.legendre.leggauss(24)
    half = 0.5 * np.diff(edges)[:, None]
    s = edges[:-1, None] + half * (nodes + 1)
    values = 2 * s * slowness(left + (s * s).ravel()).reshape(s.shape)
    return float((half * weights * values).sum())
