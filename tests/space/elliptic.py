"""Elliptic functions and integrals through any number of periods, and rotations, in mpmath."""

from typing import Any

import mpmath
import numpy as np
from mpmath import mpf

DIGITS = 40


class Jacobi:
    """sn, cn and dn of a parameter m, 0 ≤ m < 1, with integrals of the first and third kind."""

    def __init__(self, m: Any) -> None:
        self.m = m
        self.quarter = mpmath.ellipk(m)

    def __call__(self, u: Any) -> tuple[Any, Any, Any]:
        """sn, cn and dn at u."""
        rest, turns = self._reduced(u)
        sn, cn, dn = (mpmath.ellipfun(name, rest, m=self.m) for name in ("sn", "cn", "dn"))
        sign = -1 if turns % 2 else 1
        return sign * sn, sign * cn, dn

    def first_kind(self, phi: Any) -> Any:
        """F(φ | m), for |φ| ≤ π."""
        turns = mpmath.nint(phi / mpmath.pi)
        return mpmath.ellipf(phi - turns * mpmath.pi, self.m) + 2 * turns * self.quarter

    def third_kind(self, nu: Any, u: Any) -> Any:
        """∫ du / (1 - ν sn² u) from 0 to u."""
        rest, turns = self._reduced(u)
        sn, cn = (mpmath.ellipfun(name, rest, m=self.m) for name in ("sn", "cn"))
        part = mpmath.ellippi(nu, mpmath.atan2(sn, cn), self.m)
        return part + 2 * turns * mpmath.ellippi(nu, self.m)

    def _reduced(self, u: Any) -> tuple[Any, int]:
        """u less half periods, in ±K."""
        turns = int(mpmath.nint(u / (2 * self.quarter)))
        return u - 2 * turns * self.quarter, turns


def turn_z(angle: Any) -> Any:
    """The rotation about z."""
    c, s = mpmath.cos(angle), mpmath.sin(angle)
    return matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def turn_x(c: Any, s: Any) -> Any:
    """The rotation about x by an angle of given cosine and sine."""
    return matrix([[1, 0, 0], [0, c, -s], [0, s, c]])


def matrix(of: Any) -> Any:
    """Three rows of numbers as a matrix of mpmath."""
    return mpmath.matrix([[x if isinstance(x, mpf) else mpf(float(x)) for x in row] for row in of])


def rounded(of: Any) -> Any:
    """A matrix or a vector of mpmath as floats."""
    found = np.array([[float(of[i, j]) for j in range(of.cols)] for i in range(of.rows)])
    return found[:, 0] if of.cols == 1 else found
