"""Area, centre and polar moment of outlines, exactly, and why an outline has none.

Green's theorem turns integrals over an area into sums over its edges. Of an edge that is an arc the
segment between it and its chord is added, whose integrals are those of a chord of length 1 times
powers of the chord's length.
"""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import sympy

from codegen.declare.outlines import Corner, Outline, flattened
from codegen.drawing.plane_geometry import Points, area, contains, dot
from codegen.readers.expressions import plain_expression
from codegen.readers.values import plain_float

DIGITS = 60  # accuracy: flat arcs lose three digits of these for each one of their bulge
FINE = 96  # accuracy: corners of a whole turn where outlines are compared; arcs keep 5e-4 of r
ROWS = 256  # measured: edges that are compared with all others at once; a few MB
ROUNDING = 1e-15  # accuracy: of the lengths in sight; a coordinate of the centre below it is zero
SMALL = 1e-9  # accuracy: an area of less than this part of its box is none

Defaults = Mapping[sympy.Symbol, float]


class Area(NamedTuple):
    """An area, m², its centre, m, and its polar moment about the centre, m⁴."""

    size: sympy.Expr
    center: tuple[sympy.Expr, sympy.Expr]
    polar: sympy.Expr


def area_properties(outline: Outline, defaults: Defaults) -> Area:
    """Of an outline without its holes; expressions where its corners are.

    Parameters
    ----------
    defaults
        Parameter → its value, which says in which direction edges run round the area.
    """
    loops = (outline, *outline.holes)
    exact = any(
        plain_expression(e).free_symbols for one in loops for xy in one.vertices for e in xy
    )
    number = (lambda e: sympy.nsimplify(e, rational=True)) if exact else plain_float
    origin = tuple(map(number, outline.vertices[0]))  # sums about a far origin would cancel
    total = [number(0.0)] * 4
    for k, one in enumerate(loops):
        sums = _integrals(one, origin, number)
        sign = (1 if k == 0 else -1) * (1 if sympy.sympify(sums[0]).subs(defaults) > 0 else -1)
        total = [t + sign * s for t, s in zip(total, sums, strict=True)]
    size, sx, sy, polar = map(sympy.sympify, total)
    x, y, about = sx / size, sy / size, polar - (sx**2 + sy**2) / size
    center = (x + origin[0], y + origin[1])
    if not exact:
        around = ROUNDING * (abs(origin[0]) + abs(origin[1]) + sympy.sqrt(size))
        x, y = (c if abs(c) > around else sympy.S.Zero for c in center)
        return Area(size, (x, y), about)
    return Area(_tidy(size), (_tidy(center[0]), _tidy(center[1])), _tidy(about))


def _tidy(quotient: sympy.Expr) -> sympy.Expr:
    """A quotient of polynomials without common factors, as a sum where it is a polynomial."""
    reduced = sympy.cancel(quotient)
    return sympy.expand(reduced) if sympy.fraction(reduced)[1].is_number else reduced


def _integrals(outline: Outline, origin: Corner, number: Any) -> list[Any]:
    """∫ 1, x, y and x² + y² over the area to the left of the edges, about an origin."""
    total = [number(0.0)] * 4
    for p, q, bulge in outline.edges:
        (px, py), (qx, qy) = ([number(e) - o for e, o in zip(c, origin, strict=True)]
                              for c in (p, q))  # fmt: skip
        cross = px * qy - py * qx
        squares = px**2 + px * qx + qx**2 + py**2 + py * qy + qy**2
        parts = [cross / 2, (px + qx) * cross / 6, (py + qy) * cross / 6, cross * squares / 12]
        if bulge:
            segment, moment, about = (number(e) for e in _segment(bulge))
            dx, dy, mx, my = qx - px, qy - py, (px + qx) / 2, (py + qy) / 2
            chord = dx**2 + dy**2
            a, sx, sy = chord * segment, chord * moment * dy, -chord * moment * dx
            inertia = chord**2 * about + 2 * (mx * sx + my * sy) + a * (mx**2 + my**2)
            more = [a, sx + a * mx, sy + a * my, inertia]
            parts = [part + other for part, other in zip(parts, more, strict=True)]
        total = [t + part for t, part in zip(total, parts, strict=True)]
    return total


