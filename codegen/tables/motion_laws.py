"""Laws of motion from rest to rest, by the shapes of their accelerations.

A law leads from 0 to 1 while u runs from 0 to 1: s = c0 + c1 x + c2 x² + … + A sin(ω x + φ) in each
piece, x = u - its `begin`. Names and shapes are those of Norton, Cam Design and Manufacturing
Handbook; scale and constants follow from s = ṡ = 0 at u = 0, s = 1 at u = 1, and continuity.
"""

from functools import cache
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
    """A piece of a law up to u = `end`: A, ω and φ, c0, c1, …, c7, and from where u counts."""

    end: float
    amplitude: float
    frequency: float
    phase: float
    polynomial: tuple[float, ...]
    begin: float = 0.0


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
    r, flat, rise = ramp / length, (rise - 2.0 * ramp) / length, rise / length
    top, a = speed * length / way, speed * length / (way * (r + flat))  # of ds/du, d²s/du²
    low, s = a * r / 2, a * r**2 / 6  # ds/du and s behind the first ramp
    behind, jump = s + flat * (low + a * flat / 2), a / r if r else 0.0
    rows = [  # u at its begin, length, s and its derivatives there
        (0.0, r, 0.0, 0.0, 0.0, jump), (r, flat, s, low, a, 0.0),
        (r + flat, r, behind, top - low, a, -jump), (rise, 1 - 2 * rise, top * rise / 2, top, 0, 0),
    ]  # fmt: skip
    both = zip(rows[2::-1], rows[:0:-1], strict=True)  # the end mirrors the begin
    rows += [(1 - n[0], own[1], 1 - n[2], n[3], -n[4], own[5]) for own, n in both]
    kept = [row for row in rows if row[1] > _SHORTEST]
    ends = [*(row[0] for row in kept[1:]), 1.0]
    return length, tuple(
        Piece(end, 0.0, 0.0, 0.0, (c0, c1, c2 / 2, c3 / 6, *(0.0,) * 4), begin)
        for (begin, _, c0, c1, c2, c3), end in zip(kept, ends, strict=True)
    )
