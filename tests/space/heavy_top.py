"""A symmetric top on a fixed point under gravity, in closed form: elliptic functions.

Whittaker, Analytical Dynamics, section 71. With u = cos θ of the axis against the upward vertical,
J1 about a transverse axis through the point, u̇² is a cubic in u with roots u1 ≤ u2 ≤ 1 ≤ u3, and
u = u1 + (u2 - u1) sn². Precession and spin are elliptic integrals of the third kind.
"""

from typing import Any

import mpmath
import numpy as np
from mpmath import mp, mpf

from tests.space.elliptic import DIGITS, Jacobi, matrix, rounded, turn_x, turn_z

G = 9.81


class HeavyTop:
    """Attitude and nutation of a top whose centre of mass lies on the body's z axis.

    Parameters
    ----------
    mass, arm
        kg, and m from the fixed point to the centre of mass, along z′.
    transverse, axial
        J′ about the centre of mass, across the axis and along it, kg m².
    omega
        ω′ at t = 0, rad/s.
    attitude
        Rotation matrix at t = 0; the axis is not vertical, nor ever becomes so.
    gravity
        m/s², along -z.
    """

    def __init__(
        self, mass: float, arm: float, transverse: float, axial: float, omega: Any, attitude: Any,
        gravity: float = G,
    ) -> None:  # fmt: skip
        with mp.workdps(DIGITS):
            reach, J3 = mpf(arm), mpf(axial)
            J1 = mpf(transverse) + mpf(mass) * reach**2
            R, w = matrix(attitude), mpmath.matrix([mpf(float(x)) for x in omega])
            a, b = R[2, 0], R[2, 1]  # the vertical in body axes, and u, its third
            u = R[2, 2]
            weight = mpf(mass) * mpf(gravity) * reach
            along = J3 * w[2]
            vertical = J1 * (w[0] * a + w[1] * b) + along * u
            energy = (w[0] ** 2 + w[1] ** 2) * J1 / 2 + weight * u
            # u̇² = 2 (E - m g l u)(1 - u²)/J1 - ((p_ψ - p_φ u)/J1)²
            e, g, p, q = 2 * energy / J1, 2 * weight / J1, vertical / J1, along / J1
            roots = mpmath.polyroots([g, -e - q * q, 2 * p * q - g, e - p * p], maxsteps=500,
                                     extraprec=200)  # fmt: skip
            u1, u2, u3 = sorted(mpmath.re(root) for root in roots)
            u1, u2 = min(u1, u), max(u2, u)  # where it starts at rest, to the last digit
            self._u, self._momenta, self._along = (u1, u2), (p, q), along / J3
            self._functions = Jacobi((u2 - u1) / (u3 - u1))
            self._rate = mpmath.sqrt(g * (u3 - u1)) / 2
            falling = w[1] * a - w[0] * b  # u̇
            phase = mpmath.atan2(mpmath.sqrt(u - u1), mpmath.sqrt(u2 - u))
            self._first = self._functions.first_kind(phase if falling >= 0 else -phase)
            self._nus = (u2 - u1) / (1 - u1), -(u2 - u1) / (1 + u1)
            self._base = self._thirds(self._first)
            across = mpmath.sqrt(1 - u * u)
            # R = Rz(ψ) Rx(θ) Rz(φ), third row (sin θ sin φ, sin θ cos φ, cos θ)
            self._spin = mpmath.atan2(a, b)
            tilted = turn_x(u, across) * turn_z(self._spin)
            self._frame = R * tilted.T

    @property
    def nutation(self) -> tuple[float, float]:
        """Least and largest angle of the axis against the upward vertical, rad."""
        with mp.workdps(DIGITS):
            u1, u2 = self._u
            return float(mpmath.acos(u2)), float(mpmath.acos(u1))

    @property
    def nutation_period(self) -> float:
        """From one least angle to the next, s."""
        with mp.workdps(DIGITS):
            return float(2 * self._functions.quarter / self._rate)

    def attitude(self, t: float) -> Any:
        """The rotation matrix (3, 3) at an instant."""
        with mp.workdps(DIGITS):
            time = mpf(float(t))
            place = self._first + self._rate * time
            u1, u2 = self._u
            u = u1 + (u2 - u1) * self._functions(place)[0] ** 2
            below, above = (x - y for x, y in zip(self._thirds(place), self._base, strict=True))
            p, q = self._momenta
            # ψ̇ = (p - q u)/(1 - u²), φ̇ = ω3 - ψ̇ u, by partial fractions
            psi = ((p - q) * below + (p + q) * above) / 2
            phi = self._along * time - ((p - q) * below - (p + q) * above) / 2 - q * time
            tilt = turn_x(u, mpmath.sqrt(1 - u * u))
            return rounded(self._frame * turn_z(psi) * tilt * turn_z(self._spin + phi))

    def _thirds(self, place: Any) -> tuple[Any, Any]:
        """∫ dt / (1 - u) and ∫ dt / (1 + u), from a root."""
        u1, _ = self._u
        below, above = (self._functions.third_kind(nu, place) / self._rate for nu in self._nus)
        return below / (1 - u1), above / (1 + u1)


def sleeping_limit(mass: float, arm: float, transverse: float, axial: float) -> float:
    """The least spin at which an upright top stays upright, 2 √(m g l J1)/J3, rad/s."""
    J1 = transverse + mass * arm**2
    return 2.0 * float(np.sqrt(mass * G * arm * J1)) / axial


def fall_of_upright_top(
    spin: float, mass: float, arm: float, transverse: float, axial: float
) -> float:  # fmt: skip
    """The largest angle that an upright top reaches once disturbed; 0 at the limit and above."""
    u = 2.0 * (spin / sleeping_limit(mass, arm, transverse, axial)) ** 2 - 1.0
    return float(np.arccos(np.clip(u, -1.0, 1.0)))
