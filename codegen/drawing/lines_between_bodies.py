"""The strokes between bodies: springs, dampers, actuators, belts, rods, and gaps of joints.

A figure has them at the poses of its picture; a page has what `links` and `windings` return, and
places it at every instant by the same two formulas.
"""

from typing import Any

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.contacts import surfaces
from codegen.drawing.guides import guide_of
from codegen.drawing.picture import PIN, SPRING, Picture, Symbol
from codegen.drawing.plane_geometry import FloatArray, Points, dot, unit
from codegen.drawing.styles import Stroke

GAP = 2e-3  # layout: a joint is not closed whose places are farther apart
COILS = 6  # layout: teeth of a zigzag
SPACING = 2.4  # layout: distance of parallel parts, in half widths
SPIRAL_TURNS = 2.25  # layout: turns of a torsion spring that is not wound up
SPIRAL = (1.8, 4.4)  # layout: inner and outer radius of a torsion spring, in pins
SPIRAL_POINTS = 160  # layout: of a torsion spring
ROUND_CUPS = (3.2, 4.6)  # layout: radii of the arcs of a torsion damper, in pins
ROUND_DAMPER = (0.6, 2.2)  # layout: where its arcs begin, from x' of body j, and their sweep, rad
ROUND_MOTOR = 3.1  # layout: radius of the circle of a motor, in pins
BELT_POINTS = 49  # layout: of the arc of a belt on a wheel


def links(shape: shapes.Shape) -> list[tuple[str, Points]]:
    """The lines of a rod, or of a spring, damper and actuator side by side: styles and points.

    A point is s + in: s from 0 at place i to 1 at j, n to the left, in half widths of a spring.

    A spring has `COILS` teeth from s = 0.2 to 0.8. A damper's rod ends in a piston at s = 0.55, and
    its pot is open at s = 0.65 and closed at 0.35. An actuator is a cylinder from s = 0.15 to 0.6
    and a rod from there. Several of them lie between two crossbars at s = 0.1 and 0.9.
    """
    if isinstance(shape, shapes.Rod):
        return [("rod", np.array([0j, 1]))]
    if not isinstance(shape, shapes.Spring):
        return []
    styles = link_styles(shape)
    first = 0.1 if len(styles) > 1 else 0.0
    s = np.linspace(0.2, 0.8, 2 * COILS + 1)
    teeth = (s[1:] + s[:-1]) / 2 + 1j * np.resize([1, -1], 2 * COILS)
    parts: dict[str, list[list[complex]]] = {
        "spring": [[first, 0.2, *teeth, 0.8, 1 - first]],
        "damper": [
            [first, 0.35], [0.65 + 1j, 0.35 + 1j, 0.35 - 1j, 0.65 - 1j],
            [0.55 + 0.8j, 0.55 - 0.8j], [0.55, 1 - first],
        ],
        "actuator": [
            [first, 0.15], [0.15 - 1j, 0.6 - 1j, 0.6 + 1j, 0.15 + 1j, 0.15 - 1j],
            [0.45 + 0.8j, 0.45 - 0.8j], [0.45, 1 - first],
        ],
    }  # fmt: skip
    outermost = (len(styles) - 1) / 2
    found: list[tuple[str, Points]] = [
        (style, np.array(line) + 1j * SPACING * (k - outermost))
        for k, style in enumerate(styles)
        for line in parts[style]
    ]
    if len(styles) > 1:
        reach = 1j * SPACING * outermost
        bars = [[x - reach, x + reach] for x in (0.1, 0.9)] + [[0j, 0.1], [0.9 + 0j, 1]]
        found += [(styles[0], np.array(bar)) for bar in bars]
    return found


def link_styles(shape: shapes.Rod | shapes.SpringLike) -> list[str]:
    """The styles of the parts that an element has."""
    if isinstance(shape, shapes.Rod):
        return ["rod"]
    wanted = {"spring": shape.elastic, "damper": shape.damper, "actuator": shape.actuator}
    return [style for style, is_wanted in wanted.items() if is_wanted]


def linked(points: Points, i: complex, j: complex, half_width: float) -> Points:
    """A line of `links` between two places, m."""
    across = 1j * unit(j - i) * half_width
    return np.asarray(i + points.real * (j - i) + points.imag * across)


