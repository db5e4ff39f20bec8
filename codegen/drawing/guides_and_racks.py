"""Guides, slots and racks: on which body they are, where they begin and end, which side is free."""

import numpy as np

from codegen.drawing.picture import Picture
from codegen.drawing.polygons import FloatArray, in_frame, normal, placed, unit
from codegen.drawing.shapes import Pin, Place, Profile, Rack, Shape, Slide, Slot, Wheel
from codegen.drawing.sizes_and_held_places import BAR, BLOCK, SAME, held_places
from codegen.drawing.wheel_lines import BACK


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


def slot_ends(picture: Picture, guide: Guide, motion: FloatArray | None) -> FloatArray:
    """Where a slot begins and ends, in the frame of its body, shape (2, 2), m.

    It covers the travel of its pin; without a motion, and some way to either side.
    """
    first, last = guide.travel(picture, motion)
    room = 0.02 * picture.size
    if motion is None:
        least, most = _crank_circle(picture, guide) or (np.inf, -np.inf)
        room = (0.02 if most > least else 0.09) * picture.size
        first, last = min(first, least), max(last, most)
    return np.asarray(guide.origin + np.outer([first - room, last + room], guide.along))


def _crank_circle(picture: Picture, guide: Guide) -> tuple[float, float] | None:
    """The travel of a pin in a slot, where its body turns about a pin on the ground, m.

    A slot that turns about the ground itself sees distances from its own pin; another one sees the
    circle from the side.
    """
    center, own = (_ground_pin(picture, body) for body in (guide.block.body, guide.body))
    if center is None:
        return None
    radius = float(np.hypot(*(np.array(picture.position(guide.block)) - center)))
    pose = picture.poses[guide.body]
    if own is not None:
        start = float((in_frame(own[None], pose)[0] - guide.origin) @ guide.along)
        reach = float(np.hypot(*(center - own)))
        way = 1.0 if guide.travel(picture, None)[0] >= start else -1.0
        ends = start + way * abs(reach - radius), start + way * (reach + radius)
        return min(ends), max(ends)
    middle = float((in_frame(center[None], pose)[0] - guide.origin) @ guide.along)
    return middle - radius, middle + radius


def _ground_pin(picture: Picture, body: int) -> FloatArray | None:
    """Where a body turns about the ground, in the global frame."""
    for symbol in picture.symbols:
        pin = symbol.shape
        ends = (pin.i.body, pin.j.body) if isinstance(pin, Pin) else ()
        if isinstance(pin, Pin) and body in ends and any(picture.bodies[e].fixed for e in ends):
            return np.array(picture.position(pin.i))
    return None


def block_half_length(picture: Picture, guide: Guide) -> float:
    """Half the length of a block, m: less where other blocks are near."""
    at = np.array(picture.position(guide.block))
    others = [
        np.array(picture.position(guide_of(picture, symbol.shape).block))
        for symbol in picture.symbols
        if isinstance(symbol.shape, Slide)
    ]
    distances = [float(np.hypot(*(other - at))) for other in others]
    nearest = min((d for d in distances if d > SAME * picture.size), default=np.inf)
    return float(min(BLOCK[0] * picture.size, 0.28 * nearest))


def guide_ends(picture: Picture, guide: Guide, motion: FloatArray | None) -> FloatArray:
    """Where a guide begins and ends, in the frame of its body, shape (2, 2), m.

    It covers the travel of its block, which it exceeds so that one sees it, and the other places of
    its body that lie on the same line; without a motion it is longer than the block by its own
    length and more.
    """
    size = picture.size
    first, last = guide.travel(picture, motion)
    room = (1.6 * BLOCK[0] if motion is not None else 0.22) * size
    first, last = first - room, last + room
    if guide.body:
        held = held_places(picture, guide.body) - guide.origin
        beside = held @ np.array([-guide.along[1], guide.along[0]])
        on_line = (held @ guide.along)[np.abs(beside) < SAME * size]
        if len(on_line):
            first, last = _extended(first, last, float(on_line.min()), float(on_line.max()), room)
    return np.asarray(guide.origin + np.outer([first, last], guide.along))


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


