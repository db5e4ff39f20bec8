"""Outlines of bodies: closed lines of straight edges and arcs, and the holes in them.

An edge from p to q has a bulge, tan(θ/4) of the angle θ through which it turns to the left: 0 of a
straight line, 1 of a half circle that lies to the right of the way from p to q.
"""

from collections.abc import Iterator
from math import atan, ceil, cos, pi, sin
from typing import Any, Self

import sympy

from codegen.declare.body import expressions_in
from codegen.errors import ModelError
from codegen.readers.calls import declaring
from codegen.readers.quantities import in_unit
from codegen.readers.values import KindError, members, shown

CORNERS = 48  # layout: of the polygon that is drawn for a disc
Corner = tuple[Any, Any]  # (x', y') in m, numbers and expressions of parameters


class Outline(tuple[Corner, ...]):
    """The outline of a body, with holes; as a tuple the corners of a polygon that is drawn for it.

    `polygon`, `bar`, `disc`, `rectangle` and `read_outline` make them, for ``outline=`` and
    ``draw=`` of `Model.body`.

    Attributes
    ----------
    vertices
        Where edges meet, (x', y') in m.
    bulges
        One for the edge from each vertex to the next: 0 of a straight one, tan(θ/4) of an arc of
        the angle θ, positive to the left.
    holes
        The outlines of the holes.
    """

    vertices: tuple[Corner, ...]
    bulges: tuple[float, ...]
    holes: tuple["Outline", ...]

    def __new__(
        cls, vertices: tuple[Corner, ...], bulges: tuple[float, ...] = (), *,
        holes: tuple["Outline", ...] = (), drawn: tuple[Corner, ...] | None = None,
    ) -> Self:  # fmt: skip
        """Straight edges unless bulges are given; `drawn` are other corners for pictures."""
        bulges = bulges or (0.0,) * len(vertices)
        self = super().__new__(cls, flattened(vertices, bulges) if drawn is None else drawn)
        self.vertices, self.bulges, self.holes = vertices, bulges, holes
        return self

    @property
    def edges(self) -> Iterator[tuple[Corner, Corner, float]]:
        """(p, q, bulge) of each edge."""
        return zip(self.vertices, (*self.vertices[1:], self.vertices[0]), self.bulges, strict=True)

    def with_holes(self, *holes: Any) -> "Outline":
        """The same outline with more holes: outlines, or lists of corners."""
        made = tuple(one if isinstance(one, Outline) else polygon(one) for one in holes)
        return Outline(self.vertices, self.bulges, holes=(*self.holes, *made), drawn=tuple(self))


def flattened(
    vertices: tuple[Corner, ...], bulges: tuple[float, ...], corners: int = CORNERS
) -> tuple[Corner, ...]:
    """The vertices, and points between them on arcs, of which a whole turn has so many."""
    points: list[Corner] = []
    for k, (p, bulge) in enumerate(zip(vertices, bulges, strict=True)):
        points.append(p)
        (x, y), (end_x, end_y) = p, vertices[(k + 1) % len(vertices)]
        turn = 4.0 * atan(bulge)
        parts = ceil(abs(turn) / (2.0 * pi) * corners - 1e-9)
        for part in range(1, parts):
            half, gone = turn / 2.0, turn * part / parts / 2.0
            size = sin(gone) / sin(half)  # of the chord so far, in that of the arc
            along, left = size * cos(half - gone), -size * sin(half - gone)
            dx, dy = end_x - x, end_y - y
            points.append((x + along * dx - left * dy, y + along * dy + left * dx))
    return tuple(points)


@declaring("polygon")
def polygon(corners: Any) -> Outline:
    """The outline through corners.

    Parameters
    ----------
    corners
        ``[(x', y'), ...]``, m, three or more, in either direction: numbers, parameters, or
        expressions of them.
    """
    try:
        pairs = [members(corner, 2) for corner in members(corners)]
    except KindError:
        raise ModelError(
            f"polygon: {shown(corners)} is no list of corners; write [(0, 0), (1, 0), (0, 1)]."
        ) from None
    read = (expressions_in("m", "polygon", *pair) for pair in pairs)
    return Outline(tuple((x, y) for x, y in read))


@declaring("bar")
def bar(length: Any, width: Any, start: Corner = (0, 0), angle: Any = 0) -> Outline:
    """The outline of a bar with round ends, or of a slot.

    Parameters
    ----------
    length, width
        From the centre of one round end to that of the other, and across, m: numbers, parameters,
        or expressions of them.
    start
        (x', y') of the centre of the first end, m.
    angle
        Of the bar from the x' axis, rad.
    """
    a, w, x, y = expressions_in("m", "bar", length, width, *start)
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
    radius
        In m: a number, a quantity, a parameter, or an expression of them.
    center
        (x', y') in the body's axes, m.
    """
    x, y, radius = (in_unit(length, "m") for length in (*center, radius))
    angles = (2.0 * pi * k / CORNERS for k in range(CORNERS))
    drawn = tuple((x + radius * cos(angle), y + radius * sin(angle)) for angle in angles)
    return Outline(((x + radius, y), (x - radius, y)), (1.0, 1.0), drawn=drawn)


@declaring("rectangle")
def rectangle(width: Any, height: Any, center: Corner = (0, 0)) -> Outline:
    """The outline of a rectangle.

    Parameters
    ----------
    width, height
        Along x' and y', m: numbers, parameters, or expressions of them.
    center
        (x', y') in the body's axes, m.
    """
    x, y, a, b = (in_unit(length, "m") for length in (*center, width, height))
    a, b = a / 2, b / 2
    return Outline(((x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)))
