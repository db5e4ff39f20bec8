"""Polygons and polylines of plane figures: discs, boxes, rounded hulls, poses."""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

ROUND = 32  # layout: corners of a full circle; a rounded corner has its part of them


def placed(points: FloatArray, pose: FloatArray) -> FloatArray:
    """Points (k, 2) of a frame in the frame of its pose (x, y, φ), m."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray(points @ np.array([[c, s], [-s, c]]) + pose[:2])


def in_frame(points: FloatArray, pose: FloatArray) -> FloatArray:
    """The inverse of `placed`: points (k, 2) in the frame that has this pose."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray((points - pose[:2]) @ np.array([[c, -s], [s, c]]))


def normal(direction: FloatArray) -> FloatArray:
    """The direction (2,) turned by a quarter of a turn to the left."""
    return np.array([-direction[1], direction[0]])


def unit(vector: FloatArray) -> FloatArray:
    """The direction of a vector (2,); x where its length is zero."""
    length = float(np.hypot(*vector))
    return vector / length if length > 0 else np.array([1.0, 0.0])


def circle(center: FloatArray, radius: float, corners: int = ROUND) -> FloatArray:
    """A regular polygon (corners, 2) in place of a circle, counterclockwise."""
    angles = 2 * np.pi * np.arange(corners) / corners
    return center + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def arc(center: FloatArray, radius: float, start: float, sweep: float) -> FloatArray:
    """A polyline (k, 2) along an arc from the angle `start` over `sweep`, rad."""
    count = max(2, int(np.ceil(abs(sweep) / (2 * np.pi) * 2 * ROUND)) + 1)
    angles = start + sweep * np.linspace(0, 1, count)
    return center + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def box(center: FloatArray, along: FloatArray, half_length: float, half_width: float) -> FloatArray:
    """A rectangle (4, 2) about a centre, its length in the direction `along`."""
    u, n = along * half_length, normal(along) * half_width
    return np.array([center - u - n, center + u - n, center + u + n, center - u + n])


def convex_hull(points: FloatArray) -> FloatArray:
    """Corners (k, 2) of the convex hull, counterclockwise, by Andrew's monotone chain.

    Points on an edge are left out. One point is its own hull, and two are that of points on a line.
    """
    order = sorted({(float(x), float(y)) for x, y in points})
    if len(order) < 3:
        return np.array(order)
    halves = []
    for sequence in (order, order[::-1]):
        chain: list[tuple[float, float]] = []
        for p in sequence:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        halves.append(chain[:-1])
    return np.array(halves[0] + halves[1])


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def rounded_hull(points: FloatArray, radius: float) -> FloatArray:
    """The convex hull of points (k, 2), widened by `radius` on all sides; counterclockwise.

    One point gives a disc, points on a line give a bar with round ends.
    """
    hull = convex_hull(points)
    if len(hull) == 1:
        return circle(hull[0], radius)
    edges = np.roll(hull, -1, axis=0) - hull
    headings = np.arctan2(edges[:, 1], edges[:, 0]) - np.pi / 2  # of the outer normals
    corners = []
    for k, corner in enumerate(hull):
        turn = (headings[k] - headings[k - 1]) % (2 * np.pi)
        count = max(1, int(np.ceil(turn / (2 * np.pi) * ROUND)))
        angles = headings[k - 1] + turn * np.arange(count + 1) / count
        corners.append(corner + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    return np.concatenate(corners)


def area(polygon: FloatArray) -> float:
    """The area of a closed polygon (k, 2), positive where it is counterclockwise, m²."""
    x, y = polygon[:, 0], polygon[:, 1]
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def contains(polygon: FloatArray, point: FloatArray) -> bool:
    """Whether a point (2,) lies inside a closed polygon (k, 2), by the parity of crossings."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    spans = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
    rise = np.where(spans, b[:, 1] - a[:, 1], 1.0)
    x = a[:, 0] + (point[1] - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
    return bool(np.count_nonzero(spans & (point[0] < x)) % 2)


def distance_to_edge(polygon: FloatArray, point: FloatArray) -> float:
    """The least distance of a point from the edges of a polygon, m."""
    edges, ahead = np.roll(polygon, -1, axis=0) - polygon, point - polygon
    squares = np.maximum(np.sum(edges * edges, axis=1), np.finfo(float).tiny)
    share = np.clip(np.sum(edges * ahead, axis=1) / squares, 0.0, 1.0)
    return float(np.hypot(*(ahead - share[:, None] * edges).T).min())


def distinct(points: FloatArray, tolerance: float) -> FloatArray:
    """The points (k, 2) without those that lie within `tolerance` of an earlier one."""
    kept: list[FloatArray] = []
    for p in points:
        if all(np.hypot(*(p - other)) > tolerance for other in kept):
            kept.append(p)
    return np.array(kept).reshape(-1, 2)
