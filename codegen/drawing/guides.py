"""Where elements hold bodies; guides, slots, racks and gears: their ends, sides and teeth."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.contacts import contact_line
from codegen.drawing.picture import BAR, BLOCK, CHEEK, SAME, Picture
from codegen.drawing.plane_geometry import FloatArray, Points, crossings, dot, in_frame, unit
from codegen.drawing.shapes import ContactSide, Place, Rack, Wheel, places

STILL = 0.18  # layout: room of a guide or slot without a motion on both sides, typical lengths
_HOLDING = (
    shapes.Pin, shapes.Rod, shapes.Fixing, shapes.Bearing, shapes.Spring, shapes.Mark,
    shapes.Force, shapes.Trace,
)  # fmt: skip


def circles_of(shape: shapes.Shape) -> Iterator[tuple[Place, float]]:
    """Centres and radii of the wheels of a shape, m."""
    if isinstance(shape, Wheel):
        yield shape.center, abs(shape.radius)
    if isinstance(shape, shapes.Belt):
        yield shape.i, abs(shape.radius_i)
        yield shape.j, abs(shape.radius_j)


def held_places(picture: Picture, body: int) -> Points:
    """Places (k,) of a body, in its frame, that joints, forces and traces take hold of, m.

    A contact takes hold of its centre of curvature: of a corner, or the centre of a disc.
    """
    found = [
        place.point
        for _, shape in picture.having(*_HOLDING)
        if not isinstance(shape, shapes.OppositeForce)
        for place in places(shape)
        if place.body == body
    ]
    for _, side in picture.having(ContactSide):
        if side.body == body and (side.turn or side.bend):
            center = contact_line(picture, side).center
            found += [picture.in_body(center, body)] if np.isfinite(center) else []
    return np.array(found, dtype=complex)


class Guide(NamedTuple):
    """The guide of a slide or slot.

    A block that slides in the ground is as well a guide that slides over a block: it is the guide
    of the ground where that takes part.
    """

    body: int  # that has the guide
    block: Place  # of the other body, that stays on it
    origin: complex  # a place on the guide, in the frame of `body`
    along: complex  # its direction there
    along_in_block: complex  # and in the frame of the other body


def guide_of(picture: Picture, shape: shapes.Slide | shapes.Slot) -> Guide:
    """The guide of a slide or slot; a slot is always on body i."""
    i, j, along = shape.i, shape.j, shape.along
    other = along * np.exp(1j * (picture.poses[i.body, 2] - picture.poses[j.body, 2]))
    is_given = picture.is_ground(i.body) or not picture.is_ground(j.body)
    if isinstance(shape, shapes.Slide) and (j.body == 0 or not is_given):
        return Guide(j.body, i, j.point, other, along)
    return Guide(i.body, j, i.point, along, other)


def _travel(
    picture: Picture, place: Place, body: int, start: complex, along: complex, room: float
) -> FloatArray:
    """Ends from `start` of a place's travel along a line of a body, and some room, (2,), m."""
    poses = picture.poses[None] if picture.motion is None else picture.motion
    s = dot(along, in_frame(picture.path(place), poses[:, body]) - start)
    more = (max(STILL, 2 * room) if picture.motion is None else room) * picture.size
    return np.array([s.min() - more, s.max() + more])


def slot_ends(picture: Picture, guide: Guide) -> Points:
    """Where a slot begins and ends, in the frame of its body, (2,), m: where its pin travels.

    Without a motion that is all of the circle on which the pin turns about the ground, if it does,
    else as much as an outline that is given has room for.
    """
    room, body = 0.02, picture.bodies[guide.body]
    ends = _travel(picture, guide.block, guide.body, guide.origin, guide.along, room)
    if picture.motion is None and not (body.fixed or body.is_derived):
        edge = dot(guide.along, np.concatenate(body.outlines) - guide.origin)
        ends = np.clip(ends, edge.min() + CHEEK * picture.size, edge.max() - CHEEK * picture.size)
    if picture.motion is None and (center := _ground_pin(picture, guide.block.body)) is not None:
        now = ends.mean()
        reach = np.array([now, *_crank_circle(picture, guide, center, now)])
        ends = np.array([reach.min(), reach.max()]) + room * picture.size * np.array([-1, 1])
    return np.asarray(guide.origin + ends * guide.along)


def _crank_circle(
    picture: Picture, guide: Guide, center: complex, now: float
) -> tuple[float, float]:
    """The travel of a pin that turns about a centre along its slot, m.

    A slot that turns about the ground itself sees distances from its own pin; another one sees the
    circle from the side.
    """
    radius, own = abs(picture.at(guide.block) - center), _ground_pin(picture, guide.body)
    seen = center if own is None else own
    middle = dot(guide.along, picture.in_body(seen, guide.body) - guide.origin)
    if own is None:
        return middle - radius, middle + radius
    reach, way = abs(center - own), 1.0 if now >= middle else -1.0
    return middle + way * abs(reach - radius), middle + way * (reach + radius)


def _ground_pin(picture: Picture, body: int) -> complex | None:
    """Where a body turns about the ground, in the global frame."""
    for _, pin in picture.having(shapes.Pin):
        ends = pin.i.body, pin.j.body
        if body in ends and any(map(picture.is_ground, ends)):
            return complex(picture.at(pin.i))
    return None


