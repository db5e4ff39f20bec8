"""Contacts: where a body touches, and the surfaces of the ground that it meets.

A contact's force F acts on a body as Q = F g_q. With G = ∂g/∂x + i ∂g/∂y and τ = ∂g/∂φ that is a
force along the normal n = G/|G| whose line has the moment τ about the body's origin r: it goes
through the foot f = r - iτn/|G|. A plane that does not turn touches the body about the centre of
curvature f - g_φφ n/|G|, which is fixed in the body for a corner and for a circle.
"""

from typing import NamedTuple

import numpy as np

from codegen.drawing.picture import MovingPicture, Outline, Picture, Symbol
from codegen.drawing.plane_geometry import (
    FloatArray,
    Points,
    contains,
    crossings,
    distance_to_edge,
    dot,
    hatching,
    in_frame,
    origin,
)  # fmt: skip
from codegen.drawing.proportions import BLOCK, HATCH, SAME
from codegen.drawing.shapes import ContactSide

GREATEST_GAP = 20.0  # layout: typical lengths from a body up to a surface that is drawn
ROUNDING = 1e-9  # accuracy: of a contact's arms; a centre of curvature that moves less is fixed
HALF = 0.24  # layout: half length of a surface under a body that stays, in typical lengths
WIDTH_SHARE = 0.75  # layout: the same over the width of the body, at least
PLATE = 1.5  # layout: half length of a stop's plate over the half width of a block
REACH = 0.5  # layout: typical lengths above a surface within which a body makes it longer


class ContactLine(NamedTuple):
    """The line of a contact's force on a body at k poses.

    Attributes
    ----------
    foot, normal
        The point of the line that is nearest to the body's origin, and its direction, towards the
        body, (k,) each, m; not a number where the gap does not change with the body's place.
    gap
        The distance that is left, (k,), m.
    arm
        From the centre of curvature up to the foot, (k,), m.
    is_round
        Whether that centre is fixed in the body, which touches with a corner or a circle.
    """

    foot: Points
    normal: Points
    gap: FloatArray
    arm: FloatArray
    is_round: bool

    @property
    def center(self) -> Points:
        """The centre of curvature of the body where it touches, (k,), m."""
        return self.foot - self.arm * self.normal


def contact_line(moving: MovingPicture, number: int) -> ContactLine:
    """The line of the force of a side, the symbol of this number, at all instants."""
    gap, gx, gy, turn, bend, third = (
        moving.number(number, name) for name in ("gap", "gx", "gy", "turn", "bend", "third")
    )
    size = np.hypot(gx, gy)
    size = np.where(size > 0, size, np.nan)
    normal = gx / size + 1j * (gy / size)
    arms = abs(turn) + abs(bend)
    # the centre moves in the body with g_φ + g_φφφ, the change of the radius of curvature
    is_round = bool(np.any(arms > 0) and np.all(abs(turn + third) <= ROUNDING * arms.max()))
    poses = moving.poses[:, side_of(moving.picture, number).body]
    foot = origin(poses) - 1j * (turn / size) * normal
    return ContactLine(foot, normal, gap / size, bend / size, is_round)


def side_of(picture: Picture, number: int) -> ContactSide:
    """The side of a contact that is the symbol of this number."""
    side = picture.symbols[number].shape
    assert isinstance(side, ContactSide)
    return side


def reach_of_outlines(
    outlines: tuple[Outline, ...], line: ContactLine, poses: FloatArray
) -> FloatArray:
    """How far below the foot, against the normal, the body's outlines end on the line, (k,), m.

    A corner or a circle ends at the outline's distance from its centre. Where no outline meets the
    line, the body is taken for a point at the centre of curvature.
    """
    polygons = [np.array(outline) for outline in outlines]
    if line.is_round:
        known = np.flatnonzero(np.isfinite(line.center))
        at = in_frame(line.center[known], poses[known])[:1]
        depths = [distance_to_edge(one, z) for z in at for one in polygons if contains(one, z)]
        return line.arm + max(depths, default=0.0)
    foot, normal = in_frame(line.foot, poses), line.normal * np.exp(-1j * poses[:, 2])
    found = np.full(len(poses), np.nan)
    for polygon in polygons:
        seen = (polygon - foot[:, None]) * normal.conj()[:, None]  # from the foot along the normal
        found = np.fmax(found, np.fmax.reduce(-crossings(seen), axis=1))
    return np.where(np.isfinite(found), found, line.arm)


class Touch(NamedTuple):
    """Where a body touches, the point of the surface that it meets, and the normal, (k,) each."""

    point: Points
    surface: Points
    normal: Points


def touch(moving: MovingPicture, number: int) -> Touch:
    """Where the body of a side touches, the symbol of this number, at all instants.

    The bodies have their outlines.
    """
    body, line = side_of(moving.picture, number).body, contact_line(moving, number)
    outlines = moving.picture.bodies[body].outlines
    point = line.foot - reach_of_outlines(outlines, line, moving.poses[:, body]) * line.normal
    return Touch(point, point - line.gap * line.normal, line.normal)


def heights(picture: Picture, number: int, motion: FloatArray | None = None) -> FloatArray:
    """The gap of a side over the poses of a motion (instants, bodies, 3), (k,), m.

    A level side has its slopes at all poses; of others, and without a motion, it is the gap at the
    instant of the picture, (1,). The body's turning is left out.
    """
    side, line = side_of(picture, number), contact_line(picture.still, number)
    if motion is None or not side.is_level:
        return line.gap
    away = origin(motion[:, side.body]) - origin(picture.poses[side.body])
    return np.asarray(line.gap + dot(line.normal, away))


