"""Laws of motion from rest to rest, by the shapes of their accelerations.

A law leads from 0 to 1 while u runs from 0 to 1: s = c0 + c1 u + c2 u² + … + A sin(ω u + φ) in each
piece. Names and shapes are those of Norton, Cam Design and Manufacturing Handbook; the scale and
the constants follow from s = ṡ = 0 at u = 0, s = 1 at u = 1, and continuity.
"""

from functools import cache
from itertools import accumulate
from math import cbrt, sqrt
from typing import NamedTuple

import sympy
from sympy import pi, sin

Shape = tuple[tuple[sympy.Expr, sympy.Expr], ...]
"""The acceleration in each piece, to any scale, and u at the end of the piece."""
u = sympy.Symbol("u", real=True)

_EIGHTH, _RAMP = sympy.Rational(1, 8), sin(4 * pi * u)
SHAPES: dict[str, Shape] = {
    "harmonic": ((sympy.cos(pi * u), 1),),
    "cycloid": ((sin(2 * pi * u), 1),),
    "3-4-5": ((u - 3 * u**2 + 2 * u**3, 1),),
    "4-5-6-7": ((u**2 - 4 * u**3 + 5 * u**4 - 2 * u**5, 1),),
    "modified sine": (
        *((_RAMP, _EIGHTH), (sin(4 * pi * u / 3 + pi / 3), 7 * _EIGHTH), (_RAMP, 1)),
    ),
    "modified trapezoid": (
        *((_RAMP, _EIGHTH), (1, 3 * _EIGHTH), (-_RAMP, 5 * _EIGHTH), (-1, 7 * _EIGHTH)),
        (_RAMP, 1),
    ),
}
LIMITED = {"trapezoidal": 2, "S-curve": 3}
"""Laws that are as fast as limits allow → how many limits: speed, acceleration, jerk."""
_SHORTEST = 1e-12  # accuracy: of a move; a piece that rounding alone makes is none


class Piece(NamedTuple):
    """A piece of a law up to u = `end`: A, ω and φ, and c0, c1, …, c7."""

    end: float
    amplitude: float
    frequency: float
    phase: float
    polynomial: tuple[float, ...]


@cache
def pieces(shape: Shape) -> tuple[Piece, ...]:
    """The pieces of a law, of those of its acceleration."""
    found, begin, place, speed = list[tuple[float, sympy.Expr]](), 0.0, 0.0, 0.0
    for bend, end in shape:
        v = sympy.integrate(bend, u)
        v += speed - v.subs(u, begin)
        s = sympy.integrate(v, u)
        s += place - s.subs(u, begin)
        begin, place, speed = end, s.subs(u, end), v.subs(u, end)
        found.append((float(end), s))
    return tuple(_piece(end, sympy.expand(s / place)) for end, s in found)


def _piece(end: float, s: sympy.Expr) -> Piece:
    wave = next(iter(s.atoms(sin, sympy.cos)), sin(0))
    size = s.coeff(wave)
    powers = sympy.Poly(s - size * wave, u).all_coeffs()[::-1]
    phase = float(pi / 2) if wave.has(sympy.cos) else 0
    sine = (size, *(wave.args[0].coeff(u, k) for k in (1, 0))) if size else (0, 0, 0)
    a, w, shift = map(float, sine)
    return Piece(end, a, w, shift + phase, (*map(float, powers), *(0.0,) * (8 - len(powers))))


def fastest(
    way: float, speed: float, acceleration: float, jerk: float
) -> tuple[float, tuple[Piece, ...]]:
    """How long a way takes from rest to rest within limits, and its law; jerk may be infinite.

    The profile of a double S of Biagiotti and Melchiorri, Trajectory Planning (2008).
    """
    full = acceleration / jerk
    ramp = min(full, sqrt(speed / jerk))
    rise = ramp + speed / acceleration if ramp == full else 2.0 * ramp
    if rise * speed > way:  # the speed is not reached
        ramp = min(full, cbrt(way / (2.0 * jerk)))
        rise = (ramp + sqrt(ramp**2 + 4.0 * way / acceleration)) / 2 if ramp == full else 2.0 * ramp
        speed = way / rise
    length = rise + way / speed
    flat, coast = rise - 2.0 * ramp, length - 2.0 * rise
    ends = [*accumulate(w / length for w in (ramp, flat, ramp, coast, ramp, flat))]
    top = ramp / length or 1.0
    bends = (u, top, top + ends[1] - u, 0, ends[3] - u, -top, u - 1.0)
    parts = zip([0.0, *ends], map(sympy.sympify, bends), [*ends, 1.0], strict=True)
    return length, pieces(tuple((bend, e) for b, bend, e in parts if e - b > _SHORTEST))
