"""Guides, slots and racks: on which body they are, where they begin and end, which side is free."""

from typing import NamedTuple

import numpy as np

from codegen.drawing.held_places import held_places
from codegen.drawing.picture import Picture
from codegen.drawing.plane_geometry import FloatArray, Points, crossings, dot, in_frame, placed
from codegen.drawing.proportions import BAR, BLOCK, SAME
from codegen.drawing.shapes import Pin, Place, Profile, Rack, Slide, Slot, Wheel

RACK_DEPTH = 2.6  # layout: depth of a toothed rack below its pitch line, in modules


class Guide(NamedTuple):
    """The guide of a slide or slot: on which body, through which place, along which direction.

    Attributes
    ----------
    body
        The body that has the guide: the ground where it takes part, since a block that slides in
        the ground is as well a guide that slides over a block.
    block
        The place of the other body that stays on it.
    origin, along
        A place on the guide and its direction, in the frame of `body`.
    along_in_block
        The direction of the guide in the frame of the other body.
    """

    body: int
    block: Place
    origin: complex
    along: complex
    along_in_block: complex

    def travel(self, picture: Picture, motion: FloatArray | None) -> tuple[float, float]:
        """Least and greatest position of the block along the guide, from `origin`, m."""
        return _travel(picture, motion, self.block, self.body, self.origin, self.along)


def _travel(
    picture: Picture, motion: FloatArray | None, place: Place, body: int, start: complex,
    along: complex,
) -> tuple[float, float]:  # fmt: skip
    """Least and greatest position of a place along a line of another body, from `start`, m."""
    poses = picture.poses[None] if motion is None else motion
    s = dot(along, in_frame(placed(place.point, poses[:, place.body]), poses[:, body]) - start)
    return float(s.min()), float(s.max())


def guide_of(picture: Picture, shape: Slide | Slot) -> Guide:
    """The guide of a slide or slot; a slot is always on body i."""
    i, j, along = shape.i, shape.j, shape.along
    other = along * complex(np.exp(1j * (picture.poses[i.body, 2] - picture.poses[j.body, 2])))
    is_given = picture.is_ground(i.body) or not picture.is_ground(j.body)
    if isinstance(shape, Slide) and (j.body == 0 or not is_given):
        return Guide(j.body, i, j.point, other, along)
    return Guide(i.body, j, i.point, along, other)


def slot_ends(picture: Picture, guide: Guide, motion: FloatArray | None) -> Points:
    """Where a slot begins and ends, in the frame of its body, (2,), m.

    It covers the travel of its pin; without a motion, and some way to either side.
    """
    first, last = guide.travel(picture, motion)
    room = 0.02
    if motion is None:
        least, most = _crank_circle(picture, guide) or (np.inf, -np.inf)
        room = 0.02 if most > least else 0.09
        first, last = min(first, least), max(last, most)
    room *= picture.size
    return guide.origin + np.array([first - room, last + room]) * guide.along


def _crank_circle(picture: Picture, guide: Guide) -> tuple[float, float] | None:
    """The travel of a pin in a slot, where its body turns about a pin on the ground, m.

    A slot that turns about the ground itself sees distances from its own pin; another one sees the
    circle from the side.
    """
    center, own = (_ground_pin(picture, body) for body in (guide.block.body, guide.body))
    if center is None:
        return None
    radius = abs(picture.at(guide.block) - center)
    seen = center if own is None else own
    middle = dot(guide.along, picture.in_body(seen, guide.body) - guide.origin)
    if own is None:
        return middle - radius, middle + radius
    reach = abs(center - own)
    way = 1.0 if guide.travel(picture, None)[0] >= middle else -1.0
    ends = middle + way * abs(reach - radius), middle + way * (reach + radius)
    return min(ends), max(ends)


def _ground_pin(picture: Picture, body: int) -> complex | None:
    """Where a body turns about the ground, in the global frame."""
    for _, pin in picture.having(Pin):
        ends = pin.i.body, pin.j.body
        if body in ends and any(map(picture.is_ground, ends)):
            return picture.at(pin.i)
    return None