def block_half_length(picture: Picture, guide: Guide) -> float:
    """Half the length of a block, m: less where other blocks are near."""
    at = picture.at(guide.block)
    others = [guide_of(picture, shape).block for _, shape in picture.having(shapes.Slide)]
    distances = [abs(picture.at(other) - at) for other in others]
    nearest = min((d for d in distances if d > SAME * picture.size), default=np.inf)
    return float(min(BLOCK[0] * picture.size, 0.28 * nearest))


def guide_ends(picture: Picture, guide: Guide) -> Points:
    """Where a guide begins and ends, in the frame of its body, (2,), m.

    It exceeds the travel of its block, so that one sees it, and covers the other places of its body
    that lie on the same line.
    """
    room = 1.6 * BLOCK[0]
    ends = _travel(picture, guide.block, guide.body, guide.origin, guide.along, room)
    if guide.body:
        held = (held_places(picture, guide.body) - guide.origin) * guide.along.conjugate()
        ends = np.append(ends, held.real[abs(held.imag) < SAME * picture.size])
    return np.asarray(guide.origin + np.array([ends.min(), ends.max()]) * guide.along)


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
        seen = [(line - guide.block.point) * turn * down.conjugate() for line in body.outlines]
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

    It covers where the wheels of its element touch it, and to both sides 1.1 of their radii more;
    without a motion twice that.
    """
    ends = np.array([-0.25, 0.25]) * picture.size
    for profile in picture.partners(shape, shapes.Profile):
        curve = profile.curve.points
        ends = np.array([-0.8, 0.8]) * np.max(abs(curve - curve.mean()))
    for wheel in picture.partners(shape, Wheel):
        room = 1.1 * abs(wheel.radius) / picture.size
        ends = _travel(picture, wheel.center, shape.i.body, shape.i.point, shape.along, room)
    return np.asarray(shape.i.point + ends * shape.along)


def rack_side(picture: Picture, shape: Rack) -> float:
    """The side of a rack where its wheel or cam is: 1 on its left, -1 on its right.

    Where the element has neither, it is the upper side.
    """
    heading = picture.turned(shape.along, shape.i.body)
    centers = [picture.at(wheel.center) for wheel in picture.partners(shape, Wheel)]
    curves = [profile.curve for profile in picture.partners(shape, shapes.Profile)]
    centers += [picture.placed(points.mean(), body) for body, points in curves]
    if centers:
        return 1.0 if dot(1j * heading, centers[0] - picture.at(shape.i)) >= 0 else -1.0
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


def pitch_point(picture: Picture, one: Wheel | Rack, other: Wheel | Rack) -> complex:
    """Where the pitch circle of a gear touches that of another one, or the line of a rack."""
    if isinstance(one, Rack):
        one, other = other, one
    assert isinstance(one, Wheel)
    center = picture.at(one.center)
    if isinstance(other, Wheel):  # a ring has a negative radius
        share = one.radius / (one.radius + other.radius)
        return complex(center + share * (picture.at(other.center) - center))
    at, along = picture.at(other.i), picture.turned(other.along, other.i.body)
    return complex(at + dot(along, center - at) * along)


class Meshing:
    """The teeth of all gears and racks of a picture, in phase where two of them meet.

    `module` is the pitch over π, m, of all teeth. In `phases` stand for a wheel the angle of the
    middle of a tooth in its body, rad, and for a rack its position from its place, m. That of one
    that meets several others follows from the first; so it does in a train.
    """

    def __init__(self, picture: Picture) -> None:
        self.picture, self.module = picture, tooth_module(picture)
        self.phases: dict[Wheel | Rack, float] = {}
        pairs: dict[str, list[Wheel | Rack]] = {}
        for symbol in picture.symbols:
            if isinstance(symbol.shape, Wheel | Rack) and symbol.shape.toothed:
                pairs.setdefault(symbol.element, []).append(symbol.shape)
        waiting = [pair for pair in pairs.values() if len(pair) == 2]
        while waiting:
            is_met = [any(shape in self.phases for shape in pair) for pair in waiting]
            first, second = waiting.pop(is_met.index(True) if any(is_met) else 0)
            if second in self.phases and first not in self.phases:
                first, second = second, first
            known = self.phases.setdefault(first, 0.0)
            at = pitch_point(picture, first, second)
            (s, pitch, way), (other_s, other_pitch, other_way) = (
                self._place_on(shape, at) for shape in (first, second)
            )
            ahead = (s - known) / pitch * np.sign(dot(way, other_way))  # a gap meets a tooth
            self.phases.setdefault(second, float(other_s - (ahead + 0.5) * other_pitch))

    def _place_on(self, shape: Wheel | Rack, at: complex) -> tuple[float, float, complex]:
        """The position of a place on a pitch line, the pitch in its unit, and the line's way."""
        if isinstance(shape, Rack):
            along = self.picture.turned(shape.along, shape.i.body)
            return float(dot(along, at - self.picture.at(shape.i))), np.pi * self.module, along
        arm = at - self.picture.at(shape.center)
        angle = float(np.angle(arm) - self.picture.poses[shape.center.body, 2])
        return angle, 2 * np.pi / teeth_of(shape.radius, self.module), 1j * arm
