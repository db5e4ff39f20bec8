"""Work-precision of the contestants: their points, and their times to an error.

Every contestant runs a grid of settings. Errors are small by luck where two errors cancel, so a
point counts with the largest error of any tighter setting of its series; the time to an error is
interpolated between such points, logarithm over logarithm, and not extrapolated.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from runtime.studies.harness import processor_time, time_to_error

Answer = TypeVar("Answer")

ENOUGH = 0.5
"""Seconds of runs of one point, after which it is not repeated."""


@dataclass(frozen=True)
class Point:
    """A setting, its error and its time.

    Attributes
    ----------
    contestant, method, setting
        Tool, method, and tolerance or step.
    error
        Largest difference from the reference, rad.
    milliseconds
        Of the integration alone, the least of several.
    evaluations
        Of the right-hand side, or steps where a method has none; 0 where unknown.
    note
        The failure, if any; such a point is no answer.
    """

    contestant: str
    method: str
    setting: float
    error: float
    milliseconds: float
    evaluations: int = 0
    note: str = ""

    @property
    def right(self) -> bool:
        """Whether it is an answer at all."""
        return not self.note and math.isfinite(self.error) and self.milliseconds > 0.0


def series(points: Sequence[Point]) -> dict[tuple[str, str], list[Point]]:
    """The points by contestant and method, from the loosest setting to the tightest."""
    found: dict[tuple[str, str], list[Point]] = {}
    for point in sorted(points, key=lambda point: -point.setting):
        found.setdefault((point.contestant, point.method), []).append(point)
    return found


def reliable(points: Sequence[Point]) -> list[tuple[float, float]]:
    """(error, milliseconds) without lucky errors, from the largest error to the least."""
    worst, kept = 0.0, []
    for point in sorted((p for p in points if p.right), key=lambda point: point.setting):
        if point.error >= worst:
            worst = max(point.error, 1e-16)
            kept.append((worst, point.milliseconds))
    return kept[::-1]


def time_to(error: float, points: Sequence[Point]) -> float:
    """Milliseconds in which one series reaches an error; infinite if it does not.

    If its loosest setting is better than the error, the time of that setting.
    """
    return time_to_error(reliable(points), error)


def best_time(error: float, points: Sequence[Point]) -> tuple[float, str]:
    """The least time of all methods of a contestant, and its method."""
    times = {method: time_to(error, line) for (_, method), line in series(points).items()}
    if not times:
        return math.inf, ""
    method = min(times, key=lambda name: times[name])
    return times[method], method


def least(run: Callable[[], Answer], repeats: int = 5) -> tuple[float, Answer]:
    """Least milliseconds of processor time of a run, and its answer.

    It is repeated until it took `ENOUGH`, and `repeats` times at most.
    """
    times: list[float] = []
    while True:
        answer, seconds = processor_time(run)
        times.append(seconds)
        if sum(times) > ENOUGH or len(times) >= repeats:
            return min(times) * 1e3, answer
