"""What a picture says beside its lines: frames of bodies, paths of points, dimensions."""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.held_places import held_places
from codegen.drawing.line_styles import Stroke
from codegen.drawing.picture import Picture
from codegen.drawing.plane_geometry import (
    FloatArray,
    Points,
    circle,
    convex_hull,
    distinct,
    dot,
    head,
    origin,
    placed,
    straight_arrow,
    unit,
)  # fmt: skip
from codegen.drawing.proportions import HEAD, PIN, SAME

FRAME = 0.075  # layout: length of the axes of a body's frame, in typical lengths
MOST_EDGES = 4  # layout: edges of a body that are measured
OFFSET = 0.07  # layout: distance of a dimension line from what it measures
OFFSET_LEVELS = (1.0, 1.8, 2.6)  # layout: multiples of it, of which the first free one is taken
CLEARANCE = 0.045  # layout: least distance of dimension lines from each other


def frame_strokes(picture: Picture) -> Iterator[Stroke]:
    """The axes x' and y' of all bodies that move, and the sign of their centres of mass."""
    size = picture.size
    ring = circle(0j, PIN * size)
    quarter = len(ring) // 4
    for number in range(1, len(picture.bodies)):
        for way in (1.0, 1j):
            shaft, tip = straight_arrow(0j, FRAME * size * way, 0.5 * HEAD * size)
            yield Stroke("axis", number, shaft)
            yield Stroke("axis head", number, tip, True)
        yield Stroke("center", number, ring, True)
        for start in (0, 2 * quarter):
            wedge = np.append(ring[start : start + quarter + 1], 0j)
            yield Stroke("quadrant", number, wedge, True)


def trace_strokes(picture: Picture, motion: FloatArray) -> Iterator[Stroke]:
    """The paths of the points that are outputs, over poses (instants, bodies, 3)."""
    for symbol, shape in picture.having(shapes.Trace):
        path = placed(shape.at.point, motion[:, shape.at.body])
        yield Stroke("trace", 0, path, False, symbol.element)


def dimensions(picture: Picture) -> Iterator[tuple[int, Points]]:
    """What a drawing with dimensions measures: a body, and two places (2,) of it, m.

    Of each body the distances between neighbouring places: along a line where they lie on one, else
    round their convex hull, of which no more than `MOST_EDGES` edges are measured.
    """
    measured = tuple(s for s in picture.symbols if s.role == "joint"
                     or isinstance(s.shape, shapes.Spring))  # fmt: skip
    chosen = Picture("", picture.bodies, picture.poses, measured, 1.0)
    for number in range(len(picture.bodies)):
        points = distinct(held_places(chosen, number), SAME * picture.size)
        hull = convex_hull(points)
        if len(hull) < 2:
            continue
        if len(hull) == 2:
            along = unit(hull[1] - hull[0])
            ends = list(pairwise(points[np.argsort(dot(along, points))]))
        else:
            ends = list(pairwise([*hull, *hull[:1]]))[:MOST_EDGES]
        for pair in ends:
            yield number, np.array(pair)


class Dimension(NamedTuple):
    """A dimension line: its strokes, its middle, its angle in rad, and the distance in m."""

    strokes: tuple[Stroke, ...]
    middle: complex
    angle: float
    distance: float


def _is_clear(line: Points, found: list[Dimension], size: float) -> bool:
    """Whether a line (2,) keeps its distance from all dimension lines."""
    x = np.linspace(0.0, 1.0, 21)
    points, *others = (
        ends[0] + x * (ends[1] - ends[0])
        for ends in (line, *(other.strokes[0].points for other in found))
    )
    return all(abs(points[:, None] - other).min() >= CLEARANCE * size for other in others)


def dimension_lines(picture: Picture) -> list[Dimension]:
    """Dimension lines of all bodies, on the side that is farther from the middle of the picture.

    A line that would meet an earlier one lies on the other side, or farther away.
    """
    size = picture.size
    outlines = [
        picture.placed(polygon, number)
        for number, body in enumerate(picture.bodies) for polygon in body.polygons
    ]  # fmt: skip
    middle = np.concatenate(outlines or [origin(picture.poses)]).mean()
    found: list[Dimension] = []
    for body, ends in dimensions(picture):
        a, b = picture.placed(ends, body)
        along, distance = unit(b - a), abs(b - a)
        outward = 1.0 if dot(1j * along, (a + b) / 2 - middle) >= 0 else -1.0
        shifts = [
            side * level * outward * OFFSET * size * 1j * along
            for level in OFFSET_LEVELS for side in (1.0, -1.0)
        ]  # fmt: skip
        lines = [np.array([a, b]) + shift for shift in shifts]
        chosen = next((k for k, one in enumerate(lines) if _is_clear(one, found, size)), 0)
        line, shift = lines[chosen], shifts[chosen]
        inset = min(0.6 * HEAD * size, 0.3 * distance)
        strokes = [Stroke("dimension", 0, line)]
        for end, way in zip(line, (-along, along), strict=True):
            strokes.append(Stroke("dimension head", 0, head(end, way, inset), True))
        feet = shift * np.array([0.35, 1.15])
        strokes += [Stroke("dimension", 0, end + feet) for end in (a, b)]
        angle = float(np.angle(along))
        found.append(Dimension(tuple(strokes), complex(line.mean()), angle, distance))
    return found
