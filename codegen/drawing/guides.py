"""Where elements hold bodies; guides, slots, racks and gears: their ends, sides and teeth."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from codegen.drawing.contacts import contact_line, sides_of
from codegen.drawing.picture import BAR, BLOCK, SAME, Picture
from codegen.drawing.plane_geometry import Points, crossings, dot, in_frame, unit
from codegen.drawing.shapes import (
    Bearing,
    Belt,
    Fixing,
    Force,
    Mark,
    OppositeForce,
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
    places,
)  # fmt: skip

_HOLDING = (Pin, Rod, Fixing, Bearing, Spring, Mark, Force, Trace)


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
    for _, side in sides_of(picture):
        if side.body == body and (side.turn or side.bend):
            center = contact_line(picture, side).center
            found += [picture.in_body(center, body)] if np.isfinite(center) else []
    return np.array(found, dtype=complex)


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


def guide_of(picture: Picture, shape: Slide | Slot) -> Guide:
    """The guide of a slide or slot; a slot is always on body i."""
    i, j, along = shape.i, shape.j, shape.along
    other = along * np.exp(1j * (picture.poses[i.body, 2] - picture.poses[j.body, 2]))
    is_given = picture.is_ground(i.body) or not picture.is_ground(j.body)
    if isinstance(shape, Slide) and (j.body == 0 or not is_given):
        return Guide(j.body, i, j.point, other, along)
    return Guide(i.body, j, i.point, along, other)


def _travel(
    picture: Picture, place: Place, body: int, start: complex, along: complex
) -> tuple[float, float]:
    """Least and greatest position of a place along a line of another body, from `start`, m."""
    poses = picture.poses[None] if picture.motion is None else picture.motion
    s = dot(along, in_frame(picture.path(place), poses[:, body]) - start)
    return float(s.min()), float(s.max())


def slot_ends(picture: Picture, guide: Guide) -> Points:
    """Where a slot begins and ends, in the frame of its body, (2,), m.

    It covers the travel of its pin; without a motion, and some way to either side.
    """
    first, last = _travel(picture, guide.block, guide.body, guide.origin, guide.along)
    room = 0.02 * picture.size
    if picture.motion is None:
        circle = _crank_circle(picture, guide, first)
        if circle is None:
            room = 0.09 * picture.size
        else:
            first, last = min(first, *circle), max(last, *circle)
    return guide.origin + np.array([first - room, last + room]) * guide.along


def _crank_circle(picture: Picture, guide: Guide, now: float) -> tuple[float, float] | None:
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
    way = 1.0 if now >= middle else -1.0
    return middle + way * abs(reach - radius), middle + way * (reach + radius)


def _ground_pin(picture: Picture, body: int) -> complex | None:
    """Where a body turns about the ground, in the global frame."""
    for _, pin in picture.having(Pin):
        ends = pin.i.body, pin.j.body
        if body in ends and any(map(picture.is_ground, ends)):
            return complex(picture.at(pin.i))
    return None


def block_half_length(picture: Picture, guide: Guide) -> float:
    """Half the length of a block, m: less where other blocks are near."""
    at = picture.at(guide.block)
    others = [guide_of(picture, shape).block for _, shape in picture.having(Slide)]
    distances = [abs(picture.at(other) - at) for other in others]
    nearest = min((d for d in distances if d > SAME * picture.size), default=np.inf)
    return float(min(BLOCK[0] * picture.size, 0.28 * nearest))


def guide_ends(picture: Picture, guide: Guide) -> Points:
    """Where a guide begins and ends, in the frame of its body, (2,), m.

    It covers the travel of its block, which it exceeds so that one sees it, and the other places of
    its body that lie on the same line, at the outermost of which it ends; without a motion it is
    longer than the block by its own length and more.
    """
    first, last = _travel(picture, guide.block, guide.body, guide.origin, guide.along)
    room = (1.6 * BLOCK[0] if picture.motion is not None else 0.22) * picture.size
    first, last = first - room, last + room
    if guide.body:
        held = (held_places(picture, guide.body) - guide.origin) * guide.along.conjugate()
        on_line = held.real[abs(held.imag) < SAME * picture.size]
        middle = (first + last) / 2
        least, most = on_line.min(initial=np.inf), on_line.max(initial=-np.inf)
        first = least if least < min(middle, first + room) else first
        last = most if most > max(middle, last - room) else last
    return guide.origin + np.array([first, last]) * guide.along


def below(ends: Points, distance: float) -> Points:
    """A line (2,) of the ground below another: to the right, or down where it is upright."""
    along = unit(ends[1] - ends[0])
    if along.real < -1e-9 or (abs(along.real) <= 1e-9 and along.imag > 0):
        ends, along = ends[::-1], -along
    return np.asarray(ends - distance * 1j * along)


def rail_ends(picture: Picture, guide: Guide) -> Points:
    """Where the rail of a guide on the ground begins and ends, (2,), m.

    It lies below the block, or below the teeth of a rack.
    """
    return below(guide_ends(picture, guide), _rail_distance(picture, guide))


def _rail_distance(picture: Picture, guide: Guide) -> float:
    angle = picture.poses[guide.block.body, 2] - picture.poses[guide.body, 2]
    turn = np.exp(1j * angle)  # from the frame of the block to that of the guide
    is_upright = abs(guide.along.real) <= 1e-9
    down = 1.0 + 0.0j if is_upright else -1j * guide.along * np.sign(guide.along.real)
    rack = parallel_rack(picture, guide)
    if rack is not None:
        depth = RACK_DEPTH * tooth_module(picture) if rack.toothed else 2 * BAR * picture.size
        base = rack.i.point - rack_side(picture, rack) * depth * 1j * rack.along
        distance = float(dot(down, (base - guide.block.point) * turn))
        if distance > 0:
            return distance
    body = picture.bodies[guide.block.body]
    if body.outlines and not body.is_derived:
        down = -down if is_upright else down
        seen = [(line - guide.block.point) * turn * down.conjugate() for line in body.polygons]
        return float(np.nanmax([0.0, *(z for line in seen for z in crossings(line))]))
    return BLOCK[1] * picture.size


def parallel_rack(picture: Picture, guide: Guide) -> Rack | None:
    """The rack along which a body slides, in place of a block."""
    for _, rack in picture.having(Rack):
        is_parallel = abs(dot(1j * rack.along, guide.along_in_block)) < SAME
        if rack.i.body == guide.block.body and is_parallel:
            return rack
    return None


def rack_ends(picture: Picture, shape: Rack) -> Points:
    """Where a rack or track begins and ends, in the frame of its body, (2,), m.

    It covers where the wheels of its element touch it, and a part of their circles more.
    """
    first, last, room = 0.0, 0.0, 0.25 * picture.size
    for profile in picture.partners(shape, Profile):
        room = 0.8 * float(np.max(abs(profile.points - profile.points.mean())))
    for wheel in picture.partners(shape, Wheel):
        first, last = _travel(picture, wheel.center, shape.i.body, shape.i.point, shape.along)
        room = abs(wheel.radius) * (2.2 if picture.motion is None else 1.1)
    return np.asarray(shape.i.point + np.array([first - room, last + room]) * shape.along)


def rack_side(picture: Picture, shape: Rack) -> float:
    """The side of a rack where its wheel or cam is: 1 on its left, -1 on its right.

    Where the element has neither, it is the upper side.
    """
    heading = picture.turned(shape.along, shape.i.body)
    wheels = [[wheel.center] for wheel in picture.partners(shape, Wheel)]
    for curve in [*wheels, *(cam.curve for cam in picture.partners(shape, Profile))]:
        away = np.mean([picture.at(place) for place in curve]) - picture.at(shape.i)
        return 1.0 if dot(1j * heading, away) >= 0 else -1.0
    return 1.0 if heading.real >= 0 else -1.0


LEAST_TEETH, MOST_TEETH = 10, 18  # layout: of the smallest gear of a picture
ADDENDUM, DEDENDUM = 0.9, 1.1  # layout: tooth above and below the pitch circle, in modules
CREST, ROOT = 0.22, 0.34  # layout: half widths of a tooth at its crest and root, in pitches
RACK_DEPTH = 2.6  # layout: depth of a toothed rack below its pitch line, in modules
_TOOTH = np.array([-ROOT, -CREST, CREST, ROOT])  # in pitches
_LEVELS = np.array([-DEDENDUM, ADDENDUM, ADDENDUM, -DEDENDUM])  # in modules


def tooth_module(picture: Picture) -> float:
    """Pitch over π of all teeth of a picture, m."""
    radii = [abs(wheel.radius) for _, wheel in picture.having(Wheel) if wheel.toothed]
    return common_module(radii) if radii else 0.02 * picture.size


def common_module(radii: Sequence[float]) -> float:
    """The module m, in m, with which the gears' numbers of teeth 2r/m come nearest to integers."""

    def error(module: float) -> float:
        teeth = 2 * np.array(radii) / module
        return float(np.max(abs(teeth - np.round(teeth))))

    candidates = [2 * min(radii) / teeth for teeth in range(LEAST_TEETH, MOST_TEETH + 1)]
    return min(candidates, key=lambda module: (round(error(module), 3), module))


