"""Contacts in motion as the page has them: where they touch, their normals, moving surfaces."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.drawing.contact_points import SLOPES, Touch, sides_of, touch
from codegen.drawing.contact_surfaces import Surface, surface_lines, surface_of_side
from codegen.drawing.shapes import ContactSide
from codegen.drawing.strokes import Stroke
from runtime.show.pictures import Pictures

FloatArray = npt.NDArray[np.float64]


class MovingSurface(NamedTuple):
    """Strokes about the origin, and the poses x, y and φ of their frame, (k, 3)."""

    strokes: tuple[Stroke, ...]
    poses: FloatArray


def contact_numbers(pictures: Pictures, number: int, side: ContactSide) -> dict[str, FloatArray]:
    """The place x, y at which a side touches, the slopes of its gap, and the gap, (k,) each."""
    slopes, found = _touch(pictures, number, side)
    x, y = found.point.T
    return {"x": x, "y": y, "gx": slopes[:, 1], "gy": slopes[:, 2], "gap": slopes[:, 0]}


def moving_surfaces(pictures: Pictures) -> list[MovingSurface]:
    """The surfaces of contacts that do not stay where they are; those that do are rigid strokes."""
    picture, found = pictures.picture, []
    for number, symbol, side in sides_of(picture):
        if not side.is_grounded or side.is_fixed:
            continue
        slopes, met = _touch(pictures, number, side)
        known = np.flatnonzero(np.isfinite(met.surface).all(axis=1))
        if not len(known):
            continue
        near = pictures.at(int(known[np.argmin(np.abs(slopes[known, 0]))]))
        nearest = next(other for k, _, other in sides_of(near) if k == number)
        one = surface_of_side(near, symbol.element, nearest, pictures.poses)
        if one is None:
            continue
        angle = np.arctan2(met.normal[:, 1], met.normal[:, 0]) - np.pi / 2
        angle[known] = np.unwrap(angle[known])
        middle = met.surface
        if side.is_level and not side.is_stop:
            middle = middle + np.outer((one.middle - middle) @ one.along, one.along)
        still = Surface(symbol.element, np.zeros(2), np.array([0.0, 1.0]), one.half)
        strokes = tuple(
            Stroke(style, 0, points, False, symbol.element)
            for style, points in surface_lines(still, picture.size)
        )
        found.append(MovingSurface(strokes, np.column_stack([middle, angle])))
    return found


def _touch(pictures: Pictures, number: int, side: ContactSide) -> tuple[FloatArray, Touch]:
    """The slopes (k, 6) of a side at all instants, and where it touches."""
    still = np.ones(len(pictures.t))
    columns = [
        pictures.moving.get((number, name), still * float(getattr(side, name))) for name in SLOPES
    ]
    slopes = np.stack(columns, axis=1)
    body = pictures.picture.bodies[side.body]
    return slopes, touch(body.outlines, slopes, pictures.poses[:, side.body])
