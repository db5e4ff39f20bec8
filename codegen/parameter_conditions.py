"""Conditions that a model has on its parameters, judged alike by the build and before each run."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

SAMPLES = 720  # safety: places on a profile at which its shape is looked at, every half degree
ALPHAS = tuple(2 * math.pi * k / SAMPLES for k in range(SAMPLES + 1))
TOLERANCE = 1e-9  # accuracy: gap or stop of a profile, in parts of its size, that rounding explains
_CORNER = 1e-4  # accuracy: of a corner, rad, and of 100 gaps in parts of a profile's size
_TIMES = 4  # measured: how often an interval of α is divided by 8 in which there may be one
_MOST = 3000  # safety: samples of a profile
# accuracy: of a roller's radius; a cut that is less deep is one of sampled points
_CUT = 1e-6
_ONCE = 1.5  # safety: turns of a tangent along a curve that goes round once
Array = npt.NDArray[np.float64]


class ProfileSamples(NamedTuple):
    """Samples of a closed curve."""

    alphas: Array  # ascending from 0 to 2π, (k,)
    points: Array  # x, y and their first two derivatives, (k, 6)


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
        value = values[0]
        enough = row.low is None or value > row.low or (value == row.low and not row.open)
        if not (enough and (row.high is None or value <= row.high)):
            yield f"{row.element}: {row.sentence.format(*values)}"


def profile_problems(rows: Sequence[ProfileRow], curves: Sequence[ProfileSamples]) -> Iterator[str]:
    """A sentence for each curve that is not as it has to be, or is cut by its roller."""
    for k, (row, curve) in enumerate(zip(rows, curves, strict=True)):
        found = [*shape_problems(curve, row.convex)]
        yield from (f"{row.element}: {problem}" for problem in found)
        judged = row.touches and not row.contact and not found
        if judged and (cut := roller_cut(curve, curves[k + 1], row.touches < 0)):
            yield f"{rows[k + cut.which].element}: {cut.sentence}"


def profile_samples(at: Callable[[Array], Array]) -> list[ProfileSamples]:
    """Curves at α = `ALPHAS`, and closer where a tangent turns fast, or pieces meet.

    `at` returns x, y and their first and second derivatives, (k, 6 curves), for α, (k,).
    """
    alphas = np.array(ALPHAS)
    points = at(alphas)
    count = points.shape[1] // 6
    for _ in range(_TIMES):
        jumps = [_jumps(alphas, curve) for curve in np.split(points, count, axis=1)]
        wide = np.flatnonzero(np.max(jumps, axis=0) > _CORNER)
        if not len(wide) or len(alphas) + 7 * len(wide) > _MOST:
            break
        parts = np.linspace(alphas[wide], alphas[wide + 1], 9)[1:-1].T.ravel()
        place = np.repeat(wide + 1, 7)
        points = np.insert(points, place, at(parts), axis=0)
        alphas = np.insert(alphas, place, parts)
    return [ProfileSamples(alphas, curve) for curve in np.split(points, count, axis=1)]


def _jumps(alphas: Array, points: Array) -> Array:
    """Corners, rad, or 100 gaps in parts of the size, between samples of a profile.

    Turns and ways that the derivatives at both samples do not explain.
    """
    with np.errstate(all="ignore"):  # other checks are of what is no number, or 0
        points = points / np.abs(points[:, :2]).max()
        place, tangent, bend = (points[:, k] + 1j * points[:, k + 1] for k in (0, 2, 4))
        rates, half = (bend / tangent).imag, np.diff(alphas) / 2
        corners = np.abs(np.angle(np.exp(1j * (_turns(points) - half * (rates[1:] + rates[:-1])))))
        gaps = np.abs(np.diff(place) - half * (tangent[1:] + tangent[:-1]))
    jumps: Array = np.fmax(np.fmax(corners, 100.0 * gaps), 0.0)
    return jumps


def _turns(points: Array) -> Array:
    """By how much the tangent turns from each sample of a profile to the next, rad."""
    tangent = points[:, 2] + 1j * points[:, 3]
    with np.errstate(all="ignore"):  # other checks are of what is no number, or 0
        tangent /= np.abs(tangent)
        turns: Array = np.angle(tangent[1:] * tangent[:-1].conj())
    return np.where(np.isnan(turns), 0.0, turns)


def shape_problems(profile: ProfileSamples, convex: bool) -> Iterator[str]:
    """The first problem of a closed curve, from its samples."""
    alphas, points = profile
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        worst = alphas[np.argmin(finite)]
        yield f"the profile is not finite everywhere from α = 0 to 2π, as at α = {worst:.4g} rad."
        return
    size = float(np.abs(points[:, :2]).max()) or 1.0
    points = points / size  # no product overflows, however large it is
    dx, dy, x2, y2 = points.T[2:]
    apart, speeds = math.dist(points[0, :2], points[-1, :2]), np.hypot(dx, dy)
    slowest, turns = int(np.argmin(speeds)), np.abs(_turns(points))
    corner = float(np.degrees(abs(_turns(points[[-1, 0]])[0])))
    jumps = np.where(np.diff(alphas) < 8.0 ** (1 - _TIMES) * ALPHAS[1], _jumps(*profile), 0.0)
    edge = int(np.argmax(jumps))
    if apart > TOLERANCE:
        yield (
            f"the profile does not close: its ends at α = 0 and 2π are {size * apart:.3g} m apart; "
            "give functions of period 2π."
        )
    elif speeds[slowest] <= TOLERANCE:
        yield (
            f"the profile has a cusp: at α = {alphas[slowest]:.4g} rad its tangent is "
            f"{size * speeds[slowest]:.3g} m per rad; give a smooth profile."
        )
    elif np.radians(corner) > _CORNER:
        yield (
            f"the profile has a corner where it closes: its tangents at α = 0 and 2π are "
            f"{corner:.3g}° apart; give functions of period 2π."
        )
    elif jumps[edge] > _CORNER:
        way = size * math.dist(points[edge, :2], points[edge + 1, :2])
        yield (
            f"the profile turns by {np.degrees(turns[edge]):.3g}° within {way:.2g} m at α = "
            f"{alphas[edge]:.6g} rad: it is undercut, or has a corner or a gap; enlarge the base "
            "circle, round the corner, or give pieces that meet there."
        )
    elif convex:
        bends = dx * y2 - dy * x2
        bends *= 1.0 if bends.sum() > 0 else -1.0
        least = int(np.argmin(bends))
        if bends[least] <= TOLERANCE:
            curvature = bends[least] / speeds[least] ** 3 / size
            yield (
                f"the profile is not convex: at α = {alphas[least]:.4g} rad its curvature is "
                f"{curvature:.3g} 1/m, and a flat face needs a positive one everywhere; enlarge "
                "the base circle, or use a roller."
            )
        elif (rounds := float(turns.sum()) / (2.0 * math.pi)) > _ONCE:
            yield (
                f"the profile is not convex: from α = 0 to 2π its tangent turns round {rounds:.3g} "
                "times, so that it crosses itself; give a radius that stays positive."
            )


def roller_cut(cam: ProfileSamples, other: ProfileSamples, inside: bool) -> RollerCut | None:
    """The cut of a roller into the profile that it touches, from outside or `inside`.

    A roller is a circle; of two other curves nothing is known.
    """
    from scipy.spatial import KDTree  # takes a moment, and few scenes have cams

    radii = [_radius(curve) for curve in (cam, other)]
    if radii.count(None) != 1:
        return None
    which = radii.index(None)
    alphas, points = (cam, other)[which]
    size, alphas = float(np.abs(points[:, :2]).max()), alphas[:-1]
    points, radius = points / size, (radii[1 - which] or 0.0) / size
    x, y, dx, dy, x2, y2 = points[:-1].T
    ring = inside and radius > 0.5 * max(np.ptp(x), np.ptp(y))  # the roller is one round it
    if ring or not np.isfinite(points).all():
        return None
    way = np.sign(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])) * (-1.0 if inside else 1.0)
    speed = np.hypot(dx, dy)
    hollows = way * (dy * x2 - dx * y2) / speed**3 * radius
    centres = points[:-1, :2] + radius * way * np.stack([dy, -dx], axis=1) / speed[:, None]
    apart, nearest = KDTree(points[:-1, :2]).query(centres)
    cuts = alphas[(hollows > 1.0 + TOLERANCE) | (radius - apart > _CUT * radius)]
    if not len(cuts):
        return None
    roller, k = f"roller of the radius {size * radius:.4g} m", int(np.argmax(hollows))
    text = (
        f"at α = {alphas[k]:.4g} rad the profile is hollow with a radius of curvature of "
        f"{size * radius / hollows[k]:.4g} m, too small for its {roller}; "
    )
    if hollows[k] <= 1.0 + TOLERANCE:
        k = int(np.argmin(apart))
        text = (
            f"the {roller}, where it touches the profile at α = {alphas[k]:.4g} rad, cuts "
            f"{size * (radius - apart[k]):.3g} m deep into it at α = {alphas[nearest[k]]:.4g} rad; "
        )
    advice = "give a smaller roller, a larger base circle or a flatter profile."
    return RollerCut(which, cuts, text + advice)


def _radius(curve: ProfileSamples) -> float | None:
    """The radius of a curve that is a circle, run through evenly; None of all others."""
    place = curve.points[:-1, 0] + 1j * curve.points[:-1, 1]
    even = np.isin(curve.alphas[:-1], ALPHAS)  # samples that lie closer would weigh more
    apart = np.abs(place - place[even].mean())
    radius = float(apart.mean())
    return radius if np.ptp(apart) <= TOLERANCE * radius else None
