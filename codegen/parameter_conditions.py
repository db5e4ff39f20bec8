"""Conditions of a model on its parameters, which the build and each run check in the same way."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

SAMPLES = 720  # safety: places on a profile at which its shape is looked at, every half degree
ALPHAS = tuple(2 * math.pi * k / SAMPLES for k in range(SAMPLES + 1))
TOLERANCE = 1e-9  # accuracy: of curvatures, in parts of a profile's size or of 1
_JUMP = 1e-4  # accuracy: of a corner, rad; and of 100 times a gap, in parts of a profile's size
_HALVINGS = 12  # measured: halvings of an interval of α in which there may be a jump
_MOST = 3000  # safety: samples of a profile, beyond which no interval is halved
# accuracy: of a roller's radius; a cut that is less deep comes from the sampling
_CUT = 1e-6
_ONCE = 1.5  # safety: turns of the tangent that a curve which goes round once does not reach
Array = npt.NDArray[np.float64]
Vectors = npt.NDArray[np.complex128]


class RollerCut(NamedTuple):
    """A roller that cuts into the profile that it touches."""

    which: int  # of the two profiles, that which is cut
    alphas: Array  # where the contact is when it cuts
    sentence: str


class ConditionRow(NamedTuple):
    """A condition in numbers: its sentence has `shown` of them, the first of which is bounded."""

    element: str  # ``spring 's'``
    sentence: str  # of `str.format`, with the numbers as its arguments
    low: float | None  # least value; None: none
    open: bool  # whether the least value itself is too small
    high: float | None  # largest value; None: none
    shown: int
    bulges: tuple[tuple[float, ...], ...] = ()  # of an outline, whose vertices are the numbers


class ProfileRow(NamedTuple):
    """A closed curve whose shape depends on parameters."""

    element: str  # ``curve of 'A' on body 'cam'``
    convex: bool  # whether its follower needs it to be
    touches: int = 0  # 1: it touches the curve of the next row from outside, -1: from inside
    contact: str = ""  # the joint, where a run shows which part of the profile it uses


def violated_conditions(
    rows: Iterable[ConditionRow], numbers: Sequence[float] | npt.NDArray[np.float64]
) -> Iterator[str]:
    """A sentence for each condition that its numbers, those of all rows in order, do not meet."""
    first = 0
    for row in rows:
        values = [float(number) for number in numbers[first : first + row.shown]]
        first += row.shown
        if row.bulges:
            from codegen.drawing.plane_geometry import area_problem  # few scenes need it

            if problem := area_problem(row.bulges, values):
                yield f"{row.element}: {problem}"
            continue
        value = values[0]
        enough = row.low is None or value > row.low or (value == row.low and not row.open)
        if not (enough and (row.high is None or value <= row.high)):
            yield f"{row.element}: {row.sentence.format(*values)}"


def profile_problems(rows: Sequence[ProfileRow], curves: Sequence[Array]) -> Iterator[str]:
    """A sentence for each sampled curve that is not as it has to be, or is cut by its roller."""
    found = [
        f"{row.element}: {problem}"
        for row, curve in zip(rows, curves, strict=True)
        for problem in shape_problems(curve, row.convex)
    ]
    yield from found
    for k, row in enumerate(() if found else rows):
        judged = row.touches and not row.contact
        if judged and (cut := roller_cut(curves[k], curves[k + 1], row.touches < 0)):
            yield f"{rows[k + cut.which].element}: {cut.sentence}"


def sample_profile(at: Callable[[Array], Array]) -> Array:
    """Samples of a closed curve, (k, 7): α from 0 to 2π, and what `at` returns, (k, 6), for α.

    These are x, y and their first and second derivatives, those at 0 again at 2π. Samples are
    closer where the tangent turns fast, or pieces meet.
    """
    alphas = np.array(ALPHAS)
    rows = np.column_stack([alphas, at(alphas % ALPHAS[-1])])
    for _ in range(_HALVINGS):
        wide = np.flatnonzero(_jumps(rows).max(axis=0) > _JUMP)
        if not len(wide) or len(rows) > _MOST:
            break
        middles = 0.5 * (rows[wide, 0] + rows[wide + 1, 0])
        rows = np.insert(rows, wide + 1, np.column_stack([middles, at(middles)]), axis=0)
    return rows


def _vectors(rows: Array) -> tuple[float, Vectors]:
    """The size of a curve, m, and places, derivatives, second ones in parts of it, (3, k)."""
    size = float(np.abs(rows[:, 1:3]).max()) or 1.0
    points = rows[:, 1:] / size
    return size, (points[:, ::2] + 1j * points[:, 1::2]).T


def _turns(tangent: Vectors) -> Array:
    """By how much the tangent turns from each sample to the next, rad."""
    turns: Array = np.angle(tangent[1:] * tangent[:-1].conj())
    return turns


def _curvatures(tangent: Vectors, bend: Vectors) -> Array:
    """In parts of 1 through a curve's size, positive where it turns to the left."""
    curvatures: Array = (tangent.conj() * bend).imag / np.abs(tangent) ** 3
    return curvatures