@cache
def _segment(bulge: float) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr]:
    """Between an arc and its chord of length 1: area, moment and polar moment about its middle.

    The moment is that of the distance from the chord to its right; it is the same where the arc
    lies to the left and takes the segment away.
    """
    b = sympy.S.One if abs(bulge) == 1 else sympy.Float(abs(bulge), DIGITS)
    radius, angle = (1 + b**2) / (4 * b), 4 * sympy.atan(b)
    height = (1 - b**2) / (4 * b)  # of the chord above the centre, negative behind it
    segment = radius**2 * angle / 2 - height / 2
    moment = sympy.Rational(1, 12) - height * segment
    polar = radius**4 * angle / 4 - height / 48 - height**3 / 4  # about the centre of the arc
    polar += height**2 * segment - height / 6
    sign = 1 if bulge > 0 else -1
    return sign * segment, moment, sign * polar


def outline_problems(outline: Outline, defaults: Defaults) -> Iterator[str]:
    """Why an outline bounds no area, or a hole is none in it, for the values of parameters."""
    names = ["the outline", *(f"hole {k}" for k in range(1, len(outline.holes) + 1))]
    loops = [_corners(one, defaults) for one in (outline, *outline.holes)]
    for name, loop in zip(names, loops, strict=True):
        box = np.ptp(loop.real) * np.ptp(loop.imag)
        if (place := _meeting(loop, loop)) is not None:
            yield f"{name} crosses itself at {_shown(place)}; give a line that does not."
            return
        if not abs(area(loop)) > SMALL * box:
            yield f"{name} has the area {abs(area(loop)):g} m^2; give corners around an area."
            return
    whole, *holes = loops
    for k, (name, hole) in enumerate(zip(names[1:], holes, strict=True), 1):
        if (place := _meeting(whole, hole)) is not None:
            yield f"{name} meets the outline at {_shown(place)}; give holes within it."
        elif not contains(whole, complex(hole[0])):
            yield f"{name} is outside of the outline, at {_shown(hole[0])}; give holes within it."
        for other, earlier in zip(names[1:k], holes, strict=False):
            place = _meeting(earlier, hole)
            if place is None and (contains(earlier, hole[0]) or contains(hole, earlier[0])):
                place = complex(hole[0])
            if place is not None:
                yield f"{name} and {other} overlap at {_shown(place)}; give holes apart."


def numbers_of(corners: tuple[Corner, ...], defaults: Defaults) -> Points:
    """Corners for the values of parameters, x + iy in m."""
    read = [plain_float(plain_expression(e).subs(defaults)) for corner in corners for e in corner]
    return np.array(np.reshape(read, (-1, 2)) @ [1, 1j])


def _corners(outline: Outline, defaults: Defaults) -> Points:
    """The corners of a fine polygon, x + iy in m."""
    vertices = numbers_of(outline.vertices, defaults)
    numbers = tuple((z.real, z.imag) for z in vertices.tolist())
    corners = np.array(flattened(numbers, outline.bulges, FINE)) @ [1, 1j]
    return np.array(corners[corners != np.roll(corners, 1)])


def _meeting(one: Points, other: Points) -> complex | None:
    """A place where edges of two polygons cross or touch; of one, such that are no neighbours."""
    c, d = other[None], np.roll(other, -1)[None]
    for first in range(0, len(one), ROWS):
        rows = np.arange(first, min(first + ROWS, len(one)))
        a, b = one[rows, None], one[(rows + 1) % len(one), None]
        near = np.ones((len(rows), len(other)), dtype=bool)
        for part in (np.real, np.imag):
            near &= np.maximum(part(c), part(d)) >= np.minimum(part(a), part(b))
            near &= np.maximum(part(a), part(b)) >= np.minimum(part(c), part(d))
        if one is other:
            apart = (rows[:, None] - np.arange(len(one))) % len(one)
            near &= (apart > 1) & (apart < len(one) - 1)
        for normal, ends in ((1j * (b - a), (c - a, d - a)), (1j * (d - c), (a - c, b - c))):
            near &= dot(normal, ends[0]) * dot(normal, ends[1]) <= 0.0
        if near.any():
            k, m = np.argwhere(near)[0]
            return _crossing(a[k, 0], b[k, 0], c[0, m], d[0, m])
    return None


def _crossing(a: Any, b: Any, c: Any, d: Any) -> complex:
    """Where two edges cross; of parallel ones the middle of what they share, nearly."""
    below = dot(1j * (d - c), b - a)
    return complex(a + (b - a) * dot(1j * (d - c), c - a) / below if below else (a + b + c + d) / 4)


def _shown(place: complex) -> str:
    return f"({place.real:.6g}, {place.imag:.6g}) m"
