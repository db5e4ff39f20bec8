"""Contacts: where a body touches, and the surfaces of the ground that it meets.

A contact's force F acts on a body as Q = F g_q. With G = ∂g/∂x + i ∂g/∂y and τ = ∂g/∂φ that is a
force along the normal n = G/|G| whose line has the moment τ about the body's origin r: it goes
through the foot f = r - iτn/|G|. A plane that does not turn touches the body about the centre of
curvature f - g_φφ n/|G|, which is fixed in the body for a corner and for a circle.

All of it holds at one instant as for a picture in motion, then with a value for each instant.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from codegen.drawing.picture import BLOCK, HATCH, SAME, Picture
from codegen.drawing.plane_geometry import (
    FloatArray,
    Points,
    contains,
    crossings,
    distance_to_edge,
    dot,
    hatching,
    origin,
)  # fmt: skip
from codegen.drawing.shapes import ContactSide, Exertion

GREATEST_GAP = 20.0  # layout: typical lengths from a body up to a surface that is drawn
ROUNDING = 1e-9  # accuracy: of a contact's arms; a centre of curvature that moves by less is fixed
HALF = 0.24  # layout: half length of a surface under a body that stays, in typical lengths
WIDTH_SHARE = 0.75  # layout: the same over the width of the body, at least
PLATE = 1.5  # layout: half length of a stop's plate over the half width of a block
REACH = 0.5  # layout: typical lengths above a surface within which a body makes it longer


class ContactLine(NamedTuple):
    """The line of a contact's force on a body; not a number where the gap has no slopes."""

    foot: Any  # its point that is nearest to the body's origin, m
    normal: Any  # its direction, towards the body
    gap: Any  # the distance that is left, m
    arm: Any  # from the centre of curvature up to the foot, m
    is_round: bool  # whether that centre is fixed in the body: a corner or a circle touches

    @property
    def center(self) -> Any:
        """The centre of curvature of the body where it touches, m."""
        return self.foot - self.arm * self.normal


def contact_line(picture: Picture, side: ContactSide) -> ContactLine:
    """The line of the force of a side."""
    foot, normal, size = line_of_force(picture, side)
    arms = np.asarray(abs(side.turn) + abs(side.bend))
    # the centre moves in the body with g_φ + g_φφφ, the change of the radius of curvature
    change = abs(side.turn + side.third)
    is_round = bool(np.any(arms > 0) and np.all(change <= ROUNDING * arms.max()))
    return ContactLine(foot, normal, side.gap / size, side.bend / size, is_round)


def line_of_force(picture: Picture, force: Exertion) -> tuple[Any, Any, Any]:
    """Foot, m, and direction of the line of a force, and its slope along that."""
    size = np.hypot(force.gx, force.gy)
    size = np.where(size > 0, size, np.nan)[()]
    normal = force.gx / size + 1j * (force.gy / size)
    foot = origin(picture.poses[..., force.body, :]) - 1j * (force.turn / size) * normal
    return foot, normal, size


def nearest_side(sides: Sequence[ContactSide]) -> Any:
    """The number of the side with the smallest gap."""
    gaps = np.array(np.broadcast_arrays(*(side.gap for side in sides)))
    return np.argmin(np.where(np.isnan(gaps), np.inf, gaps), axis=0)


def _reach_of_outlines(picture: Picture, side: ContactSide, line: ContactLine) -> Any:
    """How far below the foot, against the normal, the body's outlines end on the line, m."""
    polygons = picture.bodies[side.body].outlines
    if line.is_round:
        centers = np.atleast_1d(picture.in_body(line.center, side.body))
        at = centers[np.isfinite(centers)][:1]
        depths = [distance_to_edge(one, z) for z in at for one in polygons if contains(one, z)]
        return line.arm + max(depths, default=0.0)
    foot = np.asarray(picture.in_body(line.foot, side.body))[..., None]
    normal = np.asarray(line.normal * np.exp(-1j * picture.poses[..., side.body, 2]))[..., None]
    found = np.full(foot.shape[:-1], np.nan)
    for polygon in polygons:
        seen = (polygon - foot) * normal.conj()  # from the foot along the normal
        found = np.fmax(found, np.fmax.reduce(-crossings(seen), axis=-1))
    return np.where(np.isfinite(found), found, line.arm)[()]


class Touch(NamedTuple):
    """Where a body touches, the point of the surface that it meets, and the normal."""

    point: Any
    surface: Any
    normal: Any


def touch(picture: Picture, side: ContactSide) -> Touch:
    """Where the body of a side touches; the bodies have their outlines."""
    line = contact_line(picture, side)
    point = line.foot - _reach_of_outlines(picture, side, line) * line.normal
    return Touch(point, point - line.gap * line.normal, line.normal)


