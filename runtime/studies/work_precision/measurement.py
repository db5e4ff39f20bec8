"""The settings, run at every tolerance, judged against the reference and timed."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from codegen.errors import InputError, LinkwrightError
from runtime.studies.work_precision.diagram import (
    DONE,
    NOT_TRIED,
    TIMEOUT,
    Line,
    Point,
    Setting,
)
from runtime.studies.work_precision.reference_solution import Truth
from runtime.studies.work_precision.timed_runs import Runner, Stopwatch, take_turns

if TYPE_CHECKING:
    from runtime.results.result import Result

ENOUGH = 1e-9
"""Scaled error beyond which no tighter tolerance is tried."""
GIVEN_UP = 2
"""Runs in a row that meet the limit of time; tighter tolerances take no less and are not tried."""


def lines(
    runner: Runner,
    truth: Truth,
    settings: Sequence[Setting],
    rtols: Sequence[float],
    further: Sequence[float],
    rounds: int,
    least: float,
    progress: Callable[[str], None],
) -> tuple[Line, ...]:
    """Every setting at every tolerance, the loosest first.

    Parameters
    ----------
    further
        Tolerances, tighter than `rtols`, for settings that do not come to `ENOUGH` by these.
    rounds, least
        As in `take_turns`.
    """
    made: list[tuple[Line, list[Stopwatch]]] = []
    title = runner.machine.description.title
    for setting in settings:
        progress(f"{title}: {setting.title}")
        made.append(_line(runner, truth, setting, rtols, further))
    progress(f"{title}: taking times")
    turns = [
        (line.setting, point.rtol, watch)
        for line, watches in made
        for point, watch in zip(line.points, watches, strict=True)
        if point.outcome == DONE
    ]
    take_turns(runner, turns, rounds, least)
    return tuple(
        replace(line, points=tuple(map(timed, line.points, watches))) for line, watches in made
    )


def _line(
    runner: Runner,
    truth: Truth,
    setting: Setting,
    rtols: Sequence[float],
    further: Sequence[float],
) -> tuple[Line, list[Stopwatch]]:
    points: list[Point] = []
    watches: list[Stopwatch] = []
    given_up = False
    for rtol in (*sorted(rtols, reverse=True), *further):
        if rtol in further and (points[-1].errors is None or points[-1].errors.worst <= ENOUGH):
            break
        watch = Stopwatch()
        watches.append(watch)
        if given_up:
            points.append(Point(rtol, NOT_TRIED, "Looser tolerances met the limit of time."))
            continue
        try:
            result, outcome = runner.run(setting, rtol, watch)
        except LinkwrightError as error:
            problems = error.problems if isinstance(error, InputError) else (str(error),)
            return Line(setting, refused=" ".join(problems)), []
        points.append(judged(result, outcome, rtol, truth))
        given_up = [point.outcome for point in points[-GIVEN_UP:]] == [TIMEOUT] * GIVEN_UP
    return Line(setting, tuple(points)), watches


def judged(result: "Result", outcome: str, rtol: float, truth: Truth) -> Point:
    """A run against the reference, its time not measured yet."""
    counts = {name: float(count) for name, count in result.stats.items() if "seconds" not in name}
    if outcome != DONE:
        return Point(rtol, outcome, result.message, counts=counts)
    found = truth.errors(result)
    return Point(
        rtol,
        outcome,
        result.message,
        found,
        beyond=found.worst < truth.reference.floor,
        counts=counts,
        position_residual=float(result.samples.residual[:, 0].max()) / truth.length,
        velocity_residual=float(result.samples.residual[:, 1].max()) / truth.speed,
        energy=truth.energy_error(result),
    )


def timed(point: Point, watch: Stopwatch) -> Point:
    """A point with its time; that of a run that failed is the time until then."""
    if not watch.times:
        return point
    return replace(point, seconds=watch.seconds, spread=watch.spread, runs=len(watch.times))