def block_half_length(picture: Picture, guide: Guide) -> float:
    """Half the length of a block, m: less where other blocks are near."""
    at = picture.at(guide.block)
    others = [guide_of(picture, shape).block for _, shape in picture.having(Slide)]
    distances = [abs(picture.at(other) - at) for other in others]
    nearest = min((d for d in distances if d > SAME * picture.size), default=np.inf)
    return float(min(BLOCK[0] * picture.size, 0.28 * nearest))


def guide_ends(picture: Picture, guide: Guide, motion: FloatArray | None) -> Points:
    """Where a guide begins and ends, in the frame of its body, (2,), m.

    It covers the travel of its block, which it exceeds so that one sees it, and the other places of
    its body that lie on the same line, at the outermost of which it ends; without a motion it is
    longer than the block by its own length and more.
    """
    first, last = guide.travel(picture, motion)
    room = (1.6 * BLOCK[0] if motion is not None else 0.22) * picture.size
    first, last = first - room, last + room
    if guide.body:
        held = (held_places(picture, guide.body) - guide.origin) * guide.along.conjugate()
        on_line = held.real[abs(held.imag) < SAME * picture.size]
        middle = (first + last) / 2
        least, most = on_line.min(initial=np.inf), on_line.max(initial=-np.inf)
        first = least if least < min(middle, first + room) else first
        last = most if most > max(middle, last - room) else last
    return guide.origin + np.array([first, last]) * guide.along


def parallel_rack(picture: Picture, guide: Guide) -> Rack | None:
    """The rack along which a body slides, in place of a block."""
    for _, rack in picture.having(Rack):
        is_parallel = abs(dot(1j * rack.along, guide.along_in_block)) < SAME
        if rack.i.body == guide.block.body and is_parallel:
            return rack
    return None


def rail_offset(picture: Picture, guide: Guide, module: float) -> float:
    """How far below a guide its rail is, m: below the block, or below the teeth of a rack."""
    angle = picture.poses[guide.block.body, 2] - picture.poses[guide.body, 2]
    turn = complex(np.exp(1j * angle))  # from the frame of the block to that of the guide
    is_upright = abs(guide.along.real) <= 1e-9
    below = 1.0 + 0.0j if is_upright else -1j * guide.along * np.sign(guide.along.real)
    rack = parallel_rack(picture, guide)
    if rack is not None:
        depth = RACK_DEPTH * module if rack.toothed else 2 * BAR * picture.size
        base = rack.i.point - rack_side(picture, rack) * depth * 1j * rack.along
        offset = float(dot(below, (base - guide.block.point) * turn))
        if offset > 0:
            return offset
    body = picture.bodies[guide.block.body]
    if body.outlines and not body.is_derived:
        below = -below if is_upright else below
        seen = [(line - guide.block.point) * turn * below.conjugate() for line in body.polygons]
        return float(np.nanmax([0.0, *(z for line in seen for z in crossings(line))]))
    return BLOCK[1] * picture.size


def rack_ends(picture: Picture, shape: Rack, motion: FloatArray | None) -> Points:
    """Where a rack or track begins and ends, in the frame of its body, (2,), m.

    It covers where the wheels of its element touch it, and a part of their circles more.
    """
    first, last, room = 0.0, 0.0, 0.25 * picture.size
    for profile in picture.partners(shape, Profile):
        points = np.array([place.point for place in profile.curve])
        room = 0.8 * float(np.max(abs(points - points.mean())))
    for wheel in picture.partners(shape, Wheel):
        line = shape.i.body, shape.i.point, shape.along
        first, last = _travel(picture, motion, wheel.center, *line)
        room = abs(wheel.radius) * (2.2 if motion is None else 1.1)
    return np.asarray(shape.i.point + np.array([first - room, last + room]) * shape.along)


def rack_side(picture: Picture, shape: Rack) -> float:
    """The side of a rack where its wheel or cam is: 1 on its left, -1 on its right.

    Where the element has neither, it is the upper side.
    """
    heading = picture.turned(shape.along, shape.i.body)
    side = heading.real
    curves = [[wheel.center] for wheel in picture.partners(shape, Wheel)]
    for curve in [*curves, *(cam.curve for cam in picture.partners(shape, Profile))][:1]:
        away = complex(np.mean([picture.at(place) for place in curve])) - picture.at(shape.i)
        side = dot(1j * heading, away)
    return 1.0 if side >= 0 else -1.0
