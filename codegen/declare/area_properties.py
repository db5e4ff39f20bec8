"""Area, centre and polar moment of outlines, exactly.

Green's theorem turns integrals over an area into sums over its edges. Of an edge that is an arc the
segment between it and its chord is added, whose integrals are those of a chord of length 1 times
powers of the chord's length.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
import sympy

from codegen.declare.element_fields import Condition
from codegen.declare.outlines import Defaults, Outline
from codegen.drawing.plane_geometry import Corner
from codegen.readers.expressions import plain_expression
from codegen.readers.values import plain_float

DIGITS = 60  # accuracy: flat arcs lose three digits of these for each one of their bulge
ROUNDING = 1e-15  # accuracy: of the lengths in sight; a coordinate of the centre below it is zero


class Area(NamedTuple):
    """An area, m², its centre, m, and its polar moment about the centre, m⁴."""

    size: sympy.Expr
    center: tuple[sympy.Expr, sympy.Expr]
    polar: sympy.Expr


def area_condition(outline: Outline) -> Condition:
    """That an outline bounds an area, and its holes are holes in it."""
    loops = (outline, *outline.holes)
    numbers = tuple(plain_expression(e) for one in loops for xy in one.vertices for e in xy)
    return Condition("", numbers, low=None, bulges=tuple(one.bulges for one in loops))


def area_properties(outline: Outline, defaults: Defaults) -> Area:
    """Of an outline without its holes; expressions where its corners are.

    The values of parameters say in which direction edges run round an area.
    """
    loops = (outline, *outline.holes)
    exact = any(getattr(e, "free_symbols", ()) for one in loops for xy in one.vertices for e in xy)
    number = (lambda e: sympy.nsimplify(e, rational=True)) if exact else plain_float
    x, y = map(number, outline.vertices[0])  # sums about a far origin would cancel
    size, sx, sy, polar = (
        sympy.Add(*parts) for parts in zip(
            *(_integrals(one, (x, y), number, defaults, k > 0) for k, one in enumerate(loops)),
            strict=True,
        )
    )  # fmt: skip
    x, y, polar = x + sx / size, y + sy / size, polar - (sx**2 + sy**2) / size
    if exact:
        size, x, y, polar = map(_tidy, (size, x, y, polar))
    else:
        around = ROUNDING * (sympy.sqrt(size) + sum(map(abs, map(number, outline.vertices[0]))))
        x, y = (e if abs(e) > around else sympy.S.Zero for e in (x, y))
    return Area(size, (x, y), polar)


def _tidy(quotient: sympy.Expr) -> sympy.Expr:
    """A quotient of polynomials without common factors, as a sum where it is a polynomial."""
    reduced = sympy.cancel(quotient)
    return sympy.expand(reduced) if sympy.fraction(reduced)[1].is_number else reduced


def _integrals(
    outline: Outline, origin: Corner, number: Any, defaults: Defaults, is_hole: bool
) -> list[Any]:
    """∫ 1, x, y and x² + y² over an area, about an origin; of a hole their opposites."""
    total = [number(0.0)] * 4
    places = [(number(x) - origin[0], number(y) - origin[1]) for x, y in outline.vertices]
    for (px, py), (qx, qy), bulge in zip(
        places, places[1:] + places[:1], outline.bulges, strict=True
    ):
        cross, mx, my = px * qy - py * qx, (px + qx) / 2, (py + qy) / 2
        squares = px**2 + px * qx + qx**2 + py**2 + py * qy + qy**2
        parts = [cross / 2, mx * cross / 3, my * cross / 3, cross * squares / 12]
        if bulge:
            segment, moment, about = map(number, _segment(bulge))
            chord = (qx - px) ** 2 + (qy - py) ** 2
            a, sx, sy = chord * segment, chord * moment * (qy - py), chord * moment * (px - qx)
            polar = chord**2 * about + 2 * (mx * sx + my * sy) + a * (mx**2 + my**2)
            parts = [*np.add(parts, [a, sx + a * mx, sy + a * my, polar])]
        total = [*np.add(total, parts)]
    turns_left = sympy.sympify(total[0]).subs(defaults) > 0
    return total if turns_left != is_hole else [-whole for whole in total]


@cache
def _segment(bulge: float) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr]:
    """Between arc and chord of length 1: area, moment right of the chord, polar moment (middle)."""
    b = sympy.S.One if abs(bulge) == 1 else sympy.Float(abs(bulge), DIGITS)
    radius, angle = (1 + b**2) / (4 * b), 4 * sympy.atan(b)
    height = (1 - b**2) / (4 * b)  # of the chord above the centre, negative behind it
    segment = radius**2 * angle / 2 - height / 2
    moment = sympy.Rational(1, 12) - height * segment
    polar = radius**4 * angle / 4 - height / 48 - height**3 / 4  # about the centre of the arc
    polar += height**2 * segment - height / 6
    sign = 1 if bulge > 0 else -1
    return sign * segment, moment, sign * polar
