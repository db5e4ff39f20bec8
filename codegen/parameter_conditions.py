"""Conditions that a model has on its parameters, judged alike by the build and before each run."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

SAMPLES = 720  # safety: places on a profile at which its shape is looked at, every half degree
ALPHAS = tuple(2 * math.pi * k / SAMPLES for k in range(SAMPLES + 1))
# accuracy: gap, corner or stop of a profile, in parts of its size, that rounding explains
TOLERANCE = 1e-9
# accuracy: of a corner, rad, and a gap, in parts of a profile's size, that rounding explains
_CORNER, _GAP = 1e-4, 1e-6
_TIMES = 4  # measured: how often an interval of α is divided by 8 in which there may be one
_MOST = 3000  # safety: samples of a profile
# accuracy: of a roller's radius; a cut that is less deep is one of sampled points
_CUT = 1e-6
_ONCE = 1.5  # safety: turns of a tangent along a curve that goes round once


class ProfileSamples(NamedTuple):
    """Samples of a closed curve."""

    alphas: npt.NDArray[np.float64]  # ascending from 0 to 2π, (k,)
    points: npt.NDArray[np.float64]  # x, y and their first two derivatives, (k, 6)


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


def profile_samples(at: Callable[[float], npt.NDArray[np.float64]]) -> ProfileSamples:
    """A curve at α = `ALPHAS`, and closer where its tangent turns fast, or its pieces meet.

    `at` returns x, y and their first and second derivatives for a number α.
    """
    alphas = np.array(ALPHAS)
    points = np.array([at(a) for a in ALPHAS], dtype=np.float64)
    for _ in range(_TIMES):
        corners, gaps = _jumps(alphas, points)
        wide = np.flatnonzero((corners > _CORNER) | (gaps > _GAP))
        if not len(wide) or len(alphas) + 7 * len(wide) > _MOST:
            break
        parts = np.linspace(alphas[wide], alphas[wide + 1], 9)[1:-1].T.ravel()
        place = np.repeat(wide + 1, 7)
        points = np.insert(points, place, np.array([at(float(a)) for a in parts]), axis=0)
        alphas = np.insert(alphas, place, parts)
    return ProfileSamples(alphas, points)


def _jumps(
    alphas: npt.NDArray[np.float64], points: npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Angles of corners, rad, and gaps in parts of the size, between samples of a profile.

    Turns and ways that the derivatives at both samples do not explain.
    """
    points = points / (np.abs(points[:, :2]).max() or 1.0)
    place, tangent, bend = (points[:, k] + 1j * points[:, k + 1] for k in (0, 2, 4))
    with np.errstate(all="ignore"):  # other checks are of what is no number, or 0
        rates = (bend / tangent).imag
        half = np.diff(alphas) / 2
        corners = np.abs(np.angle(np.exp(1j * (_turns(points) - half * (rates[1:] + rates[:-1])))))
        gaps = np.abs(np.diff(place) - half * (tangent[1:] + tangent[:-1]))
    return np.nan_to_num(corners), np.nan_to_num(gaps)


