"""Outlines of bodies: closed lines of straight edges and arcs, with holes.

An edge has a bulge, tan(θ/4) of the angle θ through which it turns to the left: 0 of a straight
line, 1 of a half circle that lies to the right of the way along its chord.
"""

from collections.abc import Mapping
from math import cos, pi, sin
from typing import Any, Self

import numpy as np
import sympy

from codegen.declare.body import expressions_in
from codegen.drawing.plane_geometry import CORNERS, Corner, Points, area, flattened
from codegen.errors import ModelError
from codegen.readers.calls import declaring
from codegen.readers.expressions import plain_expression
from codegen.readers.quantities import in_unit
from codegen.readers.values import KindError, members, plain_float, shown

FEWEST = 3  # formula: corners of a polygon
Defaults = Mapping[sympy.Symbol, float]


class Outline(tuple[Corner, ...]):
    """The outline of a body, with holes; as a tuple it has the corners of a polygon for drawing.

    `vertices` are the ends of edges, (x', y') in m; `bulges` those of the edges that begin there.
    """

    vertices: tuple[Corner, ...]
    bulges: tuple[float, ...]
    holes: tuple["Outline", ...]

    def __new__(
        cls, vertices: "tuple[Corner, ...]", bulges: tuple[float, ...] = (), *,
        holes: "tuple[Outline, ...]" = (), drawn: "tuple[Corner, ...] | None" = None,
    ) -> Self:  # fmt: skip
        """Straight edges unless bulges are given; `drawn` are other corners for pictures."""
        bulges = bulges or (0.0,) * len(vertices)
        self = super().__new__(cls, flattened(vertices, bulges) if drawn is None else drawn)
        self.vertices, self.bulges, self.holes = vertices, bulges, holes
        return self

    def __repr__(self) -> str:
        """How many edges and holes."""
        return f"Outline({len(self.vertices)} edges, {len(self.holes)} holes)"

    def with_holes(self, *holes: Any) -> "Outline":
        """The same outline with more holes: outlines, or lists of corners."""
        made = tuple(one if isinstance(one, Outline) else polygon(one) for one in holes)
        return Outline(self.vertices, self.bulges, holes=(*self.holes, *made), drawn=tuple(self))


def numbers_of(corners: tuple[Corner, ...], defaults: Defaults) -> Points:
    """Corners for the values of parameters, x + iy in m."""
    read = [
        e if isinstance(e, float) else plain_float(plain_expression(e).subs(defaults))
        for corner in corners for e in corner
    ]  # fmt: skip
    return np.array(np.reshape(read, (-1, 2)) @ [1, 1j])


def polygon_with_holes(outline: Outline, defaults: Defaults) -> tuple[Corner, ...]:
    """Corners of an outline with holes as one closed polygon, as pictures draw it.

    The polygon goes round the outline, along a bridge to a hole, round it the other way, and back.
    Each hole is joined by the shortest way to what is joined already, so that no bridge leads over
    another; bridges are chosen for the values of parameters.
    """
    joined, *left = ([*zip(one, numbers_of(tuple(one), defaults), strict=True)]
                     for one in (outline, *outline.holes))  # fmt: skip
    side = np.sign(area(np.array([place for _, place in joined])))
    while left:
        ways = []
        for k, hole in enumerate(left):
            gaps = abs(np.subtract.outer([z for _, z in joined], [z for _, z in hole]))
            at, to = np.unravel_index(gaps.argmin(), gaps.shape)
            ways.append((gaps[at, to], k, int(at), int(to)))
        _, k, at, to = min(ways)
        hole = left.pop(k)
        hole = hole[to:] + hole[: to + 1]
        if side == np.sign(area(np.array([place for _, place in hole]))):
            hole.reverse()
        joined[at : at + 1] = [joined[at], *hole, joined[at]]
    return tuple(corner for corner, _ in joined)


@declaring("polygon")
def polygon(corners: Any) -> Outline:
    """The outline through corners.

    Parameters
    ----------
    corners
        ``[(x', y'), ...]``, m, three or more, in either direction: numbers, quantities, parameters,
        or expressions of them.
    """
    try:
        pairs = [members(corner, 2) for corner in members(corners)]
    except KindError:
        pairs = []
    if len(pairs) < FEWEST:
        raise ModelError(
            f"{shown(corners)} is no list of three corners or more; write [(0, 0), (1, 0), (0, 1)]."
        )
    read = (expressions_in("m", "polygon", *pair) for pair in pairs)
    return Outline(tuple((x, y) for x, y in read))


def _measures(where: str, place: Any, *sizes: Any) -> list[Any]:
    """x and y of a place, and sizes, which are more than 0, in m."""
    try:
        given = [*members(place, 2), *sizes]
    except KindError:
        raise ModelError(f"{where}: {shown(place)} is no place; write (0, 0).") from None
    for size, read in zip(sizes, expressions_in("m", where, *given)[2:], strict=True):
        if read.is_positive is False:
            raise ModelError(f"{where}: a size is {shown(size)}; give one that is more than 0.")
    return [in_unit(value, "m") for value in given]


@declaring("bar")
def bar(length: Any, width: Any, start: Corner = (0, 0), angle: Any = 0) -> Outline:
    """The outline of a bar with round ends, or of a slot.

    Parameters
    ----------
    length, width
        Distance of the centres of the round ends, and width across, m, as in `polygon`.
    start
        (x', y') of the centre of the first end, m.
    angle
        The angle of the bar from the x' axis, rad.
    """
    x, y, a, w = _measures("bar", start, length, width)
    (turn,) = expressions_in("rad", "bar", angle)
    c, s = sympy.cos(turn), sympy.sin(turn)
    corners = ((0, w / 2), (0, -w / 2), (a, -w / 2), (a, w / 2))
    placed = tuple((x + c * u - s * v, y + s * u + c * v) for u, v in corners)
    return Outline(placed, (1.0, 0.0, 1.0, 0.0))


@declaring("disc")
def disc(radius: Any, center: Corner = (0, 0)) -> Outline:
    """The outline of a disc, or of a round hole; in pictures a polygon with 48 corners.

    Parameters
    ----------
    radius, center
        In m, as in `polygon`.
    """
    x, y, radius = _measures("disc", center, radius)
    angles = (2.0 * pi * k / CORNERS for k in range(CORNERS))
    drawn = tuple((x + radius * cos(angle), y + radius * sin(angle)) for angle in angles)
    return Outline(((x + radius, y), (x - radius, y)), (1.0, 1.0), drawn=drawn)


@declaring("rectangle")
def rectangle(width: Any, height: Any, center: Corner = (0, 0)) -> Outline:
    """The outline of a rectangle.

    Parameters
    ----------
    width, height, center
        Along x' and y', m, as in `polygon`.
    """
    x, y, a, b = _measures("rectangle", center, width, height)
    a, b = a / 2, b / 2
    return Outline(((x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)))
