"""The strokes that are fixed in bodies: pins, supports, guides, wheels, racks, profiles."""

from collections.abc import Iterator

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.arrow_lines import hatching
from codegen.drawing.contact_surfaces import surface_lines, surfaces
from codegen.drawing.gear_meshing import Meshing, meshing
from codegen.drawing.guides_and_racks import (
    guide_ends,
    guide_of,
    rack_ends,
    rack_side,
    rail_offset,
    slot_ends,
)  # fmt: skip
from codegen.drawing.outlines import is_closed
from codegen.drawing.picture import Picture, Symbol, places
from codegen.drawing.polygons import (
    ROUND,
    FloatArray,
    box,
    circle,
    contains,
    convex_hull,
    distance_to_edge,
    distinct,
    normal,
    placed,
    rounded_hull,
    unit,
)  # fmt: skip
from codegen.drawing.sizes_and_held_places import HATCH, PIN, SAME, SLOT, circles_of, held_places
from codegen.drawing.strokes import Stroke
from codegen.drawing.wheel_lines import gear_profile, rack_profile, spoke

SUPPORT = 0.046  # layout: height of the triangle below a pin on the ground, in typical lengths
TRACK = 0.045  # layout: half length of the ground at a fixing
HUB = 1.5  # layout: radius of a wheel's hub, in pins
EYE = 0.6  # layout: radius of the eye of a spring, in pins
SWINGS = 0.1  # layout: a spring on the ground that turns by more, rad, has a support and no wall


def rigid_strokes(picture: Picture, motion: FloatArray | None = None) -> tuple[Stroke, ...]:
    """The strokes that are fixed in a body, in its frame: all but springs, belts and the like.

    Parameters
    ----------
    motion
        Poses of a motion, shape (instants, bodies, 3), for the lengths of guides, slots and racks.
    """
    mesh = meshing(picture)
    found: list[Stroke] = []
    for symbol in picture.symbols:
        for style, body, points, closed in _rigid(picture, symbol, mesh, motion):
            found.append(Stroke(style, body, points, closed, symbol.element))
    found += _spokes_of_discs(picture)
    for surface in surfaces(picture, fixed=True, motion=motion):
        for style, points in surface_lines(surface, picture.size):
            found.append(Stroke(style, 0, points, False, surface.element))
    return tuple(_once(found, picture.size))


def _spokes_of_discs(picture: Picture) -> Iterator[Stroke]:
    """Spokes of bodies that are one disc about their pin, so that they are seen to turn."""
    wheels = {s.shape.center.body for s in picture.symbols if isinstance(s.shape, shapes.Wheel)}
    for number, body in enumerate(picture.bodies):
        held = distinct(held_places(picture, number), SAME * picture.size)
        if body.is_derived and len(body.outlines) == 1 and len(held) == 1 and number not in wheels:
            radii = np.hypot(*(np.array(body.outlines[0]) - held[0]).T)
            if len(radii) > ROUND // 2 and np.ptp(radii) < 1e-6 * radii.max():
                line = spoke(held[0], float(radii.max()))
                yield Stroke("spoke", number, line, False, body.name)


def _once(strokes: list[Stroke], size: float) -> Iterator[Stroke]:
    """The strokes without those that an earlier element has drawn at the same place."""
    seen = set()
    for stroke in strokes:
        at = tuple(np.round(stroke.points.mean(axis=0) / (SAME * size)))
        key = stroke.style, stroke.body, len(stroke.points), at
        if key not in seen or stroke.style in ("hatch", "rail", "rack"):
            yield stroke
        seen.add(key)


Line = tuple[str, int, FloatArray, bool]