def _jumps(rows: Array) -> Array:
    """Corners, rad, and 100 gaps in parts of the size, between samples of a curve, (2, k - 1).

    Turns and ways that the derivatives at both samples do not explain; a cusp is a corner of π.
    """
    half = 0.5 * np.diff(rows[:, 0])
    with np.errstate(all="ignore"):  # of what is no number, or 0
        place, tangent, bend = _vectors(rows)[1]
        rates = (bend / tangent).imag
        turns = _turns(tangent / np.abs(tangent)) - half * (rates[1:] + rates[:-1])
        gaps = np.abs(np.diff(place) - half * (tangent[1:] + tangent[:-1]))
        corners = np.abs(np.angle(np.exp(1j * turns)))
    jumps: Array = np.nan_to_num([corners, 100.0 * gaps], nan=np.pi)
    return jumps


def shape_problems(rows: Array, convex: bool) -> Iterator[str]:
    """The first problem of a closed curve, from its samples."""
    alphas, finite = rows[:, 0], np.isfinite(rows).all(axis=1)
    if not finite.all():
        worst = alphas[np.argmin(finite)]
        yield f"the profile is not finite everywhere from α = 0 to 2π, as at α = {worst:.4g} rad."
        return
    size, (_, tangent, bend) = _vectors(rows)
    narrow = np.diff(alphas) < 2.0 ** (1 - _HALVINGS) * ALPHAS[1]
    jumps = np.where(narrow | (tangent[1:] == 0.0), _jumps(rows), 0.0)
    corner, gap = jumps[:, edge := int(np.argmax(jumps.max(axis=0)))]
    if gap > max(corner, _JUMP):
        yield (
            f"the profile has a gap of {size * gap / 100:.3g} m at α = {alphas[edge]:.4g} rad; "
            "give functions of period 2π, and pieces that meet."
        )
    elif corner > _JUMP:
        turn = np.degrees(max(corner, abs(_turns(tangent)[edge])))
        yield (
            f"the profile has a corner or a cusp: at α = {alphas[edge]:.4g} rad its tangent turns "
            f"by {turn:.3g}°; enlarge the base circle of a profile that is undercut, "
            "else give functions of period 2π, and pieces that meet with one tangent."
        )
    elif convex:
        rounds = _turns(tangent).sum() / (2.0 * math.pi)
        curvatures = np.sign(rounds) * _curvatures(tangent, bend)
        least = int(np.argmin(curvatures))
        if curvatures[least] <= TOLERANCE or abs(rounds) > _ONCE:
            yield (
                f"the profile is not convex: at α = {alphas[least]:.4g} rad its curvature is "
                f"{curvatures[least] / size:.3g} 1/m, and from α = 0 to 2π its tangent turns by "
                f"{360.0 * abs(rounds):.0f}°; a flat face needs a positive one everywhere, and "
                "360°; enlarge the base circle, or use a roller."
            )


def roller_cut(cam: Array, other: Array, inside: bool) -> RollerCut | None:
    """The cut of a roller into the sampled profile that it touches, from outside or `inside`.

    A roller is a circle; of two other curves nothing is known.
    """
    from scipy.spatial import KDTree  # takes a moment, and few scenes have cams

    radii = [_radius(rows) for rows in (cam, other)]
    if radii.count(None) != 1:
        return None
    which = radii.index(None)
    rows = (cam, other)[which][:-1]
    alphas, (size, (place, tangent, bend)) = rows[:, 0], _vectors(rows)
    radius = (radii[1 - which] or 0.0) / size
    if inside and radius > 0.5 * max(np.ptp(place.real), np.ptp(place.imag)):
        return None  # the roller is a ring round it
    way = np.sign(_turns(tangent).sum()) * (-1.0 if inside else 1.0)
    hollows = -way * radius * _curvatures(tangent, bend)
    centres = place - 1j * way * radius * tangent / np.abs(tangent)
    tree = KDTree(np.column_stack([place.real, place.imag]))
    apart, nearest = tree.query(np.column_stack([centres.real, centres.imag]))
    cuts = alphas[(hollows > 1.0 + TOLERANCE) | (radius - apart > _CUT * radius)]
    if not len(cuts):
        return None
    deepest, narrowest = int(np.argmin(apart)), int(np.argmax(hollows))
    k = narrowest if hollows[narrowest] > 1.0 + TOLERANCE else deepest
    return RollerCut(
        which,
        cuts,
        f"the roller of the radius {size * radius:.4g} m, where it touches the profile at α = "
        f"{alphas[k]:.4g} rad, cuts {size * (radius - apart[k]):.2g} m deep into it at α = "
        f"{alphas[nearest[k]]:.4g} rad: the least radius of curvature of the hollows is "
        f"{size * radius / hollows[narrowest]:.4g} m; give a smaller roller, a larger base circle "
        "or a flatter profile.",
    )


def _radius(rows: Array) -> float | None:
    """The radius of a curve that is a circle, m; None of all others."""
    size, (_, tangent, bend) = _vectors(rows)
    curvatures = np.abs(_curvatures(tangent, bend))
    return size / curvatures.mean() if np.ptp(curvatures) <= TOLERANCE * curvatures.mean() else None
