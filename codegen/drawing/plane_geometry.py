"""Plane geometry in complex numbers: a point is x + iy in m, a direction has the length 1."""

from collections.abc import Iterator, Sequence
from itertools import islice
from math import atan, ceil, cos, pi, sin
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import module_of_extra

Corner = tuple[Any, Any]  # (x', y') in m, numbers and expressions of parameters
FloatArray = npt.NDArray[np.float64]
Points = npt.NDArray[np.complexfloating[Any, Any]]
"""Points (k,) of a polyline or polygon, m."""

CORNERS = 48  # layout: of the polygon that is drawn for a disc
ROUND = 32  # layout: corners of a full circle; of rounded corners three times as many
HEAD = 0.36  # layout: half width of an arrow's head over its length
_ON_LINE = 1e-6  # accuracy: of a stroke's place, in spacings


def pairs(points: Points) -> FloatArray:
    """The coordinates x and y of points, (…, 2), as Matplotlib takes them."""
    return np.stack([points.real, points.imag], axis=-1)


def dot(a: Any, b: Any) -> Any:
    """The scalar product of two vectors, or of arrays of them."""
    return (np.conj(a) * b).real


def unit(vector: Any) -> Any:
    """The direction of a vector, or of each of an array; x where its length is zero."""
    length = np.abs(vector)
    return np.where(length > 0, vector / np.where(length > 0, length, 1.0), 1.0 + 0.0j)[()]


def origin(pose: FloatArray) -> Any:
    """The place x + iy of a pose (x, y, φ), or of several, (…, 3)."""
    return pose[..., 0] + 1j * pose[..., 1]


def placed(points: Any, pose: FloatArray) -> Any:
    """Points of a frame in the frame of its pose (x, y, φ), or one point at poses (k, 3), m."""
    return points * np.exp(1j * pose[..., 2]) + origin(pose)


def in_frame(points: Any, pose: FloatArray) -> Any:
    """The inverse of `placed`: points in the frame that has this pose."""
    return (points - origin(pose)) * np.exp(-1j * pose[..., 2])


def circle(center: complex, radius: float, corners: int = ROUND) -> Points:
    """A regular polygon (corners,) in place of a circle, counterclockwise."""
    return np.asarray(center + radius * np.exp(2j * np.pi * np.arange(corners) / corners))


def arc(center: complex, radius: float, start: float, sweep: float) -> Points:
    """A polyline (k,) along an arc from the angle `start` over `sweep`, rad."""
    count = max(2, int(np.ceil(abs(sweep) / np.pi * ROUND)) + 1)
    return np.asarray(center + radius * np.exp(1j * (start + sweep * np.linspace(0, 1, count))))


def box(center: complex, along: complex, half_length: float, half_width: float) -> Points:
    """A rectangle (4,) about a centre, its length in the direction `along`."""
    corners = half_length * np.array([-1, 1, 1, -1]) + 1j * half_width * np.array([-1, -1, 1, 1])
    return center + along * corners


def samples(line: Points, spacing: float) -> Points:
    """Points along a line (k,), at equal distances of at most `spacing`."""
    along = np.cumsum([0.0, *abs(np.diff(line))])
    count = int(np.ceil(along[-1] / spacing)) + 1
    return np.asarray(np.interp(np.linspace(0.0, along[-1], count), along, line))


def convex_hull(points: Points) -> Points:
    """Corners (k,) of the convex hull, counterclockwise; all points where they lie on a line."""
    from scipy.spatial import ConvexHull, QhullError  # here: a compiler needs no hulls

    try:
        return np.asarray(points[ConvexHull(pairs(points)).vertices])
    except (QhullError, ValueError):  # ValueError: of points that are not numbers
        return points


def rounded_hull(points: Points, radius: float) -> Points:
    """The convex hull of points (k,), widened by `radius` on all sides; counterclockwise.

    One point gives a disc, points on a line give a bar with round ends.
    """
    return convex_hull((points[:, None] + circle(0j, radius, 3 * ROUND)).ravel())


def area(polygon: Points) -> float:
    """The area of a closed polygon (k,), positive where it is counterclockwise, m²."""
    return float((polygon.conj() * np.roll(polygon, -1)).imag.sum()) / 2


def crossings(polygons: Points) -> FloatArray:
    """Where the edges of closed polygons (…, k) cross the x axis; not a number of those that don't.

    The result has a number for each edge, (…, k).
    """
    ahead = np.roll(polygons, -1, axis=-1)
    crosses = (polygons.imag > 0) != (ahead.imag > 0)
    share = polygons.imag / np.where(crosses, polygons.imag - ahead.imag, 1.0)
    return np.where(crosses, polygons.real + share * (ahead.real - polygons.real), np.nan)


def is_closed(curve: Points) -> bool:
    """Whether the ends of a sampled curve (k,) are no farther apart than its samples are."""
    return len(curve) > 3 and abs(curve[-1] - curve[0]) <= 2 * abs(np.diff(curve)).max()


