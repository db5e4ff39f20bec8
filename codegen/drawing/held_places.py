"""The places where elements hold the bodies of a picture, and its typical length."""

from collections.abc import Iterator

import numpy as np

from codegen.drawing.contacts import contact_line, heights, is_far, sides_of
from codegen.drawing.picture import Picture
from codegen.drawing.plane_geometry import FloatArray, Points, distinct, origin
from codegen.drawing.shapes import (
    Bearing,
    Belt,
    Fixing,
    Force,
    Mark,
    OppositeForce,
    Pin,
    Place,
    Rod,
    Shape,
    Spring,
    Trace,
    Wheel,
    places,
)  # fmt: skip

_HOLDING = (Pin, Rod, Fixing, Bearing, Spring, Mark, Force, Trace)


def typical_length(picture: Picture, motion: FloatArray | None = None) -> float:
    """The diagonal of the box about all places of the shapes and the bodies' origins, m.

    Wheels count with their circles. The length is 1 m where everything is at one place. Origins
    count only where no element holds the body, or one: a centre of mass may be far away. Surfaces
    of contacts count where a body comes near, over the poses of a motion (instants, bodies, 3).
    """
    points = [picture.at(place) for symbol in picture.symbols for place in places(symbol.shape)]
    for symbol in picture.symbols:
        for place, radius in circles_of(symbol.shape):
            points += [picture.at(place) + way * radius for way in (-1 - 1j, 1 + 1j)]
    for number, body in enumerate(picture.bodies):
        if number > 0 and len(distinct(held_places(picture, number), 0.0)) < 2:
            points.append(origin(picture.poses[number]))
        if not body.is_derived:
            points += [z for line in body.polygons for z in picture.placed(line, number)]
    length = _diagonal(points)
    for number, _, side in sides_of(picture):
        line = contact_line(picture.still, number)
        near = length == 0.0 or not is_far(heights(picture, number, motion), length)
        if side.is_grounded and near:
            points += [*line.center, *(line.center - line.gap * line.normal)]
    length = _diagonal(points)
    return length if length > 0 else 1.0


def _diagonal(points: list[complex]) -> float:
    """The diagonal of the box about the points that are finite, m; 0 without one."""
    known = np.array(points)[np.isfinite(points)]
    return float(np.hypot(np.ptp(known.real), np.ptp(known.imag))) if len(known) else 0.0


def circles_of(shape: Shape) -> Iterator[tuple[Place, float]]:
    """Centres and radii of the wheels of a shape, m."""
    if isinstance(shape, Wheel):
        yield shape.center, abs(shape.radius)
    if isinstance(shape, Belt):
        yield shape.i, abs(shape.radius_i)
        yield shape.j, abs(shape.radius_j)


def held_places(picture: Picture, body: int) -> Points:
    """Places (k,) of a body, in its frame, that joints, forces and traces take hold of, m.

    A contact takes hold of its centre of curvature: of a corner, or the centre of a disc.
    """
    found = [
        place.point
        for _, shape in picture.having(*_HOLDING)
        if not isinstance(shape, OppositeForce)
        for place in places(shape)
        if place.body == body
    ]
    for number, _, side in sides_of(picture):
        if side.body == body and (side.turn or side.bend):
            center = contact_line(picture.still, number).center
            found += list(picture.in_body(center[np.isfinite(center)], body))
    return np.array(found, dtype=complex)
