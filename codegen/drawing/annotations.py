"""Strokes that a picture has beside its lines: arrows, frames of bodies, paths, dimensions."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.contacts import line_of_force, nearest_side, touch
from codegen.drawing.guides import held_places
from codegen.drawing.picture import (
    ARROW,
    BLOCK,
    HEAD,
    PIN,
    ROUND_ARROW,
    SAME,
    Picture,
    SpacePicture,
    Symbol,
)
from codegen.drawing.plane_geometry import (
    FloatArray,
    Points,
    circle,
    distinct,
    dot,
    head,
    origin,
    round_arrow,
    samples,
    straight_arrow,
    unit,
)  # fmt: skip
from codegen.drawing.shapes import ContactSide, Place, SpacePlace
from codegen.drawing.space_shapes import Push, SpaceDrive, Wrench
from codegen.drawing.styles import Stroke

LARGEST = 0.32  # layout: length of the largest arrow to scale, in typical lengths
WIDE = 1.35  # layout: radius of a torque's arrow over that of a driver's
SMALLEST = 0.45  # layout: radius of the arrow of no torque over that of the largest
VANISHING = 1e-9  # accuracy: of the largest; a smaller number is rounding
FRAME = 0.075  # layout: length of the axes of a body's frame, in typical lengths
MOST_EDGES = 4  # layout: edges of a body that are measured
OFFSET = 0.07  # layout: distance of a dimension line from what it measures
OFFSET_LEVELS = (1.0, 1.8, 2.6)  # layout: multiples of it, of which the first free one is taken
CLEARANCE = 0.045  # layout: least distance of dimension lines from each other
Arrow = tuple["Load", list[Stroke]]
"""What acts, with its shaft and its head."""
Series = Mapping[str, float | FloatArray]
"""Name of a series of a result, as ``"B.fx"``, → its value, or its values (k,), N or N m."""


class Load(NamedTuple):
    """A force or a torque that acts on a body, at one instant or over time."""

    element: str  # to which it belongs
    style: str  # "force", "reaction" or "torque"
    label: str  # what acts, and on which body
    at: Any  # where it acts in the global frame, m
    value: Any  # the force in global axes, Fx + iFy, N; or the torque, N m; in space (..., 3)
    place: Place | SpacePlace | None = None  # of a body where it acts, if it is one

    @property
    def size(self) -> float:
        """Of the force in N, or of the torque in N m; the largest over time."""
        if isinstance(self.place, SpacePlace):
            return float(np.nanmax(np.linalg.norm(self.value, axis=-1), initial=0.0))
        return float(np.nanmax(np.abs(self.value), initial=0.0))

    @property
    def unit(self) -> str:
        """N or N m."""
        return "N m" if self.style == "torque" else "N"


def loads(picture: Picture, series: Series | None) -> Iterator[Load]:
    """All that act: applied forces and torques, and what else `series` has; None: no springs."""
    for symbol in picture.symbols:
        for style, body, where, value, by in _exerted(picture, symbol, series):
            on = f"{f', {by}' if by else ''} on {picture.bodies[body].name}"
            place = where if isinstance(where, Place | SpacePlace) else None
            at = where
            if isinstance(where, Place):
                at = picture.at(where)
            elif isinstance(picture, SpacePicture):
                at = picture.where(where)
            yield Load(symbol.element, style, f"{symbol.element}{on}", at, value, place)


def _exerted(
    picture: Picture, symbol: Symbol, series: Series | None
) -> Iterator[tuple[str, int, Any, Any, str]]:
    """Style, body, place, value, 0 where the series lack it, and exerting body of each load."""

    def exerted(*words: str, own: Any = None) -> Any:
        names = (f"{symbol.element}.{word}" for word in words)
        known = None if series is None else next((series[n] for n in names if n in series), own)
        return 0.0 if known is None else known

    def vector(*components: Any) -> Any:
        return np.stack(np.broadcast_arrays(*components), axis=-1)

    match symbol.shape:
        case Push(at, x, y, z, turns):
            yield "torque" if turns else "force", at.body, at, vector(x, y, z), ""
        case SpaceDrive(at, x, y, z, turns, own):
            value = np.asarray(exerted("torque", "force", "fx", "fy", "fz", own=own))[..., None]
            yield "torque" if turns else "force", at.body, at, value * vector(x, y, z), ""
        case Wrench(by, at):
            name = picture.bodies[by].name
            for style, letter in (("reaction", "f"), ("torque", "t")):
                parts = (exerted(f"{letter}{c}") for c in "xyz")
                yield style, at.body, at, vector(*parts), name
        case shapes.Spring(i, j, pushes=pushes, exerts=own) if isinstance(picture, SpacePicture):
            away = picture.where(j) - picture.where(i)
            away = away / np.maximum(np.linalg.norm(away, axis=-1, keepdims=True), 1e-300)
            pull = np.asarray(exerted("force", own=own))[..., None] * (-away if pushes else away)
            for place, value in ((i, pull), (j, -pull)):
                if not picture.is_ground(place.body):
                    yield "force", place.body, place, value, ""
        case shapes.Force(at, fx, fy):
            yield "force", at.body, at, fx + 1j * fy, ""
        case shapes.Torque(at, torque):
            yield "torque", at.body, at, torque, ""
        case shapes.Reaction(by, on, x, y) as axes:
            name, force = picture.bodies[by].name, exerted("fx", "force") + 1j * exerted("fy")
            yield "reaction", on, x + 1j * y, force * axes.along, name
            yield "torque", on, x + 1j * y, exerted("torque"), name
        case shapes.Exertion(body, gx, gy, turn, word) as side:
            push, slope, at = exerted(word), gx + 1j * gy, line_of_force(picture, side)[0]
            if isinstance(side, ContactSide):
                push, at = push * _is_nearest(picture, symbol, side), touch(picture, side).point
            yield "reaction", body, at, push * slope, ""
            if not np.any(slope):
                yield "torque", body, Place(body, 0.0, 0.0), push * turn, ""
        case shapes.Drive(j=j, turns=True):
            yield "torque", j.body, j, exerted("torque"), ""
        case shapes.Drive(i, j) as drive:
            way = drive.along if i is None else picture.turned(drive.along, i.body)
            yield "force", j.body, j, exerted("force", "fx", "fy") * way, ""
        case (shapes.Spring(i, j) | shapes.Bearing(i, j)) as pair:
            away = picture.at(j) - picture.at(i)
            pull = exerted("force", "normal") * away / np.where(away == 0, 1.0, abs(away))
            pull = -pull if getattr(pair, "pushes", False) else pull
            for place, value in ((i, pull), (j, -pull)):
                if not picture.is_ground(place.body):
                    yield "force", place.body, place, value, ""
        case shapes.SpiralSpring(i, j) as spring:
            yield "torque", (j if spring.pushes else i).body, j, exerted("torque"), ""


def _is_nearest(picture: Picture, symbol: Symbol, own: ContactSide) -> Any:
    """1 where no other side with this force and body, as of a stop, has a smaller gap, else 0."""
    rivals = [
        side for one, side in picture.having(ContactSide)
        if (one.element, side.force, side.body) == (symbol.element, own.force, own.body)
    ]  # fmt: skip
    number = next(k for k, side in enumerate(rivals) if side is own)
    return np.where(nearest_side(rivals) == number, 1.0, 0.0)[()]


def acting_loads(picture: Picture, series: Series | None, run: Iterable[Load] = ()) -> list[Load]:
    """What acts, is finite at an instant, and no rounding beside the largest in the run."""
    finite = [one for one in loads(picture, series) if np.isfinite(one.at * one.value).any()]
    known = [*finite, *run]
    force, torque = (VANISHING * largest_of(known, word) for word in ("N", "N m"))
    least = {"N": force, "N m": max(torque, force * picture.size)}
    return [load for load in finite if load.size > least[load.unit]]


def largest_of(found: list[Load], unit_: str) -> float:
    """The largest size of a unit; 0 where there is none."""
    return max((load.size for load in found if load.unit == unit_), default=0.0)


def drawn_loads(picture: Picture, acting: list[Load], to_scale: bool) -> list[Arrow]:
    """What acts at one instant, each with its arrow, to scale or of one size: shaft and head."""
    size, scale = picture.size, force_scale(picture, acting) if to_scale else None
    strongest, found = largest_of(acting, "N m"), []
    origins = origin(picture.poses[1:])
    for load in acting:
        if load.style == "torque":
            share = load.size / strongest if to_scale else 1.0
            radius = WIDE * ROUND_ARROW * size * (SMALLEST + (1 - SMALLEST) * share)
            start, sweep = np.radians((120, 200) if load.value > 0 else (60, -200))
            lines = round_arrow(load.at, radius, start, sweep, HEAD * size)
        else:  # on the side of its point with more room
            way = unit(load.value) * (ARROW * size if scale is None else scale * load.size)
            middle = np.append(origins, load.at).mean()
            is_before = abs(load.at - way - middle) > abs(load.at + way - middle)
            start = load.at - way if is_before else load.at
            lines = straight_arrow(start, start + way, HEAD * size)
        found.append((load, arrow(load.style, lines, load.element)))
    return found


def force_scale(picture: Picture, acting: list[Load]) -> float | None:
    """Length per force, m/N, at which the largest arrow fits the picture; None without a force."""
    strongest = largest_of(acting, "N")
    return LARGEST * picture.size / strongest if strongest > 0 else None


def arrow(
    style: str, lines: tuple[Points, Points], element: str = "", body: int = 0
) -> list[Stroke]:
    """The shaft and the head of an arrow."""
    shaft, tip = lines
    head_style = f"{style} head"
    return [
        Stroke(style, body, shaft, False, element),
        Stroke(head_style, body, tip, True, element),
    ]


def driver_strokes(picture: Picture) -> Iterator[Stroke]:
    """Arrows of the drivers, straight or round."""
    size = picture.size
    for symbol, drive in picture.having(shapes.Drive):
        at = picture.at(drive.j)
        if drive.turns:
            start, sweep = np.radians((-50, 230))
            lines = round_arrow(at, ROUND_ARROW * size, start, sweep, HEAD * size)
        else:
            way = drive.along if drive.i is None else picture.turned(drive.along, drive.i.body)
            start = at + (BLOCK[0] + 0.02) * size * way
            lines = straight_arrow(start, start + ARROW * size * way, HEAD * size)
        yield from arrow("driver", lines, symbol.element)


def frame_strokes(picture: Picture) -> Iterator[Stroke]:
    """The axes x' and y' of all bodies that move, and the sign of their centres of mass."""
    size = picture.size
    ring = circle(0j, PIN * size)
    quarter = len(ring) // 4
    for number in range(1, len(picture.bodies)):
        for way in (1.0, 1j):
            axis = straight_arrow(0j, FRAME * size * way, 0.5 * HEAD * size)
            yield from arrow("axis", axis, body=number)
        yield Stroke("center", number, ring, True)
        for start in (0, 2 * quarter):
            wedge = np.append(ring[start : start + quarter + 1], 0j)
            yield Stroke("quadrant", number, wedge, True)


def trace_strokes(picture: Picture) -> Iterator[Stroke]:
    """The paths of the points that are outputs, over the motion."""
    for symbol, shape in picture.having(shapes.Trace):
        yield Stroke("trace", 0, picture.path(shape.at), False, symbol.element)


def dimensions(picture: Picture) -> Iterator[Points]:
    """The pairs of places (2,) whose distances a drawing with dimensions has, m.

    Of each body the distances between neighbouring places: along a line where they lie on one, else
    round their middle, no more than `MOST_EDGES`.
    """
    measured = tuple(s for s in picture.symbols if s.role == "joint"
                     or isinstance(s.shape, shapes.Spring))  # fmt: skip
    chosen = Picture("", picture.bodies, picture.poses, measured)
    for number in range(len(picture.bodies)):
        points = distinct(held_places(chosen, number), SAME * picture.size)
        away = points - points[:1]
        way = unit(away[np.argmax(abs(away))]) if len(points) else 1.0
        if np.all(abs(dot(1j * way, away)) < SAME * picture.size):
            line = points[np.argsort(dot(way, away))]
        else:
            ring = points[np.argsort(np.angle(points - points.mean()))]
            line = np.append(ring, ring[:1])[: MOST_EDGES + 1]
        yield from (picture.placed(np.array(pair), number) for pair in pairwise(line))


def dimension_lines(picture: Picture) -> list[list[Stroke]]:
    """Dimension lines of all bodies, on the side that is farther from the middle of the picture.

    A line that would meet an earlier one lies on the other side, or farther away. The first stroke
    of each is the line itself, (2,), as long as the distance that it measures.
    """
    size = picture.size
    outlines = [
        picture.placed(polygon, number)
        for number, body in enumerate(picture.bodies) for polygon in body.outlines
    ]  # fmt: skip
    middle = np.concatenate(outlines or [origin(picture.poses)]).mean()
    found: list[list[Stroke]] = []
    for ends in dimensions(picture):
        along, distance = unit(ends[1] - ends[0]), abs(ends[1] - ends[0])
        outward = 1.0 if dot(1j * along, ends.mean() - middle) >= 0 else -1.0
        shifts = [
            side * level * outward * OFFSET * size * 1j * along
            for level in OFFSET_LEVELS for side in (1.0, -1.0)
        ]  # fmt: skip
        taken = [samples(one[0].points, CLEARANCE * size / 4) for one in found]
        is_clear = [
            all(abs(line[:, None] - one).min() >= CLEARANCE * size for one in taken)
            for line in (samples(ends + shift, CLEARANCE * size / 4) for shift in shifts)
        ]
        shift = shifts[int(np.argmax(is_clear))]  # the first free one, or else the first
        feet, inset = shift * np.array([0.35, 1.15]), min(0.6 * HEAD * size, 0.3 * distance)
        found.append([
            Stroke("dimension", 0, ends + shift),
            *(Stroke("dimension head", 0, head(end + shift, way, inset), True)
              for end, way in zip(ends, (-along, along), strict=True)),
            *(Stroke("dimension", 0, end + feet) for end in ends),
        ])  # fmt: skip
    return found
