"""Places for names beside what they name, so that names overlap neither each other nor lines."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from codegen.drawing.polygons import FloatArray

ANGLES = 16  # layout: directions from an anchor in which a name may stand
DISTANCES = (0.0, 5.0, 12.0, 22.0, 36.0)  # layout: points between an anchor's room and the name
LABEL_COST, LINE_COST, OUTSIDE_COST = 400.0, 6.0, 300.0  # layout: of an overlap, per sample
DISTANCE_COST = 0.35  # layout: per point of distance
SWEEPS = 3  # layout: how often all names are placed anew, given the others


class Label(NamedTuple):
    """A name to be placed, in points.

    Attributes
    ----------
    anchors
        Places beside which it may stand, (k, 2), the best first.
    size
        Its width and height.
    room
        Radius about an anchor that it keeps clear of.
    """

    anchors: FloatArray
    size: tuple[float, float]
    room: float = 3.0


class PlacedLabel(NamedTuple):
    """Where a name stands: its centre, its anchor, in points, and whether it is far from that."""

    center: FloatArray
    anchor: FloatArray
    is_far: bool


def place_labels(
    labels: Sequence[Label], lines: FloatArray, bounds: tuple[float, float, float, float]
) -> list[PlacedLabel]:
    """Where the names stand: each in turn takes its best place, given those of all others.

    Parameters
    ----------
    lines
        Samples of all lines, (n, 2), in points: a name should cover few of them.
    bounds
        Least x and y, greatest x and y.
    """
    choices = [_candidates(label) for label in labels]
    costs = [
        own + LINE_COST * _covered(centers, label.size, lines) + _outside(centers, label, bounds)
        for label, (centers, _, own) in zip(labels, choices, strict=True)
    ]
    chosen = [int(np.argmin(cost)) for cost in costs]
    for _ in range(SWEEPS):
        for k, label in enumerate(labels):
            centers = choices[k][0]
            total = costs[k].copy()
            for other, number in enumerate(chosen):
                if other != k:
                    at = choices[other][0][number]
                    total += LABEL_COST * _overlaps(centers, label.size, at, labels[other].size)
            chosen[k] = int(np.argmin(total))
    spots = []
    for label, (centers, anchors, _), number in zip(labels, choices, chosen, strict=True):
        center, anchor = centers[number], anchors[number]
        half = np.array(label.size) / 2
        away = np.maximum(np.abs(center - anchor) - half, 0.0)
        spots.append(
            PlacedLabel(center, anchor, bool(np.hypot(*away) > label.room + DISTANCES[2] + 1))
        )
    return spots


def _candidates(label: Label) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Centres (c, 2) at which a name may stand, the anchor of each, and the cost of each."""
    angles = 2 * np.pi * np.arange(ANGLES) / ANGLES
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    half = np.array(label.size) / 2
    centers, anchors, costs = [], [], []
    for order, anchor in enumerate(label.anchors):
        for distance in DISTANCES:
            # a box whose nearest point is at this distance from the anchor, in each direction
            reach = label.room + distance
            for k, way in enumerate(ways):
                centers.append(anchor + reach * way + half * np.clip(1.5 * way, -1, 1))
                anchors.append(anchor)
                costs.append(DISTANCE_COST * distance + 1.5 * order + 0.4 * ((k * 3) % 4 != 2))
    return np.array(centers), np.array(anchors), np.array(costs)


def _covered(centers: FloatArray, size: tuple[float, float], lines: FloatArray) -> FloatArray:
    half = np.array(size) / 2 + 1.0
    counts = np.empty(len(centers))
    for k, center in enumerate(centers):
        counts[k] = np.count_nonzero(np.all(np.abs(lines - center) < half, axis=1))
    return counts


def _overlaps(
    centers: FloatArray, size: tuple[float, float], at: FloatArray, other: tuple[float, float]
) -> FloatArray:
    half = (np.array(size) + np.array(other)) / 2 + 1.0
    return np.asarray(np.all(np.abs(centers - at) < half, axis=1), dtype=float)


def _outside(
    centers: FloatArray, label: Label, bounds: tuple[float, float, float, float]
) -> FloatArray:
    half = np.array(label.size) / 2
    low, high = np.array(bounds[:2]), np.array(bounds[2:])
    out = np.any((centers - half < low) | (centers + half > high), axis=1)
    return np.asarray(OUTSIDE_COST * out, dtype=float)


def samples(polylines: Sequence[FloatArray], spacing: float) -> FloatArray:
    """Points (n, 2) along polylines, no farther apart than `spacing`."""
    parts = [np.empty((0, 2))]
    for line in polylines:
        steps = np.hypot(*np.diff(line, axis=0).T)
        for a, b, length in zip(line[:-1], line[1:], steps, strict=True):
            count = max(1, int(np.ceil(length / spacing)))
            parts.append(a + np.arange(count)[:, None] / count * (b - a))
        parts.append(line[-1:])
    return np.concatenate(parts)
