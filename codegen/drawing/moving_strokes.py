"""The strokes between bodies, drawn anew at each pose: springs, belts, rods, gaps of joints."""

from collections.abc import Iterator

import numpy as np

from codegen.drawing import shapes
from codegen.drawing.contact_surfaces import surface_lines, surfaces
from codegen.drawing.guides_and_racks import guide_of
from codegen.drawing.picture import Picture, Symbol
from codegen.drawing.polygons import FloatArray, placed
from codegen.drawing.sizes_and_held_places import PIN
from codegen.drawing.spring_lines import spring_lines, torsion_lines, torsion_parts
from codegen.drawing.strokes import Stroke
from codegen.drawing.wheel_lines import belt_line

SPRING = 0.021  # layout: half width of a spring, in typical lengths
GAP = 2e-3  # layout: a joint is not closed whose places are farther apart


def moving_strokes(picture: Picture, motion: FloatArray | None = None) -> tuple[Stroke, ...]:
    """The strokes between bodies at the picture's poses, in the global frame.

    Springs, dampers, actuators, torsion springs, belts, massless rods, surfaces of contacts that
    move, and the gaps of joints that are not closed.

    Parameters
    ----------
    motion
        Poses of a motion, shape (instants, bodies, 3), for the lengths of surfaces.
    """
    found = [
        Stroke(style, 0, points, closed, symbol.element)
        for symbol in picture.symbols
        for style, points, closed in _moving(picture, symbol)
    ]
    for surface in surfaces(picture, fixed=False, motion=motion):
        lines = surface_lines(surface, picture.size)
        found += [Stroke(style, 0, points, False, surface.element) for style, points in lines]
    return tuple(found)


def _moving(picture: Picture, symbol: Symbol) -> Iterator[tuple[str, FloatArray, bool]]:
    shape, size = symbol.shape, picture.size
    match shape:
        case shapes.Spring():
            i, j = np.array(picture.position(shape.i)), np.array(picture.position(shape.j))
            lines = spring_lines(i, j, SPRING * size, shape.elastic, shape.damper, shape.actuator)
            yield from ((style, line, False) for style, line in lines)
        case shapes.SpiralSpring():
            yield from _torsion(picture, shape)
        case shapes.Rod():
            yield "rod", np.array([picture.position(shape.i), picture.position(shape.j)]), False
        case shapes.Belt():
            line = belt_line(
                np.array(picture.position(shape.i)), abs(float(shape.radius_i)),
                np.array(picture.position(shape.j)), abs(float(shape.radius_j)), shape.crossed,
            )  # fmt: skip
            yield "belt", line, False
        case _:
            gap = gap_of(picture, symbol)
            if gap is not None:
                yield "gap", gap, False


def _torsion(
    picture: Picture, shape: shapes.SpiralSpring
) -> Iterator[tuple[str, FloatArray, bool]]:
    center = np.array(picture.position(shape.j))
    start, end = picture.poses[shape.i.body, 2], picture.poses[shape.j.body, 2]
    for style, points in torsion_parts(shape.elastic, shape.damper, shape.actuator):
        yield style, torsion_lines(center, PIN * picture.size, start, end, points), False


def gap_of(picture: Picture, symbol: Symbol) -> FloatArray | None:
    """The line (2, 2) between two places that a joint should hold together and does not, if so."""
    shape, size = symbol.shape, picture.size
    if symbol.role != "joint":
        return None
    if isinstance(shape, shapes.Pin | shapes.Fixing):
        i, j = np.array(picture.position(shape.i)), np.array(picture.position(shape.j))
    elif isinstance(shape, shapes.Slide | shapes.Slot):
        guide = guide_of(picture, shape)
        j = np.array(picture.position(guide.block))
        pose = picture.poses[guide.body]
        line = placed(np.array([guide.origin, guide.origin + guide.along]), pose)
        along = line[1] - line[0]
        i = line[0] + float((j - line[0]) @ along) * along
    else:
        return None
    return np.array([i, j]) if np.hypot(*(j - i)) > GAP * size else None
