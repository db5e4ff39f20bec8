"""Where a body touches: the line of a contact's force, and the place of an outline on it.

A contact's force F acts on a body as Q = F g_q. With G = (∂g/∂x, ∂g/∂y) and τ = ∂g/∂φ that is a
force along the normal n = G/|G| whose line has the moment τ about the body's origin r: it goes
through the foot f = r + τ (G_y, -G_x)/|G|². A plane that does not turn touches the body about the
centre of curvature f - g_φφ n/|G|, which is fixed in the body for a corner and for a circle.
"""

from typing import NamedTuple

import numpy as np

from codegen.drawing.picture import Outline, Picture, Symbol
from codegen.drawing.polygons import FloatArray, contains, distance_to_edge, in_frame
from codegen.drawing.shapes import ContactSide

SLOPES = ("gap", "gx", "gy", "turn", "bend", "third")
GREATEST_GAP = 20.0  # layout: typical lengths from a body up to a surface that is drawn
ROUNDING = 1e-9  # accuracy: of a contact's arms; a centre of curvature that moves less is fixed


class ContactLine(NamedTuple):
    """The line of a contact's force on a body at k poses.

    Attributes
    ----------
    foot, normal
        The point of the line that is nearest to the body's origin, and its direction, towards the
        body, (k, 2) each, m; not a number where the gap does not change with the body's place.
    gap
        The distance that is left, (k,), m.
    arm
        From the centre of curvature up to the foot, (k,), m.
    is_round
        Whether that centre is fixed in the body, which touches with a corner or a circle.
    """

    foot: FloatArray
    normal: FloatArray
    gap: FloatArray
    arm: FloatArray
    is_round: bool

    @property
    def center(self) -> FloatArray:
        """The centre of curvature of the body where it touches, (k, 2), m."""
        return np.asarray(self.foot - self.arm[:, None] * self.normal)


def contact_line(slopes: FloatArray, poses: FloatArray) -> ContactLine:
    """The line of a contact's force.

    Parameters
    ----------
    slopes
        g, ∂g/∂x, ∂g/∂y, ∂g/∂φ, ∂²g/∂φ² and ∂³g/∂φ³, (k, 6).
    poses
        x, y and φ of the body, (k, 3).
    """
    gap, gx, gy, turn, bend, third = slopes.T
    size = np.hypot(gx, gy)
    size = np.where(size > 0, size, np.nan)
    normal = np.stack([gx, gy], axis=1) / size[:, None]
    lever = (turn / size)[:, None] * np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    arms = np.abs(turn) + np.abs(bend)
    # the centre moves in the body with g_φ + g_φφφ, the change of the radius of curvature
    is_round = bool(np.any(arms > 0) and np.all(np.abs(turn + third) <= ROUNDING * arms.max()))
    return ContactLine(poses[:, :2] + lever, normal, gap / size, bend / size, is_round)


def slopes_of(side: ContactSide) -> FloatArray:
    """The numbers of a side at the instant of its picture, (1, 6)."""
    return np.array([[getattr(side, name) for name in SLOPES]], dtype=float)


def reach_of_outlines(
    outlines: tuple[Outline, ...], line: ContactLine, poses: FloatArray
) -> FloatArray:
    """How far below the foot, against the normal, the body's outlines end on the line, (k,), m.

    A corner or a circle ends at the outline's distance from its centre. Where no outline meets the
    line, the body is taken for a point at the centre of curvature.
    """
    if line.is_round:
        known = np.flatnonzero(np.isfinite(line.center).all(axis=1))
        at = in_frame(line.center[known[:1]], poses[known[0]]) if len(known) else None
        return line.arm + (0.0 if at is None else _depth(outlines, at[0]))
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    away = line.foot - poses[:, :2]
    fx, fy = c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0]
    nx = c * line.normal[:, 0] + s * line.normal[:, 1]
    ny = c * line.normal[:, 1] - s * line.normal[:, 0]
    found = np.full(len(poses), -np.inf)
    for outline in outlines:
        x, y = np.array(outline, dtype=float).T
        across = nx[:, None] * (y - fy[:, None]) - ny[:, None] * (x - fx[:, None])
        down = -nx[:, None] * (x - fx[:, None]) - ny[:, None] * (y - fy[:, None])
        other, below = np.roll(across, -1, axis=1), np.roll(down, -1, axis=1)
        crosses = (across > 0) != (other > 0)
        share = across / np.where(crosses, across - other, 1.0)
        depth = np.where(crosses, down + share * (below - down), -np.inf)
        found = np.maximum(found, depth.max(axis=1, initial=-np.inf))
    return np.where(np.isfinite(found), found, line.arm)


def _depth(outlines: tuple[Outline, ...], at: FloatArray) -> float:
    """How far a place (2,) of a body is within an outline, m, at most; 0 on the edge or outside."""
    polygons = [np.array(outline, dtype=float) for outline in outlines]
    return max((distance_to_edge(one, at) for one in polygons if contains(one, at)), default=0.0)


class Touch(NamedTuple):
    """Where a body touches, the point of the surface that it meets, and the normal, (k, 2) each."""

    point: FloatArray
    surface: FloatArray
    normal: FloatArray


def touch(outlines: tuple[Outline, ...], slopes: FloatArray, poses: FloatArray) -> Touch:
    """Where a body with these outlines touches; the arguments are those of `contact_line`."""
    line = contact_line(slopes, poses)
    reach = reach_of_outlines(outlines, line, poses)[:, None]
    point = line.foot - reach * line.normal
    return Touch(point, point - line.gap[:, None] * line.normal, line.normal)


def touch_of_side(picture: Picture, side: ContactSide) -> Touch:
    """The same at the instant of a picture, whose bodies have their outlines; k = 1."""
    body = picture.bodies[side.body]
    return touch(body.outlines, slopes_of(side), picture.poses[side.body][None])


def heights(picture: Picture, side: ContactSide, motion: FloatArray | None = None) -> FloatArray:
    """The gap of a side over the poses of a motion (instants, bodies, 3), (k,), m.

    A level side has its slopes at all poses; of others, and without a motion, it is the gap at the
    instant of the picture, (1,). The body's turning is left out.
    """
    pose = picture.poses[side.body]
    line = contact_line(slopes_of(side), pose[None])
    if motion is None or not side.is_level:
        return line.gap
    return np.asarray(line.gap + (motion[:, side.body, :2] - pose[:2]) @ line.normal[0])


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
