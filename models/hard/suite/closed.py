"""Motions in closed form, in multiple precision: elliptic functions, modes, quadratures.

A machine of one freedom that keeps its energy needs no integrator: with the inertia I(φ), felt at
φ, and the work W(φ) done since the start, φ̇² = (I0 ω0² + 2 W) / I, and t = ∫ dφ / φ̇.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mpmath as mp
import numpy as np

from models.hard.suite.case import Array

Number = Any  # an mpf; mpmath ships no types
DIGITS = 25


@dataclass(frozen=True)
class OneFreedom:
    """A machine of one freedom that starts at φ = `begin` with `speed`.

    Attributes
    ----------
    felt
        φ → (I, W): the inertia felt at φ in kg m², the work done on it since the start in J.
    """

    felt: Callable[[Number], tuple[Number, Number]]
    begin: Number
    speed: Number

    def rate(self, phi: Number) -> Number:
        """φ̇ at φ, while the machine moves forward."""
        inertia, work = self.felt(phi)
        start, _ = self.felt(self.begin)
        return mp.sqrt((start * self.speed**2 + 2 * work) / inertia)

    def time(self, start: Number, end: Number, pieces: int = 8) -> Number:
        """Seconds from φ = start to φ = end."""
        edges = mp.linspace(start, end, pieces + 1)
        return mp.quad(lambda phi: 1 / self.rate(phi), edges, method="gauss-legendre")

    def periodic(self, t: float) -> Number:
        """φ at the time t for a machine whose inertia and work repeat each turn."""
        turn = 2 * mp.pi
        period = self.time(self.begin, self.begin + turn)
        turns = mp.floor(t / period)
        left = mp.mpf(t) - turns * period
        # Newton's method on t(φ), of which only the part from the last guess on is new.
        phi = self.begin + turn * left / period
        reached = self.time(self.begin, phi)
        while True:
            change = (left - reached) * self.rate(phi)
            if abs(change) < mp.mpf(10) ** (6 - DIGITS):
                return turns * turn + phi
            reached += self.time(phi, phi + change, 1)
            phi += change


def pendulum(times: Array, swing: float, squared: Number) -> Array:
    """Angle from the vertical of a pendulum released from rest at `swing`, rad.

    θ = 2 arcsin(k sn(K - ω0 t | k²)) with k = sin(swing / 2) and ω0² = `squared`: a point mass has
    g / ℓ, a uniform bar 3 g / (2 ℓ).
    """
    with mp.workdps(DIGITS):
        k = mp.sin(mp.mpf(swing) / 2)
        quarter, omega = mp.ellipk(k**2), mp.sqrt(squared)
        found = [
            2 * mp.asin(k * mp.ellipfun("sn", quarter - omega * mp.mpf(float(t)), m=k**2))
            for t in times
        ]
        return np.array([float(angle) for angle in found])


def washboard(times: Array, begin: float, speed: float, k: float) -> Array:
    """Angle turned since the start by a rotor with φ̈ = -k sin φ that passes every crest, rad.

    φ = 2 am(u | m) with m = 4 k / ω², u = ω t / 2 and ω the speed at the bottom; u is shifted where
    the start is not at the bottom. `begin` is taken as the float that it is, turns and all.
    """
    with mp.workdps(DIGITS):
        offset = mp.mpf(begin) - 2 * mp.pi * mp.nint(mp.mpf(begin) / (2 * mp.pi))
        bottom = mp.sqrt(mp.mpf(speed) ** 2 + 2 * mp.mpf(k) * (1 - mp.cos(offset)))
        m = 4 * mp.mpf(k) / bottom**2
        quarter, shift = mp.ellipk(m), mp.ellipf(offset / 2, m)

        def amplitude(u: Number) -> Number:
            halves = mp.floor(u / (2 * quarter) + mp.mpf(1) / 2)
            return mp.asin(mp.ellipfun("sn", u - 2 * halves * quarter, m=m)) + halves * mp.pi

        turned = [2 * amplitude(bottom * mp.mpf(float(t)) / 2 + shift) - offset for t in times]
        return np.array([float(angle) for angle in turned])


def chain(times: Array, count: int, stiffness: float, mass: float, blow: float) -> Array:
    """Displacements of a chain fixed at one end, struck at the other, shape (k, count), m.

    ω_j = 2 √(k/m) sin(θ_j / 2) with θ_j = (2 j - 1) π / (2 n + 1); the shapes are sin(i θ_j).
    """
    theta = (2 * np.arange(1, count + 1) - 1) * np.pi / (2 * count + 1)
    shapes = np.sin(np.outer(np.arange(1, count + 1), theta))
    omega = 2 * np.sqrt(stiffness / mass) * np.sin(theta / 2)
    share = 4 / (2 * count + 1) * shapes[-1] * blow / omega
    return np.asarray(np.sin(np.outer(times, omega)) * share @ shapes.T)


def steps_of_force(times: Array, omega: float, jumps: tuple[tuple[float, float], ...]) -> Array:
    """Response z of z̈ + ω² z = -a(t) from rest, m; `jumps` are (time in s, change of a)."""
    z = np.zeros_like(times)
    for at, change in jumps:
        late = np.maximum(times - at, 0.0)
        z -= change / omega**2 * (1 - np.cos(omega * late))
    return z
