"""Outlines of bodies for which the modeller gave none, from the places where elements hold them.

Sizes are parts of the typical length of the picture, so that machines of all sizes look alike.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from codegen.drawing.picture import BodyPicture, Outline, Picture, places
from codegen.drawing.polygons import (
    FloatArray,
    box,
    circle,
    distinct,
    in_frame,
    normal,
    placed,
    rounded_hull,
    unit,
)
from codegen.drawing.shapes import (
    Bearing,
    Belt,
    Fixing,
    Force,
    Mark,
    Pin,
    Place,
    Profile,
    Rack,
    Rod,
    Shape,
    Slide,
    Slot,
    Spring,
    Trace,
    Wheel,
)

BAR = 0.021  # layout: half width of a bar, in typical lengths
PIN = 0.0115  # layout: radius of a pin
SLOT = 0.016  # layout: half width of a slot
CHEEK = 0.034  # layout: half width of a bar with a slot
BLOCK = (0.062, 0.038)  # layout: half length and half width of a block on a guide
BOB = 0.042  # layout: radius of the disc at a centre of mass
PARTICLE = 0.026  # layout: radius of a body that nothing holds
SAME = 2e-3  # layout: places nearer than this are one
_HOLDING = (Pin, Rod, Fixing, Bearing, Spring, Mark, Force, Trace)


def typical_length(picture: Picture) -> float:
    """The diagonal of the box about all places of the shapes and the bodies' origins, m.

    Wheels count with their circles. The length is 1 m where everything is at one place. Origins
    count only where no element holds the body, or one: a centre of mass may be far away.
    """
    points = [picture.position(at) for symbol in picture.symbols for at in places(symbol.shape)]
    for symbol in picture.symbols:
        for place, radius in _circles(symbol.shape):
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
    finite = np.array([p for p in points if np.all(np.isfinite(p))]).reshape(-1, 2)
    length = float(np.hypot(*np.ptp(finite, axis=0))) if len(finite) else 0.0
    return length if length > 0 else 1.0


def _circles(shape: Shape) -> Iterator[tuple[Place, float]]:
    if isinstance(shape, Wheel):
        yield shape.center, abs(float(shape.radius))
    if isinstance(shape, Belt):
        yield shape.i, abs(float(shape.radius_i))
        yield shape.j, abs(float(shape.radius_j))


def held_places(picture: Picture, body: int) -> FloatArray:
    """Places (k, 2) of a body, in its frame, that joints, forces and traces take hold of, m."""
    found = [
        (place.x, place.y)
        for symbol in picture.symbols
        if isinstance(symbol.shape, _HOLDING)
        for place in places(symbol.shape)
        if place.body == body
    ]
    return np.array(found, dtype=float).reshape(-1, 2)


def derived_outlines(picture: Picture, motion: FloatArray | None = None) -> tuple[BodyPicture, ...]:
    """The bodies of a picture, each without outlines given those that follow from its elements.

    - Two places: a bar with round ends. Three and more: a rounded plate round their convex hull.
    - One place and the centre of mass apart: a bar to a disc about the centre of mass.
    - A block along each guide on which the body slides, a bar with room for each of its slots.
    - A disc for each wheel without teeth (those with teeth, rings and profiles are strokes of
      their own: `strokes.rigid_strokes`).
    - A body that nothing holds: a small disc.

    Parameters
    ----------
    motion
        Poses of a motion, shape (instants, bodies, 3), m and rad: guides and slots are as long as
        it needs. Without one they are as long as the picture's own pose needs.
    """
    return tuple(
        body
        if body.outlines or body.fixed or number == 0
        else replace(body, outlines=_outlines(picture, number, motion), is_derived=True)
        for number, body in enumerate(picture.bodies)
    )


def _outlines(picture: Picture, body: int, motion: FloatArray | None) -> tuple[Outline, ...]:
    size = picture.size
    polygons: list[FloatArray] = []
    seats: list[FloatArray] = []  # where a block is, or a wheel's hub: other places join to them
    bars: list[FloatArray] = []  # ends of guides and racks, which other places join in one point
    for symbol in picture.symbols:
        shape = symbol.shape
        if isinstance(shape, Slide):
            guide = guide_of(picture, shape)
            if guide.body == body:
                bars.append(guide_ends(picture, guide, motion))
                polygons.append(rounded_hull(bars[-1], BAR * size))
            if guide.block.body == body:
                center = np.array(guide.block[1:])
                polygons.append(box(center, guide.along_in_block, *(b * size for b in BLOCK)))
                seats.append(center)
        elif isinstance(shape, Slot) and shape.i.body == body:
            guide = guide_of(picture, shape)
            bars.append(guide_ends(picture, guide, motion))
            polygons.append(rounded_hull(bars[-1], CHEEK * size))
        elif isinstance(shape, Slot) and shape.j.body == body:
            seats.append(np.array(shape.j[1:]))
        elif isinstance(shape, Rack) and shape.i.body == body:
            below = -rack_side(picture, shape) * normal(unit(np.array([shape.ux, shape.uy], float)))
            bars.append(rack_ends(picture, shape, motion) + 0.8 * BAR * size * below)
            if not shape.toothed:
                polygons.append(box(*_middle_and_halves(bars[-1]), 0.8 * BAR * size))
        else:
            for place, radius in _circles(shape):
                if place.body == body:
                    seats.append(np.array(place[1:]))
                    if not (isinstance(shape, Wheel) and (shape.toothed or shape.internal)):
                        polygons.append(circle(seats[-1], abs(radius), 64))
            if isinstance(shape, Profile) and any(p.body == body for p in shape.curve):
                polygons += [*_profile_body(shape, held_places(picture, body), size)]
                seats.append(np.zeros(2))
    others = np.concatenate([np.array(seats).reshape(-1, 2), held_places(picture, body)])
    seats += [_nearest(bar, others.mean(axis=0) if len(others) else np.zeros(2)) for bar in bars]
    polygons += [*_links(picture, body, np.array(seats).reshape(-1, 2))]
    return tuple(tuple((float(x), float(y)) for x, y in polygon) for polygon in polygons)


def _middle_and_halves(ends: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Centre, direction and half length of a straight line (2, 2)."""
    reach = ends[1] - ends[0]
    return ends.mean(axis=0), unit(reach), float(np.hypot(*reach)) / 2


