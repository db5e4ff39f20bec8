"""Outlines by which a body is drawn: polygons, discs and rectangles in its frame."""

from math import cos, pi, sin
from typing import Any

from codegen.readers.calls import declaring

CORNERS = 48  # layout: of the polygon that is drawn for a disc

Outline = tuple[tuple[Any, Any], ...]
"""Corners (x', y') of a closed polygon in the frame of its body, m."""


@declaring("disc")
def disc(radius: Any, center: tuple[Any, Any] = (0, 0)) -> Outline:
    """The outline of a disc, for ``draw=`` of `Model.body`.

    Parameters
    ----------
    radius
        In m: a number, a parameter, or an expression of them.
    center
        (x', y') in the body's frame, m.

    Returns
    -------
    tuple of (x', y')
        The corners of a polygon with 48 sides.
    """
    x, y = center
    angles = (2.0 * pi * k / CORNERS for k in range(CORNERS))
    return tuple((x + radius * cos(angle), y + radius * sin(angle)) for angle in angles)


@declaring("rectangle")
def rectangle(width: Any, height: Any, center: tuple[Any, Any] = (0, 0)) -> Outline:
    """The outline of a rectangle, for ``draw=`` of `Model.body`.

    Parameters
    ----------
    width, height
        Along x' and y', m: numbers, parameters, or expressions of them.
    center
        (x', y') in the body's frame, m.

    Returns
    -------
    tuple of (x', y')
        The four corners.
    """
    x, y = center
    a, b = width / 2, height / 2
    return (x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)