def is_far(gaps: FloatArray, size: float) -> bool:
    """Whether a body is never near a surface, by its gaps, m, for a typical length, m."""
    known = np.abs(gaps[np.isfinite(gaps)])
    return float(known.min(initial=np.inf)) > GREATEST_GAP * size


def sides_of(picture: Picture) -> list[tuple[int, Symbol, ContactSide]]:
    """The numbers, symbols and shapes of all sides of contacts."""
    return [
        (k, symbol, symbol.shape)
        for k, symbol in enumerate(picture.symbols)
        if isinstance(symbol.shape, ContactSide)
    ]


class Surface(NamedTuple):
    """A straight surface of the ground.

    Attributes
    ----------
    element
        The contact, or the first of several with the same surface.
    middle, normal
        Its middle, m, and its direction towards the body.
    half
        Half its length, m.
    """

    element: str
    middle: complex
    normal: complex
    half: float

    @property
    def along(self) -> complex:
        """The direction of the surface, the normal to its left."""
        return -1j * self.normal

    def lines(self, size: float) -> list[tuple[str, Points]]:
        """Styles and points of its line and hatching, for a picture of this typical length, m."""
        ends = self.middle + self.half * self.along * np.array([-1, 1])
        strokes = hatching(ends[0], ends[1], -1.0, HATCH * size)
        return [("rail", ends), *(("hatch", stroke) for stroke in strokes)]


def surfaces(picture: Picture, fixed: bool, motion: FloatArray | None = None) -> list[Surface]:
    """The surfaces of a picture's contacts that stay where they are, or all others.

    Parameters
    ----------
    motion
        Poses of a motion, (instants, bodies, 3): a surface that keeps its direction is as long as
        its body travels along it while it is near.
    """
    found: list[Surface] = []
    for number, _, side in sides_of(picture):
        if side.is_grounded and side.is_fixed == fixed:
            one = surface_of(picture, number, motion)
            if one is not None:
                found = _joined(found, one, picture.size)
    return found


def surface_of(picture: Picture, number: int, motion: FloatArray | None = None) -> Surface | None:
    """The surface of the side of this number in a picture; None where none is ever near."""
    symbol, size = picture.symbols[number], picture.size
    (point,), (at,), (normal,) = touch(picture.still, number)
    gaps, side = heights(picture, number, motion), side_of(picture, number)
    if not np.isfinite([point, at, normal]).all() or is_far(gaps, size):
        return None
    if side.is_stop:
        return Surface(symbol.element, at, normal, PLATE * BLOCK[1] * size)
    along = -1j * normal
    half = max(HALF * size, WIDTH_SHARE * _width(picture, side.body, along))
    if side.is_level and motion is not None:
        near = motion[abs(gaps) <= REACH * size, side.body]
        travel = dot(along, origin(near if len(near) else picture.poses[[side.body]]))
        first, last = float(np.nanmin(travel)), float(np.nanmax(travel))
        at += ((first + last) / 2 - dot(along, origin(picture.poses[side.body]))) * along
        half += (last - first) / 2
    return Surface(symbol.element, at, normal, half)


def _width(picture: Picture, body: int, along: complex) -> float:
    """The width of a body's outlines along a direction, m."""
    polygons = picture.bodies[body].polygons
    if not polygons:
        return 0.0
    return float(np.ptp(dot(along, picture.placed(np.concatenate(polygons), body))))


def _joined(found: list[Surface], one: Surface, size: float) -> list[Surface]:
    """The surfaces with another one, which lengthens one in the same plane that is near."""
    for k, other in enumerate(found):
        away = (one.middle - other.middle) * other.along.conjugate()
        is_same = dot(other.normal, one.normal) > 1 - 1e-9 and abs(away.imag) < SAME * size
        if is_same and abs(away.real) < other.half + one.half + HALF * size:
            first = min(-other.half, away.real - one.half)
            last = max(other.half, away.real + one.half)
            middle = other.middle + (first + last) / 2 * other.along
            wide = other._replace(middle=middle, half=(last - first) / 2)
            return [*found[:k], wide, *found[k + 1 :]]
    return [*found, one]


class MovingSurface(NamedTuple):
    """The surface of a contact about the origin, and the poses x, y and φ of its frame, (k, 3)."""

    surface: Surface
    poses: FloatArray


def moving_surfaces(moving: MovingPicture) -> list[MovingSurface]:
    """The surfaces of contacts that do not stay where they are; those that do are rigid strokes."""
    found = []
    for number, symbol, side in sides_of(moving.picture):
        met = touch(moving, number)
        known = np.flatnonzero(np.isfinite(met.surface))
        if not side.is_grounded or side.is_fixed or not len(known):
            continue
        nearest = known[np.argmin(abs(moving.number(number, "gap")[known]))]
        one = surface_of(moving.at(int(nearest)), number, moving.poses)
        if one is None:
            continue
        angle = np.angle(met.normal) - np.pi / 2
        angle[known] = np.unwrap(angle[known])
        middle = met.surface
        if side.is_level and not side.is_stop:
            middle = middle + dot(one.along, one.middle - middle) * one.along
        still = Surface(symbol.element, 0j, 1j, one.half)
        found.append(MovingSurface(still, np.column_stack([middle.real, middle.imag, angle])))
    return found