def _nearest(bar: FloatArray, point: FloatArray) -> FloatArray:
    """The place on a straight line (2, 2) that is nearest to a point."""
    reach = bar[1] - bar[0]
    square = float(reach @ reach)
    share = float((point - bar[0]) @ reach) / square if square > 0 else 0.0
    return bar[0] + np.clip(share, 0.0, 1.0) * reach


def _links(picture: Picture, body: int, seats: FloatArray) -> Iterator[FloatArray]:
    """Bars and plates between the places of a body, and the disc of a pendulum."""
    size = picture.size
    held = np.concatenate([held_places(picture, body), seats])
    held = distinct(held[np.all(np.isfinite(held), axis=1)], SAME * size)
    apart = len(held) == 1 and np.hypot(*held[0]) > SAME * size
    if len(held) == 0:
        yield circle(np.zeros(2), PARTICLE * size)
    elif apart and not len(seats):
        yield rounded_hull(np.array([held[0], [0.0, 0.0]]), 0.75 * BAR * size)
        yield circle(np.zeros(2), BOB * size)
    elif len(held) == 1 and not len(seats):
        yield circle(held[0], BOB * size)
    elif len(held) > 1:
        spread = float(np.max(np.hypot(*(held - held.mean(axis=0)).T)))
        if len(held) > 2 and np.hypot(*held.mean(axis=0)) < spread:
            held = np.concatenate([held, np.zeros((1, 2))])
        yield rounded_hull(held, BAR * size)


