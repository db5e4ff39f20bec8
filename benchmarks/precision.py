"""Work and precision: what a contestant needs for an error, and time taken so that it can be told.

Every contestant runs a grid of settings. Errors fall by luck where two errors cancel, so a point
counts with the largest error that any tighter setting of its series has; the time to an error is
read off the line through such points, logarithm over logarithm, and not beyond its ends.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from time import process_time
from typing import Any

ENOUGH = 0.5
"""Seconds of repeats of one point, after which no more are made."""


@dataclass(frozen=True)
class Point:
    """A setting, and what it gave.

    Attributes
    ----------
    contestant, method, setting
        Whose, by which method, and its tolerance or step.
    error
        Largest difference from the reference, rad.
    milliseconds
        Of the integration alone, the least of several.
    evaluations
        Of the right-hand side, or steps where a method has none; 0 where it was not told.
    note
        What went wrong, if anything; such a point is no answer.
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
    """(error, milliseconds), errors without luck, from the largest error to the least."""
    worst, kept = 0.0, []
    for point in sorted((p for p in points if p.right), key=lambda point: point.setting):
        if point.error >= worst:
            worst = max(point.error, 1e-16)
            kept.append((worst, point.milliseconds))
    return kept[::-1]


def time_to(error: float, points: Sequence[Point]) -> float:
    """Milliseconds in which one series reaches an error; infinite where it does not.

    Where its loosest setting is better than was asked, that setting's time.
    """
    line = reliable(points)
    if not line or line[-1][0] > error:
        return math.inf
    if line[0][0] <= error:
        return line[0][1]
    for (larger, quick), (less, slow) in pairwise(line):
        if less <= error <= larger:
            share = math.log(larger / error) / math.log(larger / less)
            return math.exp((1.0 - share) * math.log(quick) + share * math.log(slow))
    return math.inf


def best_time(error: float, points: Sequence[Point]) -> tuple[float, str]:
    """The least time of all methods of a contestant, and which method it was."""
    times = {method: time_to(error, line) for (_, method), line in series(points).items()}
    if not times:
        return math.inf, ""
    method = min(times, key=lambda name: times[name])
    return times[method], method


def interleaved(runs: Mapping[Any, Callable[[], float]], repeats: int) -> dict[Any, float]:
    """Least seconds of each, taken in turns; a run answers its own seconds."""
    best = dict.fromkeys(runs, math.inf)
    for _ in range(repeats + 1):
        for name, run in runs.items():
            best[name] = min(best[name], run())
    return best


def least(run: Callable[[], Any], repeats: int = 5) -> tuple[float, Any]:
    """Least milliseconds of processor time of a run, and its answer.

    At most `repeats` times, or as is enough.
    """
    best, spent, answer = math.inf, 0.0, None
    for _ in range(repeats):
        started = process_time()
        answer = run()
        seconds = process_time() - started
        best, spent = min(best, seconds), spent + seconds
        if spent > ENOUGH:
            break
    return best * 1e3, answer