def heights(picture: Picture, side: ContactSide) -> FloatArray:
    """The gap of a side over the motion of a picture, (instants,), m.

    A level side has its slopes at all poses; of others, and without a motion, it is the gap at the
    instant of the picture, (1,). The body's turning is left out.
    """
    line, away = contact_line(picture, side), 0.0
    if picture.motion is not None and side.is_level:
        away = origin(picture.motion[:, side.body]) - origin(picture.poses[side.body])
    return np.atleast_1d(line.gap + dot(line.normal, away))


def is_far(gaps: FloatArray, size: float) -> bool:
    """Whether a body is never near a surface, by its gaps, m, for a typical length, m."""
    known = np.abs(gaps[np.isfinite(gaps)])
    return float(known.min(initial=np.inf)) > GREATEST_GAP * size


class Surface(NamedTuple):
    """A straight surface of the ground, of contacts."""

    element: str  # the first of those that share it
    middle: Any  # m
    normal: Any  # towards the body
    half: float  # half its length, m

    @property
    def along(self) -> Any:
        """The direction of the surface, the normal to its left."""
        return -1j * self.normal

    def lines(self, size: float) -> list[tuple[str, Points]]:
        """Styles and points of its line and hatching, for a picture of this typical length, m."""
        ends = self.middle + self.half * self.along * np.array([-1, 1])
        strokes = hatching(ends[0], ends[1], -1.0, HATCH * size)
        return [("rail", ends), *(("hatch", stroke) for stroke in strokes)]


def surfaces(picture: Picture, fixed: bool) -> list[Surface]:
    """The surfaces of a picture's contacts that stay where they are, or all others.

    In a motion a surface that keeps its direction is as long as its body travels along it while it
    is near.
    """
    found: list[Surface] = []
    for symbol, side in picture.having(ContactSide):
        if side.is_grounded and side.is_fixed == fixed:
            one = _surface_of(picture, symbol.element, side)
            if one is not None:
                _join(found, one, picture.size)
    return found


def _surface_of(picture: Picture, element: str, side: ContactSide) -> Surface | None:
    """The surface of a side at one instant; None where none is ever near."""
    point, at, normal = touch(picture, side)
    gaps, size = heights(picture, side), picture.size
    if not np.isfinite([point, at, normal]).all() or is_far(gaps, size):
        return None
    if side.is_stop:
        return Surface(element, at, normal, PLATE * BLOCK[1] * size)
    along = -1j * normal
    polygons = picture.bodies[side.body].outlines or (np.zeros(1),)
    corners = picture.placed(np.concatenate(polygons), side.body)
    half = max(HALF * size, WIDTH_SHARE * float(np.ptp(dot(along, corners))))
    if side.is_level and picture.motion is not None:
        here = picture.poses[side.body]
        near = picture.motion[abs(gaps) <= REACH * size, side.body]
        travel = dot(along, origin(near if len(near) else here[None]))
        first, last = float(np.nanmin(travel)), float(np.nanmax(travel))
        at += ((first + last) / 2 - dot(along, origin(here))) * along
        half += (last - first) / 2
    return Surface(element, at, normal, half)


def _join(found: list[Surface], one: Surface, size: float) -> None:
    """Add a surface, or lengthen one by it that is near in the same plane."""
    for k, other in enumerate(found):
        away = (one.middle - other.middle) * other.along.conjugate()
        is_same = dot(other.normal, one.normal) > 1 - 1e-9 and abs(away.imag) < SAME * size
        if is_same and abs(away.real) < other.half + one.half + HALF * size:
            first = min(-other.half, away.real - one.half)
            last = max(other.half, away.real + one.half)
            middle = other.middle + (first + last) / 2 * other.along
            found[k] = other._replace(middle=middle, half=(last - first) / 2)
            return
    found.append(one)


def moving_surfaces(picture: Picture) -> list[Surface]:
    """The surfaces of contacts in motion that do not stay; those that do are rigid strokes.

    Their middles and directions are those of all instants, (k,).
    """
    found = []
    for number, symbol in enumerate(picture.symbols):
        side = symbol.shape
        if not isinstance(side, ContactSide) or not side.is_grounded or side.is_fixed:
            continue
        _, middle, normal, gap = np.broadcast_arrays(*touch(picture, side), side.gap)
        known = np.flatnonzero(np.isfinite(middle))
        if not len(known):
            continue
        still = picture.instant(int(known[np.argmin(abs(gap[known]))]))
        one = _surface_of(still, symbol.element, still.symbols[number].shape)  # type: ignore[arg-type]
        if one is not None:
            if side.is_level and not side.is_stop:
                middle = middle + dot(one.along, one.middle - middle) * one.along
            found.append(one._replace(middle=middle, normal=normal))
    return found
