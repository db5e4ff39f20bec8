"""Taylor series of three terms along a motion, over arrays of numbers: exact first derivatives.

A jet holds a value, its rate, and half its second rate, each an array. The last entry of the arrays
belongs to the state itself, the ones before it to states that are moved by i h in one coordinate or
in time, whose imaginary parts over h are the partial derivatives.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

STEP = 1e-60


@dataclass(frozen=True)
class Jet:
    """c0 + c1 ε + c2 ε²."""

    c0: Any
    c1: Any = 0.0
    c2: Any = 0.0

    def __add__(self, other: Any) -> "Jet":
        if isinstance(other, Jet):
            return Jet(self.c0 + other.c0, self.c1 + other.c1, self.c2 + other.c2)
        return Jet(self.c0 + other, self.c1, self.c2)

    __radd__ = __add__

    def __neg__(self) -> "Jet":
        return Jet(-self.c0, -self.c1, -self.c2)

    def __sub__(self, other: Any) -> "Jet":
        return self + -other

    def __rsub__(self, other: Any) -> "Jet":
        return -self + other

    def __mul__(self, other: Any) -> "Jet":
        if isinstance(other, Jet):
            a, b = self, other
            middle = a.c0 * b.c2 + a.c1 * b.c1 + a.c2 * b.c0
            return Jet(a.c0 * b.c0, a.c0 * b.c1 + a.c1 * b.c0, middle)
        return Jet(self.c0 * other, self.c1 * other, self.c2 * other)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> "Jet":
        if isinstance(other, Jet):
            return self * other.mapped(1 / other.c0, -1 / other.c0**2, 2 / other.c0**3)
        return self * (1.0 / other)

    def mapped(self, value: Any, first: Any, second: Any) -> "Jet":
        """f of the jet, from f, f' and f'' at its value."""
        return Jet(value, first * self.c1, first * self.c2 + 0.5 * second * self.c1**2)


def sin(x: Any) -> Any:
    """Sine of a jet or a number."""
    if not isinstance(x, Jet):
        return np.sin(x)
    s, c = np.sin(x.c0), np.cos(x.c0)
    return x.mapped(s, c, -s)


def cos(x: Any) -> Any:
    """Cosine of a jet or a number."""
    if not isinstance(x, Jet):
        return np.cos(x)
    s, c = np.sin(x.c0), np.cos(x.c0)
    return x.mapped(c, -s, -c)


def sqrt(x: Jet) -> Jet:
    """Square root."""
    root = np.sqrt(x.c0)
    return x.mapped(root, 0.5 / root, -0.25 / (root * x.c0))


def variables(q: Any, v: Any, t: float) -> tuple[list[Jet], Jet]:
    """The coordinates and the time as jets of n + 2 entries, which move with velocity v and 1."""
    n = len(q)
    values = np.tile(np.append(q, t).astype(complex), (n + 2, 1)).T
    values[np.arange(n + 1), np.arange(n + 1)] += 1j * STEP
    jets = [Jet(row, speed) for row, speed in zip(values, (*v, 1.0), strict=True)]
    return jets[:-1], jets[-1]


@dataclass(frozen=True)
class Derivatives:
    """A scalar s(q, t) at a state: its value, s_q, s_t, ṡ, and s̈ without accelerations."""

    value: float
    by_q: Any
    by_t: float
    rate: float
    second: float


def derivatives(s: Jet, n: int) -> Derivatives:
    """The derivatives that a jet made of `variables` holds."""
    value = s.c0 if _is_array(s.c0) else np.full(n + 2, s.c0, complex)
    slopes = value.imag / STEP

    def last(x: Any) -> float:
        return float((x[-1] if _is_array(x) else x).real)

    return Derivatives(last(value), slopes[:n], float(slopes[n]), last(s.c1), 2.0 * last(s.c2))


def _is_array(x: Any) -> bool:
    return isinstance(x, np.ndarray) and x.ndim > 0
