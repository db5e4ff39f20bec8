"""Places for names beside what they name, so that names overlap neither each other nor lines.

All lengths are in points of the paper.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from codegen.drawing.plane_geometry import FloatArray

ANGLES = 16  # layout: directions from an anchor in which a name may stand
DISTANCES = (0.0, 5.0, 12.0, 22.0, 36.0)  # layout: points between an anchor's room and the name
LABEL_COST, LINE_COST, OUTSIDE_COST = 400.0, 6.0, 300.0  # layout: of an overlap, per sample
DISTANCE_COST = 0.35  # layout: per point of distance
SWEEPS = 3  # layout: how often all names are placed anew, given the others


class Label(NamedTuple):
    """A name to be placed.

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
    size: FloatArray
    room: float = 3.0

    def candidates(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Centres (c, 2) at which the name may stand, the anchor of each, and the cost of each.

        The name's nearest point is at each distance from each anchor, in each direction.
        """
        number = np.arange(ANGLES)
        angles = 2 * np.pi * number / ANGLES
        ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        distances = np.array(DISTANCES)[:, None]
        shifts = (self.room + distances)[..., None] * ways + self.size / 2 * np.clip(
            1.5 * ways, -1, 1
        )
        centers = self.anchors[:, None, None] + shifts
        order = 1.5 * np.arange(len(self.anchors))[:, None, None]
        costs = DISTANCE_COST * distances + order + 0.4 * ((number * 3) % 4 != 2)
        anchors = np.broadcast_to(self.anchors[:, None, None], centers.shape)
        return centers.reshape(-1, 2), anchors.reshape(-1, 2), costs.ravel()


class PlacedLabel(NamedTuple):
    """Where a name stands: its centre, its anchor, and whether it is far from that."""

    center: FloatArray
    anchor: FloatArray
    is_far: bool


def place_labels(
    labels: Sequence[Label], lines: FloatArray, low: FloatArray, high: FloatArray
) -> list[PlacedLabel]:
    """Where the names stand: each in turn takes its best place, given those of all others.

    Parameters
    ----------
    lines
        Samples of all lines, (n, 2): a name should cover few of them.
    low, high
        Least and greatest x and y.
    """
    choices = [label.candidates() for label in labels]
    costs = []
    for label, (centers, _, own) in zip(labels, choices, strict=True):
        half = label.size / 2
        covered = [np.count_nonzero(_is_within(lines - center, half)) for center in centers]
        is_outside = np.any((centers - half < low) | (centers + half > high), axis=1)
        costs.append(own + LINE_COST * np.array(covered) + OUTSIDE_COST * is_outside)
    chosen = [int(np.argmin(cost)) for cost in costs]
    for _ in range(SWEEPS):
        for k, label in enumerate(labels):
            total = costs[k].copy()
            for other, number in enumerate(chosen):
                if other != k:
                    away = choices[k][0] - choices[other][0][number]
                    total += LABEL_COST * _is_within(away, (label.size + labels[other].size) / 2)
            chosen[k] = int(np.argmin(total))
    spots = []
    for label, (centers, anchors, _), number in zip(labels, choices, chosen, strict=True):
        center, anchor = centers[number], anchors[number]
        gap = np.hypot(*np.maximum(np.abs(center - anchor) - label.size / 2, 0.0))
        spots.append(PlacedLabel(center, anchor, bool(gap > label.room + DISTANCES[2] + 1)))
    return spots


def _is_within(away: FloatArray, half: FloatArray) -> FloatArray:
    """Whether vectors (n, 2) end within a box of this half width and height, and a point more."""
    return np.asarray(np.all(np.abs(away) < half + 1.0, axis=1))


def samples(polylines: Sequence[FloatArray], spacing: float) -> FloatArray:
    """Points (n, 2) along polylines (k, 2), no farther apart than `spacing`."""
    parts = [np.empty((0, 2))]
    for line in polylines:
        steps = np.hypot(*np.diff(line, axis=0).T)
        for a, b, length in zip(line[:-1], line[1:], steps, strict=True):
            count = max(1, int(np.ceil(length / spacing)))
            parts.append(a + np.arange(count)[:, None] / count * (b - a))
        parts.append(line[-1:])
    return np.concatenate(parts)