def _rigid(
    picture: Picture, symbol: Symbol, mesh: Meshing, motion: FloatArray | None
) -> Iterator[Line]:
    shape, size = symbol.shape, picture.size
    match shape:
        case shapes.Pin():
            yield from _pin(picture, shape.i, shape.j)
        case shapes.Bearing():
            center = np.array(shape.i[1:])
            yield from _support(picture, shape.i)
            hole = PIN * size + min(float(shape.clearance), 4 * PIN * size)
            yield "hole", shape.i.body, circle(center, 1.25 * hole), True
            yield "pin", shape.j.body, circle(np.array(shape.j[1:]), PIN * size), True
        case shapes.Rod():
            for place in (shape.i, shape.j):
                yield from _support(picture, place)
                yield "pin", place.body, circle(np.array(place[1:]), PIN * size), True
        case shapes.Slide():
            yield from _slide(picture, shape, mesh, motion)
        case shapes.Slot():
            guide = guide_of(picture, shape)
            ends = slot_ends(picture, guide, motion)
            slot = rounded_hull(ends, SLOT * size)
            yield "slot", guide.body, slot, True
            if picture.bodies[guide.body].fixed:
                yield from _hatched(guide.body, ends, -SLOT * size, picture)
            yield "pin", guide.block.body, circle(np.array(guide.block[1:]), PIN * size), True
        case shapes.Fixing():
            yield from _fixing(picture, shape)
        case shapes.Spring():
            for place, other in ((shape.i, shape.j), (shape.j, shape.i)):
                yield from _spring_end(picture, place, other, motion)
        case shapes.Wheel():
            yield from _wheel(picture, shape, mesh)
        case shapes.Rack():
            yield from _rack(picture, shape, mesh, motion)
        case shapes.Profile():
            points = np.array([place[1:] for place in shape.curve], dtype=float)
            yield "profile", shape.curve[0].body, points, is_closed(points)
        case shapes.Mark() | shapes.Trace():
            center, arm = np.array(shape.at[1:]), 0.6 * PIN * size
            for way in ([1.0, 1.0], [1.0, -1.0]):
                tip = arm * np.array(way)
                yield "mark", shape.at.body, np.array([center - tip, center + tip]), False


def _pin(picture: Picture, *ends: shapes.Place) -> Iterator[Line]:
    covered = any(_covers(picture, place) for place in ends)
    for place in ends:
        for style, body, line, closed in _support(picture, place):
            yield f"bracket-{style}" if covered else style, body, line, closed
    for place in ends:
        if not picture.bodies[place.body].fixed or all(picture.bodies[p.body].fixed for p in ends):
            yield "pin", place.body, circle(np.array(place[1:]), PIN * picture.size), True
            return


def _covers(picture: Picture, place: shapes.Place) -> bool:
    """Whether a body hides more than half of a support below its pin in all its positions."""
    at, needed = np.array(place[1:], dtype=float), 0.6 * SUPPORT * picture.size
    outlines = [np.array(outline) for outline in picture.bodies[place.body].outlines]
    outlines += [
        circle(np.array(center[1:]), radius)
        for symbol in picture.symbols
        for center, radius in circles_of(symbol.shape)
        if center.body == place.body
    ]
    return any(
        contains(outline, at) and distance_to_edge(outline, at) > needed
        for outline in outlines
        if not picture.bodies[place.body].fixed
    )


def _support(picture: Picture, place: shapes.Place) -> Iterator[Line]:
    """The triangle below a pin on the ground, and its hatching."""
    if not picture.bodies[place.body].fixed:
        return
    height = SUPPORT * picture.size
    top, half = np.array(place[1:], dtype=float), 0.62 * height
    base = top - np.array([0.0, height])
    left, right = base - np.array([half, 0.0]), base + np.array([half, 0.0])
    peak = rounded_hull(top[None], 1.5 * PIN * picture.size)
    hull = convex_hull(np.concatenate([peak, [left, right]]))
    yield "support", place.body, hull, True
    wide = np.array([1.45 * half, 0.0])
    yield from _hatched(place.body, np.array([base - wide, base + wide]), 0.0, picture)


def _hatched(body: int, ends: FloatArray, offset: float, picture: Picture) -> Iterator[Line]:
    """A line of the ground, moved by `offset` to its left, and its hatching on the lower side."""
    line = rail(ends, offset)
    yield "rail", body, line, False
    for stroke in hatching(line[0], line[1], -1.0, HATCH * picture.size):
        yield "hatch", body, stroke, False


def rail(ends: FloatArray, offset: float) -> FloatArray:
    """A line (2, 2) of the ground below another: to the right, or down where it is upright."""
    along = unit(ends[1] - ends[0])
    if along[0] < -1e-9 or (abs(along[0]) <= 1e-9 and along[1] > 0):
        ends, along = ends[::-1], -along
    return np.asarray(ends + offset * normal(along))


def _slide(
    picture: Picture, shape: shapes.Slide, mesh: Meshing, motion: FloatArray | None
) -> Iterator[Line]:
    guide = guide_of(picture, shape)
    if picture.bodies[guide.body].fixed:
        ends = guide_ends(picture, guide, motion)
        below = rail_offset(picture, guide, mesh.module)
        yield from _hatched(guide.body, ends, -below, picture)