def teeth_of(radius: float, module: float) -> int:
    """The number of teeth of a gear."""
    return max(4, round(2 * abs(radius) / module))


def gear_profile(
    radius: float, module: float, phase: float = 0.0, internal: bool = False
) -> Points:
    """The toothed line (k,) of a gear about the origin, closed and counterclockwise, m.

    The phase, rad, is the angle of the middle of a tooth. Teeth are straight: a drawing, not an
    involute. The teeth of an internal gear point inwards.
    """
    teeth = teeth_of(radius, module)
    levels = radius + (-module if internal else module) * _LEVELS
    angles = phase + 2 * np.pi / teeth * (np.arange(teeth)[:, None] + _TOOTH)
    return np.asarray(np.ravel(levels * np.exp(1j * angles)))


def rack_profile(rack: Rack, ends: Points, module: float, side: float, phase: float) -> Points:
    """The closed outline (k,) of a rack in the frame of its body, m.

    Its teeth point to the left (`side` 1) or right (-1), between `ends`, (2,); a tooth is `phase`
    from its place.
    """
    pitch = np.pi * module
    reach = dot(rack.along, ends - rack.i.point)
    first, last = (reach - phase) / pitch + np.array([ROOT, -ROOT])
    s = phase + pitch * (np.arange(np.ceil(first), np.floor(last) + 1)[:, None] + _TOOTH)
    teeth = np.ravel(s + 1j * side * module * _LEVELS)
    a, b = reach[:, None] - 1j * side * module * np.array([RACK_DEPTH, DEDENDUM])
    return np.asarray(rack.i.point + rack.along * np.concatenate([a, teeth, b[::-1]]))


