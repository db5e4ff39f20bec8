"""Outlines of gears and racks, whose teeth mesh, and the lines of belts."""

from collections.abc import Sequence

import numpy as np

from codegen.drawing.polygons import FloatArray, normal, unit

LEAST_TEETH, MOST_TEETH = 10, 18  # layout: of the smallest gear of a picture
ADDENDUM, DEDENDUM = 0.9, 1.1  # layout: tooth above and below the pitch circle, in modules
BACK = 2.6  # layout: depth of a rack below its pitch line, in modules
BELT_POINTS = 49  # layout: of the arc of a belt on a wheel
CREST, ROOT = 0.22, 0.34  # layout: half widths of a tooth at its crest and root, in pitches


def common_module(radii: Sequence[float]) -> float:
    """The module m, in m, with which the gears' numbers of teeth 2r/m come nearest to integers."""
    smallest = min(radii)
    candidates = [2 * smallest / teeth for teeth in range(LEAST_TEETH, MOST_TEETH + 1)]

    def error(module: float) -> float:
        teeth = 2 * np.array(radii) / module
        return float(np.max(np.abs(teeth - np.round(teeth))))

    return min(candidates, key=lambda module: (round(error(module), 3), module))


def teeth_of(radius: float, module: float) -> int:
    """The number of teeth of a gear."""
    return max(4, round(2 * radius / module))


def gear_profile(
    radius: float, module: float, phase: float = 0.0, internal: bool = False
) -> FloatArray:
    """The toothed line (k, 2) of a gear about the origin, closed and counterclockwise, m.

    The phase, rad, is the angle of the middle of a tooth. Teeth are straight: a drawing, not an
    involute. The teeth of an internal gear point inwards.
    """
    teeth = teeth_of(radius, module)
    way = -1.0 if internal else 1.0
    crest, root = radius + way * ADDENDUM * module, radius - way * DEDENDUM * module
    offsets = np.array([-ROOT, -CREST, CREST, ROOT])
    levels = np.array([root, crest, crest, root])
    angles = phase + 2 * np.pi / teeth * (np.arange(teeth)[:, None] + offsets)
    r = np.broadcast_to(levels, angles.shape)
    return np.stack([r * np.cos(angles), r * np.sin(angles)], axis=-1).reshape(-1, 2)


def meshing_phase(
    heading: float, radius: float, phase: float, other_radius: float, module: float, kind: str
) -> float:
    """The phase of a second gear, in global axes, whose teeth meet the gaps of the first.

    Parameters
    ----------
    heading
        The angle from the first centre to the second, rad; for an internal pair, from the ring's
        centre to the pinion's.
    radius, phase
        Those of the first gear, the phase in global axes.
    other_radius
        That of the second.
    kind
        "external", "internal" (either of the two is the ring).
    """
    teeth, other = teeth_of(radius, module), teeth_of(other_radius, module)
    ahead = (heading - phase) * teeth / (2 * np.pi)  # of the contact, in pitches, from a tooth
    if kind == "external":
        meeting, there = heading + np.pi, 0.5 - ahead
    else:
        meeting, there = heading, 0.5 + ahead
    return float(meeting - there * 2 * np.pi / other)


def rack_profile(
    origin: FloatArray,
    along: FloatArray,
    reach: tuple[float, float],
    module: float,
    side: float,
    phase: float = 0.0,
) -> FloatArray:
    """The outline (k, 2) of a rack, whose teeth point to the left (`side` 1) or right (-1), closed.

    `reach` is the part of the line through `origin` that it covers, m, and a tooth is at `phase`.
    """
    pitch = np.pi * module
    first, last = (reach[0] - phase) / pitch + ROOT, (reach[1] - phase) / pitch - ROOT
    s = phase + pitch * (
        np.arange(np.ceil(first), np.floor(last) + 1)[:, None] + [-ROOT, -CREST, CREST, ROOT]
    )
    h = np.broadcast_to(module * np.array([-DEDENDUM, ADDENDUM, ADDENDUM, -DEDENDUM]), s.shape)
    across = side * normal(along)
    points = origin + s.reshape(-1, 1) * along + h.reshape(-1, 1) * across
    levels = np.array([-BACK, -DEDENDUM]) * module
    (a, c), (b, d) = ([origin + e * along + h * across for h in levels] for e in reach)
    return np.concatenate([[a, c], points, [d, b]])


def belt_line(
    i: FloatArray, radius_i: float, j: FloatArray, radius_j: float, crossed: bool = False
) -> FloatArray:
    """The closed line (k, 2) of a belt round two wheels: two tangents and two arcs.

    With d from centre i to centre j, the tangents touch both wheels at the angles ±β from d, where
    cos β = (r_i − r_j)/|d|; those of a crossed belt touch wheel j on the other side, and
    cos β = (r_i + r_j)/|d|.
    """
    d = j - i
    distance = float(np.hypot(*d))
    heading = float(np.arctan2(d[1], d[0]))
    cosine = (radius_i + (radius_j if crossed else -radius_j)) / distance if distance > 0 else 0.0
    beta = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
    wheel, share, offset = belt_parts(crossed).T
    angles = heading + share * beta + offset
    radii = np.where(wheel > 0, radius_j, radius_i)
    around = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.asarray(np.where(wheel[:, None] > 0, j, i) + radii[:, None] * around)


def belt_parts(crossed: bool) -> FloatArray:
    """The points of a belt, (k, 3): the wheel, 0 or 1, and a and ψ of its angle δ + a β + ψ, rad.

    δ is the angle of the line of centres, and β as in `belt_line`.
    """
    s = np.linspace(0.0, 1.0, BELT_POINTS)
    on_i = np.stack([0 * s, 1 - 2 * s, 2 * np.pi * s], axis=1)
    on_j = np.stack([0 * s + 1, 2 * s - 1, 0 * s], axis=1)
    if crossed:
        on_j[:, 2] = np.pi * (1 - 2 * s)
    return np.concatenate([on_i, on_j, on_i[:1]])


def spoke(center: FloatArray, radius: float) -> FloatArray:
    """The line (2, 2) on a disc by which its turning is seen: towards x' of its body."""
    return np.array([center + 0.35 * radius * unit(np.array([1.0, 0.0])),
                     center + 0.92 * radius * unit(np.array([1.0, 0.0]))])  # fmt: skip