def parallel_rack(picture: Picture, guide: Guide) -> Rack | None:
    """The rack along which a body slides, in place of a block."""
    for symbol in picture.symbols:
        rack = symbol.shape
        if isinstance(rack, Rack) and rack.i.body == guide.block.body:
            across = normal(unit(np.array([rack.ux, rack.uy], dtype=float)))
            if abs(float(across @ guide.along_in_block)) < SAME:
                return rack
    return None


def rail_offset(picture: Picture, guide: Guide, module: float) -> float:
    """How far below a guide its rail is, m: below the block, or below the teeth of a rack."""
    rack = parallel_rack(picture, guide)
    if rack is not None:
        across = normal(unit(np.array([rack.ux, rack.uy], dtype=float)))
        depth = BACK * module if rack.toothed else 2 * BAR * picture.size
        base = np.array(rack.i[1:]) - rack_side(picture, rack) * depth * across
        way = placed((base - np.array(guide.block[1:]))[None], _turn(picture, guide))[0]
        upright = abs(guide.along[0]) <= 1e-9
        below = way[0] if upright else -way @ normal(guide.along) * np.sign(guide.along[0])
        if below > 0:
            return float(below)
    body = picture.bodies[guide.block.body]
    if body.outlines and not body.is_derived:
        along = guide.along if abs(guide.along[0]) > 1e-9 else np.array([0.0, -1.0])
        across = -normal(along) * (np.sign(along[0]) or 1.0)
        edges = [0.0]
        for outline in body.outlines:
            there = placed(np.array(outline) - np.array(guide.block[1:]), _turn(picture, guide))
            edges += crossings(there @ along, there @ across)
        return max(edges)
    return BLOCK[1] * picture.size


def crossings(s: FloatArray, h: FloatArray) -> list[float]:
    """The values of h where a closed polygon with the corners (s, h) crosses s = 0."""
    found = []
    for a, b, p, q in zip(s, np.roll(s, -1), h, np.roll(h, -1), strict=True):
        if (a > 0) != (b > 0):
            found.append(float(p + a / (a - b) * (q - p)))
    return found


def _turn(picture: Picture, guide: Guide) -> FloatArray:
    """The pose without its place that takes the frame of the block to that of the guide."""
    turn = picture.poses[guide.block.body, 2] - picture.poses[guide.body, 2]
    return np.array([0.0, 0.0, turn])


def rack_ends(picture: Picture, shape: Rack, motion: FloatArray | None) -> FloatArray:
    """Where a rack or track begins and ends, in the frame of its body, shape (2, 2), m.

    It covers where the wheels of its element touch it, and a part of their circles more.
    """
    origin, along = np.array(shape.i[1:], dtype=float), unit(np.array([shape.ux, shape.uy], float))
    poses = picture.poses[None] if motion is None else motion
    s, room = [0.0], 0.25 * picture.size
    for curve in _profiles_of(picture, shape):
        points = np.array([place[1:] for place in curve])
        room = 0.8 * float(np.max(np.hypot(*(points - points.mean(axis=0)).T)))
    for wheel in wheels_of(picture, shape):
        hub = np.array([[wheel.center.x, wheel.center.y]])
        s = [
            float((in_frame(placed(hub, p[wheel.center.body]), p[shape.i.body])[0] - origin)
                  @ along)
            for p in poses
        ]  # fmt: skip
        room = abs(float(wheel.radius)) * (2.2 if motion is None else 1.1)
    return np.asarray(origin + np.outer([min(s) - room, max(s) + room], along))


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


def _profiles_of(picture: Picture, shape: Shape) -> list[tuple[Place, ...]]:
    """The curves of the element that has this shape."""
    elements = {symbol.element for symbol in picture.symbols if symbol.shape is shape}
    return [
        symbol.shape.curve
        for symbol in picture.symbols
        if symbol.element in elements and isinstance(symbol.shape, Profile)
    ]


def wheels_of(picture: Picture, shape: Shape) -> list[Wheel]:
    """The wheels of the element that has this shape."""
    elements = {symbol.element for symbol in picture.symbols if symbol.shape is shape}
    return [
        symbol.shape
        for symbol in picture.symbols
        if symbol.element in elements and isinstance(symbol.shape, Wheel)
    ]