def contains(polygon: Points, point: complex) -> bool:
    """Whether a point lies inside a closed polygon (k,), by the parity of crossings."""
    return bool(np.count_nonzero(crossings(polygon - point) > 0) % 2)


def distance_to_edge(polygon: Points, point: complex) -> float:
    """The least distance of a point from the edges of a polygon, m."""
    edges, ahead = np.roll(polygon, -1) - polygon, point - polygon
    squares = np.maximum(abs(edges) ** 2, np.finfo(float).tiny)
    share = np.clip(dot(edges, ahead) / squares, 0.0, 1.0)
    return float(abs(ahead - share * edges).min())


def distinct(points: Points, tolerance: float) -> Points:
    """The points (k,) without those that lie within `tolerance` of an earlier one."""
    kept: list[complex] = []
    for p in points:
        if all(abs(p - other) > tolerance for other in kept):
            kept.append(p)
    return np.array(kept, dtype=complex)


def head(tip: complex, direction: complex, length: float) -> Points:
    """The head of an arrow as a triangle (3,), its tip first."""
    corners = length * np.array([0, -1 + HEAD * 1j, -1 - HEAD * 1j])
    return np.asarray(tip + unit(direction) * corners)


def straight_arrow(start: complex, end: complex, length: float) -> tuple[Points, Points]:
    """The shaft (2,) and head (3,) of an arrow; a short arrow has a head of its own length."""
    length = min(length, abs(end - start))
    return np.array([start, end - 0.8 * length * unit(end - start)]), head(end, end - start, length)


def round_arrow(
    center: complex, radius: float, start: float, sweep: float, length: float
) -> tuple[Points, Points]:
    """The arc (k,) and head (3,) of an arrow round a centre; the sign of `sweep` is its way."""
    way = np.copysign(1.0, sweep)
    end = start + sweep
    bend = way * 0.8 * length / radius  # the angle that the head covers
    tip = head(center + radius * np.exp(1j * end), way * 1j * np.exp(1j * (end - bend / 2)), length)
    return arc(center, radius, start, sweep - bend), tip


def hatching(start: complex, end: complex, side: float, spacing: float) -> list[Points]:
    """Strokes (2,) of the ground along a line, on its left (`side` 1) or right (-1).

    They begin at multiples of the spacing from the origin, so that those of lines that lie on one
    another coincide.
    """
    along = unit(end - start)
    lean = (side * 1j - 1) * along * spacing
    first, last = dot(along, start) / spacing, dot(along, end) / spacing
    marks = np.arange(np.floor(first + _ON_LINE) + 1, np.floor(last + _ON_LINE) + 1)
    if not len(marks):
        marks = np.array([last])
    return [np.array([foot, foot + lean]) for foot in start + (marks - first) * spacing * along]


def library(name: str) -> Any:
    """A module of the extra `shapes`; InputError where it is not installed."""
    return module_of_extra(name, "shapes", f"Outlines need {name}")


def flattened(vertices: tuple[Corner, ...], bulges: tuple[float, ...]) -> tuple[Corner, ...]:
    """The vertices, and points between them on arcs."""
    points: list[Corner] = []
    for (x, y), end, bulge in zip(vertices, vertices[1:] + vertices[:1], bulges, strict=True):
        dx, dy, half = end[0] - x, end[1] - y, -2.0 * atan(bulge)
        parts = ceil(abs(half) / pi * CORNERS - 1e-9) or 1
        points.append((x, y))
        for k in range(1, parts):
            size, turn = sin(half * k / parts) / sin(half), half * (1 - k / parts)
            u, v = size * cos(turn), size * sin(turn)  # along the chord, and to its left
            points.append((x + u * dx - v * dy, y + u * dy + v * dx))
    return tuple(points)


def area_problem(bulges: Sequence[tuple[float, ...]], numbers: Any) -> str | None:
    """Why an outline bounds no area, or a hole is none in it; None where all is well.

    Rows of `bulges` are the outline and its holes, `numbers` x and y of all vertices in turn.
    """
    shapely = library("shapely")
    places: Iterator[Any] = iter(np.reshape(numbers, (-1, 2)).tolist())
    shell, *holes = (flattened(tuple(islice(places, len(one))), one) for one in bulges)
    why = shapely.is_valid_reason(shapely.Polygon(shell, holes))
    if why == "Valid Geometry":
        return None
    place = ", ".join(f"{float(x):.4g}" for x in why.partition("[")[2].rstrip("]").split())
    whole, *inner = map(shapely.Polygon, (shell, *holes))
    fits = [hole.is_valid and whole.is_valid and whole.contains_properly(hole) for hole in inner]
    what = "two holes meet" if all(fits) else f"hole {fits.index(False) + 1} is not within it"
    what = what if whole.is_valid else "its line crosses itself or bounds no area"
    return f"{what} at ({place}) m; give lines round areas that do not cross."