class Meshing:
    """The teeth of all gears of a picture, in phase where two gears or a gear and a rack meet.

    The phase of a gear that meets several others follows from the first; so it does in a train.

    Attributes
    ----------
    module
        Pitch over π, m, of all teeth.
    phases
        Wheel → angle of the middle of a tooth in the wheel's body, rad.
    """

    def __init__(self, picture: Picture) -> None:
        self.picture, self.module = picture, tooth_module(picture)
        self.phases: dict[Wheel, float] = {}
        pairs: dict[str, list[Wheel]] = {}
        for symbol, wheel in picture.having(Wheel):
            if wheel.toothed:
                pairs.setdefault(symbol.element, []).append(wheel)
        waiting = [pair for pair in pairs.values() if len(pair) == 2]
        while waiting:
            is_met = [any(wheel in self.phases for wheel in pair) for pair in waiting]
            first, second = waiting.pop(is_met.index(True) if any(is_met) else 0)
            if second in self.phases and first not in self.phases:
                first, second = second, first
            self.phases.setdefault(first, 0.0)
            if second not in self.phases:
                self.phases[second] = self._meeting_phase(first, second)

    def phase(self, wheel: Wheel) -> float:
        """The angle of a tooth's middle in the frame of the wheel's body, rad."""
        return self.phases.get(wheel, 0.0)

    def _pitches_ahead(self, wheel: Wheel, heading: float) -> float:
        """How far a direction, rad in global axes, is ahead of a tooth of a wheel, in pitches."""
        angle = heading - self.phase(wheel) - self.picture.poses[wheel.center.body, 2]
        return float(angle * teeth_of(wheel.radius, self.module) / (2 * np.pi))

    def _meeting_phase(self, first: Wheel, second: Wheel) -> float:
        """The phase of the second of two gears, whose teeth meet the gaps of the first."""
        to_second = self.picture.at(second.center) - self.picture.at(first.center)
        heading = float(np.angle(to_second))
        if min(first.radius, second.radius) < 0:
            if abs(second.radius) > abs(first.radius):
                heading = float(np.angle(-to_second))  # from the ring's centre to the pinion's
            meeting, there = heading, 0.5 + self._pitches_ahead(first, heading)
        else:
            meeting, there = heading + np.pi, 0.5 - self._pitches_ahead(first, heading)
        pitch = 2 * np.pi / teeth_of(second.radius, self.module)
        return float(meeting - there * pitch - self.picture.poses[second.center.body, 2])

    def rack_phase(self, rack: Rack) -> float:
        """The position of a tooth's middle along the rack from its place, m."""
        for wheel in self.picture.partners(rack, Wheel):
            along = self.picture.turned(rack.along, rack.i.body)
            away = self.picture.at(wheel.center) - self.picture.at(rack.i)
            s, height = dot(along, away), dot(1j * along, away)
            contact = float(np.angle(-height * 1j * along))
            # the rim at the contact runs along the rack as the gear turns, by the rack's side
            ahead = (1.0 if height >= 0 else -1.0) * self._pitches_ahead(wheel, contact)
            return float(s + (0.5 - ahead) * np.pi * self.module)
        return 0.0
