"""Sizes of a picture's signs, its typical length, and the places where elements hold its bodies.

Sizes are parts of the typical length of the picture, so that machines of all sizes look alike.
"""

from collections.abc import Iterator

import numpy as np

from codegen.drawing.contact_points import contact_line, heights, is_far, sides_of, slopes_of
from codegen.drawing.picture import Picture, places
from codegen.drawing.polygons import FloatArray, distinct, in_frame, placed
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
)  # fmt: skip

BAR = 0.021  # layout: half width of a bar, in typical lengths
PIN = 0.0115  # layout: radius of a pin
SLOT = 0.016  # layout: half width of a slot
CHEEK = 0.034  # layout: half width of a bar with a slot
BLOCK = (0.062, 0.038)  # layout: half length and half width of a block on a guide
BOB = 0.036  # layout: radius of the disc at a centre of mass
PARTICLE = 0.026  # layout: radius of a body that nothing holds
SAME = 2e-3  # layout: places nearer than this are one
HATCH = 0.0155  # layout: distance of the strokes of a hatching
_HOLDING = (Pin, Rod, Fixing, Bearing, Spring, Mark, Force, Trace)


def typical_length(picture: Picture, motion: FloatArray | None = None) -> float:
    """The diagonal of the box about all places of the shapes and the bodies' origins, m.

    Wheels count with their circles. The length is 1 m where everything is at one place. Origins
    count only where no element holds the body, or one: a centre of mass may be far away. Surfaces
    of contacts count where a body comes near, over the poses of a motion (instants, bodies, 3).
    """
    points = [picture.position(at) for symbol in picture.symbols for at in places(symbol.shape)]
    for symbol in picture.symbols:
        for place, radius in circles_of(symbol.shape):
            x, y = picture.position(place)
            points += [(x - radius, y - radius), (x + radius, y + radius)]
    for number in range(1, len(picture.bodies)):
        if len(distinct(held_places(picture, number), 0.0)) < 2:
            points.append((float(picture.poses[number, 0]), float(picture.poses[number, 1])))
    for number, body in enumerate(picture.bodies):
        if not body.is_derived:
            for outline in body.outlines:
                ends = placed(np.array(outline), picture.poses[number])
                points += [(float(x), float(y)) for x, y in (ends.min(axis=0), ends.max(axis=0))]
    length = _diagonal(points)
    for _, _, side in sides_of(picture):
        line = contact_line(slopes_of(side), picture.poses[side.body][None])
        near = length == 0.0 or not is_far(heights(picture, side, motion), length)
        if side.is_grounded and near:
            points += [
                tuple(line.center[0]),
                tuple((line.center - line.gap[:, None] * line.normal)[0]),
            ]
    length = _diagonal(points)
    return length if length > 0 else 1.0


def _diagonal(points: list[tuple[float, float]]) -> float:
    """The diagonal of the box about the points that are finite, m; 0 without one."""
    finite = np.array([p for p in points if np.all(np.isfinite(p))]).reshape(-1, 2)
    return float(np.hypot(*np.ptp(finite, axis=0))) if len(finite) else 0.0


def circles_of(shape: Shape) -> Iterator[tuple[Place, float]]:
    """Centres and radii of the wheels of a shape, m."""
    if isinstance(shape, Wheel):
        yield shape.center, abs(float(shape.radius))
    if isinstance(shape, Belt):
        yield shape.i, abs(float(shape.radius_i))
        yield shape.j, abs(float(shape.radius_j))


def held_places(picture: Picture, body: int) -> FloatArray:
    """Places (k, 2) of a body, in its frame, that joints, forces and traces take hold of, m.

    A contact takes hold of its centre of curvature: of a corner, or the centre of a disc.
    """
    found = [
        (place.x, place.y)
        for symbol in picture.symbols
        if isinstance(symbol.shape, _HOLDING) and not isinstance(symbol.shape, OppositeForce)
        for place in places(symbol.shape)
        if place.body == body
    ]
    for _, _, side in sides_of(picture):
        if side.body == body and (side.turn or side.bend):
            pose = picture.poses[body]
            center = in_frame(contact_line(slopes_of(side), pose[None]).center, pose)[0]
            found += [(float(center[0]), float(center[1]))] if np.all(np.isfinite(center)) else []
    return np.array(found, dtype=float).reshape(-1, 2)