def _profile_body(shape: Profile, held: FloatArray, size: float) -> Iterator[FloatArray]:
    """The inside of a closed profile; an open one is a line alone, with bars to its middle."""
    curve = np.array([p[1:] for p in shape.curve], dtype=float)
    if is_closed(curve):
        yield curve
        return
    middle = curve[len(curve) // 2]
    for place in held if len(held) else np.zeros((1, 2)):
        if np.hypot(*(place - middle)) > SAME * size:
            yield rounded_hull(np.array([place, middle]), 0.75 * BAR * size)


def is_closed(curve: FloatArray) -> bool:
    """Whether the ends of a sampled curve (k, 2) are no farther apart than its samples are."""
    steps = np.hypot(*np.diff(curve, axis=0).T)
    return len(curve) > 3 and float(np.hypot(*(curve[-1] - curve[0]))) <= 2 * float(np.max(steps))


class Guide:
    """The guide of a slide or slot: on which body, through which place, along which direction.

    Attributes
    ----------
    body
        The body that has the guide: the ground where it takes part, since a block that slides in
        the ground is as well a guide that slides over a block.
    origin, along
        A place on the guide and its direction, in the frame of `body`.
    block
        The place of the other body that stays on it.
    along_in_block
        The direction of the guide in the frame of the other body.
    """

    def __init__(self, picture: Picture, i: Place, j: Place, along: FloatArray) -> None:
        turn = picture.poses[i.body, 2] - picture.poses[j.body, 2]
        c, s = np.cos(turn), np.sin(turn)
        other = np.array([c * along[0] - s * along[1], s * along[0] + c * along[1]])
        swapped = j.body == 0 or (picture.bodies[j.body].fixed and not picture.bodies[i.body].fixed)
        if swapped:
            i, j, along, other = j, i, other, along
        self.body, self.block = i.body, j
        self.origin = np.array(i[1:], dtype=float)
        self.along, self.along_in_block = along, other

    def travel(self, picture: Picture, motion: FloatArray | None) -> tuple[float, float]:
        """Least and greatest position of the block along the guide, from `origin`, m."""
        poses = picture.poses[None] if motion is None else motion
        block = np.array([[self.block.x, self.block.y]])
        s = [
            float((in_frame(placed(block, p[self.block.body]), p[self.body])[0] - self.origin)
                  @ self.along)
            for p in poses
        ]  # fmt: skip
        return min(s), max(s)


def guide_of(picture: Picture, shape: Slide | Slot) -> Guide:
    """The guide of a slide or slot; a slot is always on body i."""
    along = unit(np.array([shape.ux, shape.uy], dtype=float))
    guide = Guide(picture, shape.i, shape.j, along)
    if isinstance(shape, Slot) and guide.body != shape.i.body:
        guide.body, guide.block = shape.i.body, shape.j
        guide.origin, guide.along_in_block = np.array(shape.i[1:], dtype=float), guide.along
        guide.along = along
    return guide


def guide_ends(picture: Picture, guide: Guide, motion: FloatArray | None) -> FloatArray:
    """Where a guide begins and ends, in the frame of its body, shape (2, 2), m.

    It covers the travel of its block and the other places of its body that lie on the same line;
    without a motion it is longer than the block by its own length and more.
    """
    size = picture.size
    first, last = guide.travel(picture, motion)
    room = (BLOCK[0] if motion is not None else 0.22) * size
    first, last = first - room, last + room
    if guide.body:
        held = held_places(picture, guide.body) - guide.origin
        beside = held @ np.array([-guide.along[1], guide.along[0]])
        on_line = (held @ guide.along)[np.abs(beside) < SAME * size]
        if len(on_line):
            first, last = _extended(first, last, float(on_line.min()), float(on_line.max()), room)
    return guide.origin + np.outer([first, last], guide.along)


def _extended(
    first: float, last: float, least: float, most: float, room: float
) -> tuple[float, float]:
    """The reach of a guide that ends at the outermost places beyond it, where there are some."""
    middle = (first + last) / 2
    if least < middle:
        first = least if least < first + room else first
    if most > middle:
        last = most if most > last - room else last
    return first, last


def rack_ends(picture: Picture, shape: Rack, motion: FloatArray | None) -> FloatArray:
    """Where a rack or track begins and ends, in the frame of its body, shape (2, 2), m.

    It covers where the wheels of its element touch it, and a part of their circles more.
    """
    origin, along = np.array(shape.i[1:], dtype=float), unit(np.array([shape.ux, shape.uy], float))
    poses = picture.poses[None] if motion is None else motion
    s, room = [0.0], 0.25 * picture.size
    for wheel in wheels_of(picture, shape):
        hub = np.array([[wheel.center.x, wheel.center.y]])
        s = [
            float((in_frame(placed(hub, p[wheel.center.body]), p[shape.i.body])[0] - origin)
                  @ along)
            for p in poses
        ]  # fmt: skip
        room = abs(float(wheel.radius)) * (2.2 if motion is None else 1.1)
    return origin + np.outer([min(s) - room, max(s) + room], along)


def rack_side(picture: Picture, shape: Rack) -> float:
    """The side of a rack where its wheel or cam is: 1 on its left, -1 on its right.

    Where the element has neither, it is the upper side.
    """
    along = unit(np.array([shape.ux, shape.uy], dtype=float))
    heading = placed(along[None], np.array([0.0, 0.0, picture.poses[shape.i.body, 2]]))[0]
    elements = {symbol.element for symbol in picture.symbols if symbol.shape is shape}
    for symbol in picture.symbols:
        other = symbol.shape
        if symbol.element in elements and isinstance(other, Wheel | Profile):
            if isinstance(other, Wheel):
                at = np.array(picture.position(other.center))
            else:
                at = np.mean([picture.position(place) for place in other.curve], axis=0)
            d = at - np.array(picture.position(shape.i))
            return 1.0 if float(d @ normal(heading)) >= 0 else -1.0
    return 1.0 if heading[0] >= 0 else -1.0


def wheels_of(picture: Picture, shape: Shape) -> list[Wheel]:
    """The wheels of the element that has this shape."""
    elements = {symbol.element for symbol in picture.symbols if symbol.shape is shape}
    return [
        symbol.shape
        for symbol in picture.symbols
        if symbol.element in elements and isinstance(symbol.shape, Wheel)
    ]
