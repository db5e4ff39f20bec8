"""Conditions that a model has on its parameters, judged alike by the build and before each run."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

SAMPLES = 720  # safety: places on a profile at which its shape is looked at, every half degree
ALPHAS = tuple(2 * math.pi * k / SAMPLES for k in range(SAMPLES + 1))
# accuracy: gap, corner or stop of a profile, in parts of its size, that rounding explains
TOLERANCE = 1e-9
_ONCE = 1.5  # safety: turns of a tangent along a curve that goes round once


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


def shape_problems(points: npt.NDArray[np.float64], convex: bool) -> Iterator[str]:
    """Problems of a closed curve from x, y and their first two derivatives at `ALPHAS`, (k, 6)."""
    if not np.isfinite(points).all():
        worst = ALPHAS[int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])]
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
    if speeds[slowest] <= TOLERANCE:
        yield (
            f"the profile has a cusp: at α = {ALPHAS[slowest]:.4g} rad its tangent is "
            f"{size * speeds[slowest]:.3g} m per rad; give a smooth profile."
        )
    elif convex:
        bends = dx * y2 - dy * x2
        bends *= 1.0 if bends.sum() > 0 else -1.0
        least = int(np.argmin(bends))
        if bends[least] <= TOLERANCE:
            curvature = bends[least] / speeds[least] ** 3 / size
            yield (
                f"the profile is not convex: at α = {ALPHAS[least]:.4g} rad its curvature is "
                f"{curvature:.3g} 1/m, and a flat face needs a positive one everywhere; enlarge "
                "the base circle, or use a roller."
            )
        elif (turns := float(np.mean(bends[:-1] / speeds[:-1] ** 2))) > _ONCE:
            yield (
                f"the profile is not convex: from α = 0 to 2π its tangent turns round {turns:.3g} "
                "times, so that it crosses itself; give a radius that stays positive."
            )
