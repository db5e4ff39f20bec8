"""A rigid body free of moments in closed form: Jacobi's elliptic functions, attitude included.

Landau, Lifshitz, Mechanics, section 37. Worked in multiple precision, since a body that flips about
its middle axis spends most of its time near a pose where digits are lost.
"""

from typing import Any

import mpmath
import numpy as np
from mpmath import mp, mpf

from tests.space.elliptic import DIGITS, Jacobi, matrix, rounded, turn_x, turn_z


class FreeBody:
    """Angular velocity and attitude of a body with three different principal moments.

    Parameters
    ----------
    moments
        J′ of the principal axes x, y, z, kg m².
    omega
        ω′ at t = 0, in these axes, rad/s; not on the separatrix L² = 2 T J_middle.
    attitude
        Rotation matrix at t = 0, from body axes to global ones.
    """

    def __init__(self, moments: Any, omega: Any, attitude: Any = None) -> None:
        with mp.workdps(DIGITS):
            J = [mpf(float(x)) for x in moments]
            w = [mpf(float(x)) for x in omega]
            twice_energy = mpmath.fsum(a * b * b for a, b in zip(J, w, strict=True))
            momentum = mpmath.sqrt(mpmath.fsum((a * b) ** 2 for a, b in zip(J, w, strict=True)))
            order = sorted(range(3), key=lambda k: J[k])
            if (
                momentum**2 < twice_energy * J[order[1]]
            ):  # the axis of ω that keeps its sign is last
                order.reverse()
            axes = mpmath.zeros(3)
            for row, k in enumerate(order):
                axes[row, k] = 1
            axes[0, order[0]] *= mpmath.sign(mpmath.det(axes))  # a rotation, not a mirror
            self._axes = axes
            I1, I2, I3 = (J[k] for k in order)
            start = axes * mpmath.matrix(w)
            low, high = twice_energy * I3 - momentum**2, momentum**2 - twice_energy * I1
            sign = mpmath.sign(start[2])
            a1 = mpmath.sqrt(low / (I1 * (I3 - I1)))
            a2 = mpmath.sqrt(low / (I2 * (I3 - I2)))
            a3 = mpmath.sqrt(high / (I3 * (I3 - I1)))
            hand = mpmath.sign(I3 - I2)  # the sense of sn, where the order is reversed
            self._peaks = a1, hand * sign * a2, sign * a3
            self._rate = mpmath.sqrt((I3 - I2) * high / (I1 * I2 * I3))
            m = (I2 - I1) * low / ((I3 - I2) * high)
            self._functions = Jacobi(m)
            phase = mpmath.atan2(start[1] / self._peaks[1], start[0] / a1)
            self._first = self._functions.first_kind(phase)
            self._moments, self._momentum = (I1, I2, I3), momentum
            # ψ̇ = L/I3 + low L / (I3 (I1 a1)² (1 - ν sn²)) about the angular momentum
            self._nu = -((I3 * a3 / (I1 * a1)) ** 2) * m
            self._factor = momentum * low / (I3 * (I1 * a1) ** 2 * self._rate)
            self._base = self._functions.third_kind(self._nu, self._first)
            given = mpmath.eye(3) if attitude is None else matrix(attitude)
            _, level = self._tilt(mpf(0))
            self._frame = given * axes.T * level.T

    @property
    def flip_time(self) -> float:
        """From one reversal of the middle component of ω′ to the next, s."""
        with mp.workdps(DIGITS):
            return float(2 * self._functions.quarter / self._rate)

    def omega(self, t: float) -> Any:
        """ω′ (3,) in body axes at an instant."""
        with mp.workdps(DIGITS):
            return rounded(self._axes.T * self._tilt(mpf(float(t)))[0])

    def attitude(self, t: float) -> Any:
        """The rotation matrix (3, 3) at an instant."""
        with mp.workdps(DIGITS):
            time = mpf(float(t))
            _, level = self._tilt(time)
            third = self._functions.third_kind(self._nu, self._first + self._rate * time)
            psi = self._momentum * time / self._moments[2] + self._factor * (third - self._base)
            return rounded(self._frame * turn_z(psi) * level * self._axes)

    def _tilt(self, t: Any) -> tuple[Any, Any]:
        """ω in the sorted axes, and the rotation from there to axes with z along the momentum."""
        sn, cn, dn = self._functions(self._first + self._rate * t)
        a1, a2, a3 = self._peaks
        w = mpmath.matrix([a1 * cn, a2 * sn, a3 * dn])
        lx, ly, lz = (J * x / self._momentum for J, x in zip(self._moments, w, strict=True))
        across = mpmath.sqrt(lx * lx + ly * ly)
        about = matrix([[ly, -lx, 0], [lx, ly, 0], [0, 0, across]]) / across
        return w, turn_x(lz, across) * about


def kinetic_energy(moments: Any, omega: Any) -> float:
    """½ ω′ᵀ J′ ω′."""
    return 0.5 * float(np.dot(moments, np.square(omega)))
