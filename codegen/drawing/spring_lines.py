"""Polylines of springs, dampers, actuators and torsion springs between two places.

A player draws them anew at every instant, from the lines of `spring_parts`. Along the line from
place i to place j, s runs from 0 to 1 and n is the normal to its left:

- a spring is straight to s = 0.2, has `COILS` teeth of the height `half_width` to s = 0.8, and is
  straight again;
- a damper's rod ends in a piston at s = 0.55, and its pot is open at s = 0.65 and closed at 0.35;
- an actuator is a cylinder from s = 0.15 to 0.6 and a rod from there;
- several of them lie side by side, 2.4 half widths apart, between two crossbars at s = 0.1 and 0.9.
"""

import numpy as np

from codegen.drawing.polygons import FloatArray, normal, unit

COILS = 6  # layout: teeth of a zigzag
SPACING = 2.4  # layout: distance of parallel parts, in half widths
SPIRAL_TURNS = 2.25  # layout: turns of a torsion spring that is not wound up
SPIRAL_POINTS = 160  # layout: of a torsion spring
SPIRAL = (1.8, 4.4)  # layout: inner and outer radius of a torsion spring, in pins
ROUND_CUPS = (3.2, 4.6)  # layout: radii of the arcs of a torsion damper, in pins
ROUND_DAMPER = (0.6, 2.2)  # layout: where its arcs begin, from x' of body j, and their sweep, rad
ROUND_MOTOR = 3.1  # layout: radius of the circle of a motor, in pins


def spring_lines(
    i: FloatArray,
    j: FloatArray,
    half_width: float,
    elastic: bool = True,
    damper: bool = False,
    actuator: bool = False,
) -> list[tuple[str, FloatArray]]:
    """Style and polyline (k, 2) of the parts of a spring, damper and actuator from i to j, m."""
    return [
        (style, _between(i, j, half_width, line))
        for style, line in spring_parts(elastic, damper, actuator)
    ]


def spring_parts(
    elastic: bool = True, damper: bool = False, actuator: bool = False
) -> list[tuple[str, FloatArray]]:
    """Style and polyline (k, 2) in s, and n in half widths: a player has them from here."""
    parts = [
        (style, lines)
        for wanted, style, lines in (
            (elastic, "spring", _zigzag),
            (damper, "damper", _dashpot),
            (actuator, "actuator", _cylinder),
        )
        if wanted
    ]
    offsets = SPACING * (np.arange(len(parts)) - (len(parts) - 1) / 2)
    result = [
        (style, np.array(points, dtype=float) + np.array([0.0, offset]))
        for (style, lines), offset in zip(parts, offsets, strict=True)
        for points in lines(len(parts) > 1)
    ]
    if len(parts) > 1:
        reach = float(offsets[-1])
        bars = [[(s, -reach), (s, reach)] for s in (0.1, 0.9)]
        bars += [[(0.0, 0.0), (0.1, 0.0)], [(0.9, 0.0), (1.0, 0.0)]]
        result += [(parts[0][0], np.array(bar)) for bar in bars]
    return result


def _between(i: FloatArray, j: FloatArray, half_width: float, points: FloatArray) -> FloatArray:
    """Points (s, n), n in half widths, in the plane of i and j."""
    s, n = points.T
    across = normal(unit(j - i)) * half_width
    return np.asarray(i + s[:, None] * (j - i) + n[:, None] * across)


Lines = list[list[tuple[float, float]]]


def _zigzag(parallel: bool) -> Lines:
    first = 0.1 if parallel else 0.0
    s = np.linspace(0.2, 0.8, 2 * COILS + 1)
    teeth = [(float(a), (1.0, -1.0)[k % 2]) for k, a in enumerate((s[1:] + s[:-1]) / 2)]
    return [[(first, 0), (0.2, 0), *teeth, (0.8, 0), (1 - first, 0)]]


def _dashpot(parallel: bool) -> Lines:
    first = 0.1 if parallel else 0.0
    return [
        [(first, 0), (0.35, 0)],
        [(0.65, 1), (0.35, 1), (0.35, -1), (0.65, -1)],
        [(0.55, 0.8), (0.55, -0.8)],
        [(0.55, 0), (1 - first, 0)],
    ]


def _cylinder(parallel: bool) -> Lines:
    first = 0.1 if parallel else 0.0
    return [
        [(first, 0), (0.15, 0)],
        [(0.15, -1), (0.6, -1), (0.6, 1), (0.15, 1), (0.15, -1)],
        [(0.45, 0.8), (0.45, -0.8)],
        [(0.45, 0), (1 - first, 0)],
    ]


def torsion_parts(elastic: bool, damper: bool, actuator: bool) -> list[tuple[str, FloatArray]]:
    """Style and lines (k, 3) of a torsion spring, damper and motor, about their pin.

    A point has its radius in pins and its angle φ_i + w (φ_j - φ_i) + ψ, given as w and ψ, rad. The
    spiral runs from body i, inside, to body j, and winds up and unwinds as the bodies turn; angles
    are not reduced to one turn.
    """
    x = np.linspace(0.0, 1.0, SPIRAL_POINTS)
    found = []
    if elastic:
        first, last = SPIRAL
        lines = [first + (last - first) * x, x, 2 * np.pi * SPIRAL_TURNS * x]
        found.append(("spring", np.stack(lines, axis=1)))
    if damper:
        start, sweep = ROUND_DAMPER
        for radius in ROUND_CUPS:
            lines = [0 * x + radius, 0 * x + 1, start + sweep * x]
            found.append(("damper", np.stack(lines, axis=1)))
    if actuator:
        lines = [0 * x + ROUND_MOTOR, 0 * x + 1, 2 * np.pi * x]
        found.append(("actuator", np.stack(lines, axis=1)))
    return found


def torsion_lines(
    center: FloatArray, pin: float, start: float, end: float, points: FloatArray
) -> FloatArray:
    """A line of `torsion_parts` about a centre, (k, 2), m, for angles φ_i and φ_j in rad."""
    radius, share, offset = points.T
    angles = start + share * (end - start) + offset
    around = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.asarray(center + pin * radius[:, None] * around)
