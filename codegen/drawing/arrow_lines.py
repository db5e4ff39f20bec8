"""Arrows, straight and round, and the hatching of the ground."""

import numpy as np

from codegen.drawing.polygons import FloatArray, arc, normal, unit

HEAD = 0.36  # layout: half width of an arrow's head over its length
_ON_LINE = 1e-6  # accuracy: of a stroke's place, in spacings


def head(tip: FloatArray, direction: FloatArray, length: float) -> FloatArray:
    """The head of an arrow as a triangle (3, 2), its tip first."""
    u = unit(direction)
    base, side = tip - length * u, HEAD * length * normal(u)
    return np.array([tip, base + side, base - side])


def straight_arrow(
    start: FloatArray, end: FloatArray, length: float
) -> tuple[FloatArray, FloatArray]:
    """The shaft (2, 2) and head (3, 2) of an arrow; a short arrow has a head of its own length."""
    reach = float(np.hypot(*(end - start)))
    length = min(length, reach)
    return np.array([start, end - 0.8 * length * unit(end - start)]), head(end, end - start, length)


def round_arrow(
    center: FloatArray, radius: float, start: float, sweep: float, length: float
) -> tuple[FloatArray, FloatArray]:
    """The arc (k, 2) and head (3, 2) of an arrow round a centre; the sign of `sweep` is its way."""
    way = float(np.copysign(1.0, sweep))
    end = start + sweep
    bend = way * 0.8 * length / radius  # the angle that the head covers
    tip = center + radius * np.array([np.cos(end), np.sin(end)])
    middle = end - bend / 2
    heading = way * np.array([-np.sin(middle), np.cos(middle)])
    return arc(center, radius, start, sweep - bend), head(tip, heading, length)


def hatching(start: FloatArray, end: FloatArray, side: float, spacing: float) -> list[FloatArray]:
    """Strokes (2, 2) of the ground along a line, on its left (`side` 1) or right (-1).

    They begin at multiples of the spacing from the origin, so that those of lines that lie on one
    another coincide.
    """
    along = unit(end - start)
    lean = (side * normal(along) - along) * spacing
    first, last = float(start @ along) / spacing, float(end @ along) / spacing
    marks = np.arange(np.floor(first + _ON_LINE) + 1, np.floor(last + _ON_LINE) + 1) * spacing
    if not len(marks):
        marks = np.array([last * spacing])
    feet = start + np.outer(marks - float(start @ along), along)
    return [np.array([foot, foot + lean]) for foot in feet]
