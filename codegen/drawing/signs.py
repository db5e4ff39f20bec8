"""Signs of a picture that belong to no body: arrows of drivers, frames, dimensions."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.arrow_lines import head, round_arrow, straight_arrow
from codegen.drawing.picture import Picture
from codegen.drawing.polygons import FloatArray, circle, convex_hull, distinct, normal, placed, unit
from codegen.drawing.sizes_and_held_places import BLOCK, PIN, SAME, held_places
from codegen.drawing.strokes import Stroke

HEAD = 0.032  # layout: length of an arrow's head, in typical lengths
ARROW = 0.15  # layout: length of an arrow that is not to scale
ROUND = 0.062  # layout: radius of a round arrow
FRAME = 0.075  # layout: length of the axes of a body's frame
MOST_EDGES = 4  # layout: edges of a body that are measured
OFFSET = 0.07  # layout: distance of a dimension line from what it measures
OFFSET_LEVELS = (1.0, 1.8, 2.6)  # layout: multiples of it, of which the first free one is taken
CLEARANCE = 0.045  # layout: least distance of dimension lines from each other


def driver_strokes(picture: Picture) -> tuple[Stroke, ...]:
    """Arrows of the drivers, straight or round."""
    found: list[Stroke] = []
    size = picture.size
    for symbol in picture.symbols:
        shape = symbol.shape
        if isinstance(shape, shapes.Drive):
            at = np.array(picture.position(shape.j))
            if shape.turns:
                lines = round_arrow(at, ROUND * size, np.radians(-50), np.radians(230), HEAD * size)
            else:
                turn = picture.poses[shape.i.body, 2] if shape.i is not None else 0.0
                way = turned(np.array([shape.ux, shape.uy], dtype=float), turn)
                start = at + (BLOCK[0] + 0.02) * size * way
                lines = straight_arrow(start, start + ARROW * size * way, HEAD * size)
            found += arrow("driver", lines, symbol.element)
    return tuple(found)


def arrow(style: str, lines: tuple[FloatArray, FloatArray], element: str) -> list[Stroke]:
    """The shaft and the head of an arrow."""
    return [
        Stroke(style, 0, lines[0], False, element),
        Stroke(f"{style} head", 0, lines[1], True, element),
    ]


def turned(direction: FloatArray, angle: float) -> FloatArray:
    """The unit vector along a direction (2,), turned by an angle in rad."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = unit(direction)
    return np.array([c * x - s * y, s * x + c * y])


def frame_strokes(picture: Picture) -> tuple[Stroke, ...]:
    """The axes x' and y' of all bodies that move, and the sign of their centres of mass."""
    size, found = picture.size, []
    for number in range(1, len(picture.bodies)):
        for way in (np.array([1.0, 0.0]), np.array([0.0, 1.0])):
            shaft, tip = straight_arrow(np.zeros(2), FRAME * size * way, 0.5 * HEAD * size)
            found += [Stroke("axis", number, shaft), Stroke("axis head", number, tip, True)]
        ring = circle(np.zeros(2), PIN * size)
        found.append(Stroke("center", number, ring, True))
        quarter = len(ring) // 4
        for start in (0, 2 * quarter):
            wedge = np.concatenate([np.zeros((1, 2)), ring[start : start + quarter + 1]])
            found.append(Stroke("quadrant", number, wedge, True))
    return tuple(found)


def trace_strokes(picture: Picture, motion: FloatArray) -> tuple[Stroke, ...]:
    """The paths of the points that are outputs, over poses (instants, bodies, 3)."""
    found = []
    for symbol in picture.symbols:
        if isinstance(symbol.shape, shapes.Trace):
            at = symbol.shape.at
            local = np.array([[at.x, at.y]])
            path = np.array([placed(local, poses[at.body])[0] for poses in motion])
            found.append(Stroke("trace", 0, path, False, symbol.element))
    return tuple(found)


def dimensions(picture: Picture) -> list[tuple[int, FloatArray, float]]:
    """What a drawing with dimensions measures: body, the two places (2, 2) in m, and the distance.

    Of each body the distances between neighbouring places: along a line where they lie on one, else
    round their convex hull, of which no more than `MOST_EDGES` edges are measured.
    """
    found = []
    for number in range(len(picture.bodies)):
        points = distinct(_measured(picture, number), SAME * picture.size)
        if len(points) < 2:
            continue
        hull = convex_hull(points)
        if len(hull) == 2:
            along = unit(hull[1] - hull[0])
            line = points[np.argsort(points @ along)]
            pairs = list(pairwise(line))
        else:
            pairs = list(zip(hull, np.roll(hull, -1, axis=0), strict=True))[:MOST_EDGES]
        for a, b in pairs:
            found.append((number, np.array([a, b]), float(np.hypot(*(b - a)))))
    return found


def _measured(picture: Picture, body: int) -> FloatArray:
    """The places of joints and springs on a body, those of other forces left out."""
    chosen = [s for s in picture.symbols if s.role == "joint" or isinstance(s.shape, shapes.Spring)]
    return held_places(Picture("", picture.bodies, picture.poses, tuple(chosen), 1.0), body)


class Dimension(NamedTuple):
    """A dimension line: its strokes, its middle (2,), its angle in rad, and the distance in m."""

    strokes: tuple[Stroke, ...]
    middle: FloatArray
    angle: float
    distance: float


def _is_clear(line: FloatArray, found: list[Dimension], size: float) -> bool:
    """Whether a line (2, 2) keeps its distance from all dimension lines."""
    x = np.linspace(0.0, 1.0, 21)[:, None]
    own = line[0] + x * (line[1] - line[0])
    for other in found:
        start, end = other.strokes[0].points
        points = start + x * (end - start)
        if np.hypot(*(own[:, None] - points[None]).transpose(2, 0, 1)).min() < CLEARANCE * size:
            return False
    return True


def dimension_lines(picture: Picture) -> list[Dimension]:
    """Dimension lines of all bodies, on the side that is farther from the middle of the picture.

    A line that would meet an earlier one lies on the other side, or farther away.
    """
    size = picture.size
    points = np.concatenate([
        placed(np.array(outline), picture.poses[k])
        for k, body in enumerate(picture.bodies) for outline in body.outlines
    ] or [picture.poses[:, :2]])  # fmt: skip
    middle = points.mean(axis=0)
    found: list[Dimension] = []
    for body, local, distance in dimensions(picture):
        a, b = placed(local, picture.poses[body])
        across = normal(unit(b - a))
        outward = 1.0 if float(((a + b) / 2 - middle) @ across) >= 0 else -1.0
        places = [
            np.array([a, b]) + way * OFFSET * size * across
            for way in (outward * side * level for level in OFFSET_LEVELS for side in (1.0, -1.0))
        ]
        line = next((one for one in places if _is_clear(one, found, size)), places[0])
        shift = line[0] - a
        inset = min(0.6 * HEAD * size, 0.3 * distance)
        strokes = [Stroke("dimension", 0, line)]
        for end, way in ((line[0], a - b), (line[1], b - a)):
            strokes.append(Stroke("dimension head", 0, head(end, way, inset), True))
        for end in (a, b):
            foot, top = end + 0.35 * shift, end + 1.15 * shift
            strokes.append(Stroke("dimension", 0, np.array([foot, top])))
        angle = float(np.arctan2(*(b - a)[::-1]))
        found.append(Dimension(tuple(strokes), line.mean(axis=0), angle, distance))
    return found