def windings(shape: shapes.Shape, size: float) -> list[tuple[str, FloatArray]]:
    """The lines of a belt; or of a torsion spring, damper and motor about their pin, place j.

    The spiral runs from body i, inside, to body j, and winds up and unwinds as the bodies turn.
    With the style of a line stand its points, (k, 4). Each has its centre, 0 for place i and 1 for
    j, its radius in m, and its angle α + wβ + ψ, of which w and ψ stand behind.
    """

    def points(*columns: Any) -> FloatArray:
        return np.column_stack(np.broadcast_arrays(*columns))

    if isinstance(shape, shapes.Belt):
        s = np.linspace(0.0, 1.0, BELT_POINTS)
        offset = np.pi * (1 - 2 * s) if shape.crossed else 0.0
        on_i = points(0.0, abs(shape.radius_i), 1 - 2 * s, 2 * np.pi * s)
        on_j = points(1.0, abs(shape.radius_j), 2 * s - 1, offset)
        return [("belt", np.concatenate([on_i, on_j, on_i[:1]]))]
    if not isinstance(shape, shapes.SpiralSpring):
        return []
    x, pin = np.linspace(0.0, 1.0, SPIRAL_POINTS), PIN * size
    (inner, outer), (start, sweep) = SPIRAL, ROUND_DAMPER
    spiral = pin * (inner + (outer - inner) * x)
    parts = {
        "spring": [points(1.0, spiral, x, 2 * np.pi * SPIRAL_TURNS * x)],
        "damper": [points(1.0, pin * radius, 1.0, start + sweep * x) for radius in ROUND_CUPS],
        "actuator": [points(1.0, pin * ROUND_MOTOR, 1.0, 2 * np.pi * x)],
    }
    return [(style, line) for style in link_styles(shape) for line in parts[style]]


def wound(points: FloatArray, i: complex, j: complex, alpha: float, beta: float) -> Points:
    """A line of `windings` round two places, m, for two angles in rad."""
    center, radius, share, offset = points.T
    angles = alpha + share * beta + offset
    return np.asarray(np.where(center > 0, j, i) + radius * np.exp(1j * angles))


def winding_angles(
    picture: Picture, shape: shapes.Belt | shapes.SpiralSpring
) -> tuple[float, float]:
    """The angles α and β of `windings`, rad.

    Of a torsion spring α = φ_i and β = φ_j - φ_i, not reduced to one turn. Of a belt α is the
    heading δ of the line of centres, of the length d, and its tangents touch both wheels at the
    angles ±β from there, where cos β = (r_i - r_j)/d; those of a crossed belt touch wheel j on the
    other side, and cos β = (r_i + r_j)/d.
    """
    if isinstance(shape, shapes.SpiralSpring):
        start, end = picture.poses[[shape.i.body, shape.j.body], 2]
        return start, end - start
    away = picture.at(shape.j) - picture.at(shape.i)
    cosine = belt_difference(shape) / abs(away) if away else 0.0
    return float(np.angle(away)), float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def belt_difference(belt: shapes.Belt) -> float:
    """The difference r_i - r_j of its wheels, m; of a crossed belt the sum."""
    way = 1.0 if belt.crossed else -1.0
    return float(abs(belt.radius_i) + way * abs(belt.radius_j))


def lines_between_bodies(picture: Picture) -> list[Stroke]:
    """The strokes between bodies at the picture's poses, in the global frame.

    Springs, dampers, actuators, torsion springs, belts, massless rods, surfaces of contacts that
    move, and the gaps of joints that are not closed.
    """
    found: list[tuple[str, Points, str]] = []
    for symbol in picture.symbols:
        lines: list[tuple[str, Points]] = []
        match symbol.shape:
            case shapes.Spring(i, j) | shapes.Rod(i, j) as shape:
                ends = picture.at(i), picture.at(j), SPRING * picture.size
                lines = [(style, linked(points, *ends)) for style, points in links(shape)]
            case shapes.SpiralSpring(i, j) | shapes.Belt(i, j) as shape:
                around = picture.at(i), picture.at(j), *winding_angles(picture, shape)
                own = windings(shape, picture.size)
                lines = [(style, wound(points, *around)) for style, points in own]
        gap = gap_of(picture, symbol)
        if gap is not None:
            lines.append(("gap", gap))
        found += [(*line, symbol.element) for line in lines]
    for surface in surfaces(picture, fixed=False):
        found += [(*line, surface.element) for line in surface.lines(picture.size)]
    return [Stroke(style, 0, points, False, element) for style, points, element in found]


def gap_of(picture: Picture, symbol: Symbol) -> Points | None:
    """The line (2,) between two places that a joint should hold together and does not, if so."""
    shape = symbol.shape
    if symbol.role != "joint":
        return None
    if isinstance(shape, shapes.Pin | shapes.Fixing):
        i, j = picture.at(shape.i), picture.at(shape.j)
    elif isinstance(shape, shapes.Slide | shapes.Slot):
        guide = guide_of(picture, shape)
        j = picture.at(guide.block)
        start = picture.placed(guide.origin, guide.body)
        along = picture.turned(guide.along, guide.body)
        i = start + dot(along, j - start) * along
    else:
        return None
    return np.array([i, j]) if abs(j - i) > GAP * picture.size else None
