"""The surfaces of the ground that contacts meet: planes with hatching, and the plates of stops."""

from typing import NamedTuple

import numpy as np

from codegen.drawing.arrow_lines import hatching
from codegen.drawing.contact_points import heights, is_far, sides_of, touch_of_side
from codegen.drawing.picture import Picture
from codegen.drawing.polygons import FloatArray, placed
from codegen.drawing.shapes import ContactSide
from codegen.drawing.sizes_and_held_places import BLOCK, HATCH, SAME

HALF = 0.24  # layout: half length of a surface under a body that stays, in typical lengths
WIDTH_SHARE = 0.75  # layout: the same over the width of the body, at least
PLATE = 1.5  # layout: half length of a stop's plate over the half width of a block
REACH = 0.5  # layout: typical lengths above a surface within which a body makes it longer

Line = tuple[str, FloatArray]
"""Style and points (k, 2) of a stroke."""


class Surface(NamedTuple):
    """A straight surface of the ground.

    Attributes
    ----------
    element
        The contact, or the first of several with the same surface.
    middle, normal
        Its middle, m, and its direction towards the body, (2,) each.
    half
        Half its length, m.
    """

    element: str
    middle: FloatArray
    normal: FloatArray
    half: float

    @property
    def along(self) -> FloatArray:
        """The direction of the surface, the normal to its left, (2,)."""
        return np.array([self.normal[1], -self.normal[0]])


def surfaces(picture: Picture, fixed: bool, motion: FloatArray | None = None) -> list[Surface]:
    """The surfaces of a picture's contacts that stay where they are, or all others.

    Parameters
    ----------
    motion
        Poses of a motion, (instants, bodies, 3): a surface that keeps its direction is as long as
        its body travels along it while it is near.
    """
    found: list[Surface] = []
    for _, symbol, side in sides_of(picture):
        if side.is_grounded and side.is_fixed == fixed:
            one = surface_of_side(picture, symbol.element, side, motion)
            if one is not None:
                found = _joined(found, one, picture.size)
    return found


def surface_of_side(
    picture: Picture, element: str, side: ContactSide, motion: FloatArray | None = None
) -> Surface | None:
    """The surface of one side at the instant of a picture; None where none is ever near."""
    (point,), (at,), (normal,) = touch_of_side(picture, side)
    if not np.all(np.isfinite([point, at, normal])):
        return None
    gaps = heights(picture, side, motion)
    if is_far(gaps, picture.size):
        return None
    if side.is_stop:
        return Surface(element, at, normal, PLATE * BLOCK[1] * picture.size)
    along, middle = np.array([normal[1], -normal[0]]), at
    half = max(HALF * picture.size, WIDTH_SHARE * _width(picture, side.body, along))
    if side.is_level and motion is not None:
        poses = motion[:, side.body]
        near = poses[np.abs(gaps) <= REACH * picture.size]
        first, last = _travel(near if len(near) else picture.poses[[side.body]], along)
        shift = (first + last) / 2 - float(picture.poses[side.body, :2] @ along)
        middle, half = at + shift * along, half + (last - first) / 2
    return Surface(element, middle, normal, half)


def _width(picture: Picture, body: int, along: FloatArray) -> float:
    """The width of a body's outlines along a direction, m."""
    pose, outlines = picture.poses[body], picture.bodies[body].outlines
    places = [placed(np.array(outline, dtype=float), pose) @ along for outline in outlines]
    return float(np.ptp(np.concatenate(places))) if places else 0.0


def _travel(poses: FloatArray, along: FloatArray) -> tuple[float, float]:
    """The least and largest place of a body along a direction over its poses (k, 3), m."""
    s = poses[:, :2] @ along
    s = s[np.isfinite(s)]
    return float(s.min(initial=np.inf)), float(s.max(initial=-np.inf))


def _joined(found: list[Surface], one: Surface, size: float) -> list[Surface]:
    """The surfaces with another one, which lengthens one in the same plane that is near."""
    for k, other in enumerate(found):
        away = one.middle - other.middle
        same = float(other.normal @ one.normal) > 1 - 1e-9
        s, h = float(away @ other.along), float(away @ other.normal)
        if same and abs(h) < SAME * size and abs(s) < other.half + one.half + HALF * size:
            first, last = min(-other.half, s - one.half), max(other.half, s + one.half)
            middle = other.middle + (first + last) / 2 * other.along
            wide = Surface(other.element, middle, other.normal, (last - first) / 2)
            return [*found[:k], wide, *found[k + 1 :]]
    return [*found, one]


def surface_lines(surface: Surface, size: float) -> list[Line]:
    """The line of a surface and its hatching, in the frame in which its numbers are."""
    reach = surface.half * surface.along
    ends = np.array([surface.middle - reach, surface.middle + reach])
    strokes = hatching(ends[0], ends[1], -1.0, HATCH * size)
    return [("rail", ends), *(("hatch", stroke) for stroke in strokes)]