def _spring_end(
    picture: Picture, place: shapes.Place, other: shapes.Place, motion: FloatArray | None
) -> Iterator[Line]:
    """An eye on a body that moves; the ground across the spring, or a support if it swings."""
    eye = circle(np.array(place[1:]), EYE * PIN * picture.size)
    if not picture.bodies[place.body].fixed:
        yield "pin", place.body, eye, True
        return
    at, end = np.array(picture.position(place)), np.array([[other.x, other.y]])
    poses = picture.poses[None] if motion is None else motion
    toward = np.array([placed(end, pose[other.body])[0] for pose in poses]) - at
    toward = toward[np.hypot(*toward.T) > SAME * picture.size]
    if not len(toward):
        return
    if np.ptp(np.unwrap(np.arctan2(toward[:, 1], toward[:, 0]))) > SWINGS:
        yield from _support(picture, place)
        yield "pin", place.body, eye, True
    else:
        yield from _wall_at(picture, place, toward[0])


def _fixing(picture: Picture, shape: shapes.Fixing) -> Iterator[Line]:
    """A clamp on the ground, a square of weld between bodies that move."""
    ground, moving = shape.i, shape.j
    if picture.bodies[moving.body].fixed:
        ground, moving = moving, ground
    at = np.array(ground[1:], dtype=float)
    if not picture.bodies[ground.body].fixed:
        half = 1.1 * PIN * picture.size
        yield "fixing", ground.body, box(at, np.array([1.0, 0.0]), half, half), True
        return
    held = [
        np.array(picture.position(place))
        for symbol in picture.symbols
        for place in places(symbol.shape)
        if place.body == moving.body
    ]
    far = max(held, key=lambda p: float(np.hypot(*(p - at))), default=at)
    middle = picture.poses[moving.body, :2]
    toward = far if np.hypot(*(far - at)) > SAME * picture.size else middle
    yield from _wall_at(picture, ground, toward - at)


def _wall_at(picture: Picture, place: shapes.Place, toward: FloatArray) -> Iterator[Line]:
    at = np.array(place[1:], dtype=float)
    across = normal(unit(toward)) * TRACK * picture.size
    yield "rail", place.body, np.array([at + across, at - across]), False
    for stroke in hatching(at + across, at - across, -1.0, HATCH * picture.size):
        yield "hatch", place.body, stroke, False


def _wheel(picture: Picture, shape: shapes.Wheel, mesh: Meshing) -> Iterator[Line]:
    center, body = np.array(shape.center[1:], dtype=float), shape.center.body
    radius, internal = abs(float(shape.radius)), shape.internal or float(shape.radius) < 0
    size = picture.size
    if shape.toothed:
        phase = mesh.phase(picture, shape)
        teeth = center + gear_profile(radius, mesh.module, phase, internal)
        if internal:
            rim = circle(center, radius + 3 * mesh.module, 96)
            hole = np.concatenate([rim, rim[:1], teeth[:1], teeth[::-1]])
            yield "ring", body, hole, True
            yield "profile", body, teeth, True
            yield "profile", body, rim, True
        else:
            yield "gear", body, teeth, True
        yield "pitch", body, circle(center, radius, 96), True
    elif internal:
        yield "profile", body, circle(center, radius, 96), True
    if not internal and not picture.bodies[body].fixed:
        reach = radius - (1.5 * mesh.module if shape.toothed else 0.0)
        yield "spoke", body, spoke(center, reach), False
    if not internal:
        yield "hub", body, circle(center, min(HUB * PIN * size, 0.4 * radius)), True


def _rack(
    picture: Picture, shape: shapes.Rack, mesh: Meshing, motion: FloatArray | None
) -> Iterator[Line]:
    body, along = shape.i.body, unit(np.array([shape.ux, shape.uy], dtype=float))
    ends = rack_ends(picture, shape, motion)
    origin = np.array(shape.i[1:], dtype=float)
    side = rack_side(picture, shape)
    if shape.toothed:
        reach = tuple(float((end - origin) @ along) for end in ends)
        line = rack_profile(
            origin, along, (reach[0], reach[1]), mesh.module, side, mesh.rack_phase(picture, shape)
        )
        yield "gear", body, line, True
    elif picture.bodies[body].fixed:
        yield "rail", body, ends, False
        for stroke in hatching(ends[0], ends[1], -side, HATCH * picture.size):
            yield "hatch", body, stroke, False
    else:
        yield "rack", body, ends, False