def _turns(points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """By how much the tangent turns from each sample of a profile to the next, rad."""
    tangent = points[:, 2] + 1j * points[:, 3]
    with np.errstate(all="ignore"):  # other checks are of what is no number, or 0
        tangent /= np.abs(tangent)
        turns: npt.NDArray[np.float64] = np.angle(tangent[1:] * tangent[:-1].conj())
    turns[np.isnan(turns)] = 0.0
    return turns


def shape_problems(profile: ProfileSamples, convex: bool) -> Iterator[str]:
    """Problems of a closed curve from its samples."""
    alphas, points = profile
    if not np.isfinite(points).all():
        worst = alphas[int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])]
        yield f"the profile is not finite everywhere from α = 0 to 2π, as at α = {worst:.4g} rad."
        return
    size = float(np.abs(points[:, :2]).max()) or 1.0
    gaps = np.abs(points[-1] - points[0])
    for fault, ends, gap in (
        ("does not close", "ends", gaps[:2].max()),
        ("has a corner where it closes", "tangents", gaps[2:4].max()),
    ):
        if gap > TOLERANCE * size:
            yield (
                f"the profile {fault}: its {ends} at α = 0 and 2π are {gap:.3g} m apart; give "
                "functions of period 2π."
            )
            return
    dx, dy, x2, y2 = points.T[2:] / size  # no product overflows, however large it is
    speeds = np.hypot(dx, dy)
    slowest = int(np.argmin(speeds))
    turns, (corners, jumps) = np.abs(_turns(points)), _jumps(alphas, points)
    fine = np.diff(alphas) < 8.0 ** (1 - _TIMES) * ALPHAS[1]
    edge, jump = (int(np.argmax(np.where(fine, one, 0.0))) for one in (corners, jumps))
    if speeds[slowest] <= TOLERANCE:
        yield (
            f"the profile has a cusp: at α = {alphas[slowest]:.4g} rad its tangent is "
            f"{size * speeds[slowest]:.3g} m per rad; give a smooth profile."
        )
    elif fine[jump] and jumps[jump] > _GAP:
        yield (
            f"the profile has a gap of {size * jumps[jump]:.3g} m at α = {alphas[jump]:.6g} rad; "
            "give pieces that meet there."
        )
    elif fine[edge] and corners[edge] > _CORNER:
        radius = math.dist(points[edge, :2], points[edge + 1, :2]) / turns[edge]
        yield (
            f"the profile turns by {np.degrees(turns[edge]):.3g}° at α = {alphas[edge]:.6g} rad, "
            f"with a radius of curvature of {radius:.1g} m: it is undercut, or has a corner; "
            "enlarge the base circle, or round the corner."
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


def roller_problems(
    cam: ProfileSamples, other: ProfileSamples, inside: bool
) -> Iterator[tuple[int, str]]:
    """Where a roller cuts into the profile that it touches, from outside or `inside`.

    Each with the number of the profile, 0 or 1. A roller is a circle; of two other curves nothing
    is known.
    """
    from scipy.spatial import KDTree  # takes a moment, and few scenes have cams

    radii = [_radius(curve.points) for curve in (cam, other)]
    if radii.count(None) != 1:
        return
    which, radius = (0, radii[1]) if radii[0] is None else (1, radii[0])
    alphas, points = (cam, other)[which]
    assert radius is not None
    size = float(np.abs(points[:, :2]).max())
    points, radius = points / size, radius / size  # no product overflows, however large it is
    x, y, dx, dy, x2, y2 = points[:-1].T
    if inside and radius > 0.5 * max(np.ptp(x), np.ptp(y)):
        return  # it is a ring round the profile
    way = np.sign(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])) * (-1.0 if inside else 1.0)
    speed = np.hypot(dx, dy)
    bends = way * (dx * y2 - dy * x2) / speed**3
    least = int(np.argmin(bends))
    advice = "give a smaller roller, a larger base circle or a flatter profile."
    if -bends[least] * radius > 1.0 + TOLERANCE:
        problem = (
            f"at α = {alphas[least]:.4g} rad the profile is hollow with a radius of curvature of "
            f"{-size / bends[least]:.4g} m, too small for its roller of the radius "
            f"{size * radius:.4g} m; "
        )
        yield which, problem + advice
        return
    centres = points[:-1, :2] + radius * way * np.stack([dy, -dx], axis=1) / speed[:, None]
    apart, nearest = KDTree(points[:-1, :2]).query(centres)
    k = int(np.argmin(apart))
    if (depth := radius - apart[k]) > _CUT * radius:
        problem = (
            f"the roller of the radius {size * radius:.4g} m, where it touches the profile at α = "
            f"{alphas[k]:.4g} rad, cuts {size * depth:.3g} m deep into it at α = "
            f"{alphas[nearest[k]]:.4g} rad; "
        )
        yield which, problem + advice


def _radius(points: npt.NDArray[np.float64]) -> float | None:
    """The radius of a curve that is a circle, run through evenly; None of all others."""
    place = points[:-1, 0] + 1j * points[:-1, 1]
    apart = np.abs(place - place.mean())
    radius = float(apart.mean())
    return radius if np.ptp(apart) <= TOLERANCE * radius else None
