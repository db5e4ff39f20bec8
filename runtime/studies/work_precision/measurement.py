"""A scene run in every setting at every tolerance, compared with the reference and timed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from codegen.errors import InputError, LinkwrightError
from runtime.studies.timing import Stopwatch
from runtime.studies.work_precision.diagram import (
    DONE,
    NOT_TRIED,
    TIMEOUT,
    Line,
    Point,
    Setting,
)
from runtime.studies.work_precision.reference_solution import ReferenceSolution
from runtime.studies.work_precision.timed_runs import Run, Runner, time_runs

ENOUGH = 1e-9  # accuracy: scaled error beyond which no tighter tolerance is tried
GIVEN_UP = 2  # safety: successive timeouts after which tighter tolerances, as slow, are not tried


@dataclass(frozen=True)
class Measurement:
    """How the runs of a study are compared and timed.

    Attributes
    ----------
    runner
        The scene as declared.
    rounds, least
        As in `time_runs`.
    progress
        Receives a line before every step that takes time.
    """

    runner: Runner
    reference: ReferenceSolution
    rounds: int
    least: float
    progress: Callable[[str], None]

    def lines(
        self, settings: Sequence[Setting], rtols: Sequence[float], further: Sequence[float]
    ) -> tuple[Line, ...]:
        """Every setting at every tolerance, the loosest first.

        Parameters
        ----------
        further
            Tolerances tighter than `rtols`, for settings that do not reach `ENOUGH` by these.
        """
        measured: list[tuple[Line, list[Stopwatch]]] = []
        title = self.runner.machine.description.title
        for setting in settings:
            self.progress(f"{title}: {setting.title}")
            measured.append(self._line(setting, rtols, further))
        self.progress(f"{title}: timing in turns")
        completed = [
            watch
            for line, watches in measured
            for point, watch in zip(line.points, watches, strict=True)
            if point.outcome == DONE
        ]
        time_runs(completed, self.rounds, self.least)
        return tuple(
            replace(line, points=tuple(map(with_time, line.points, watches)))
            for line, watches in measured
        )

    def _line(
        self, setting: Setting, rtols: Sequence[float], further: Sequence[float]
    ) -> tuple[Line, list[Stopwatch]]:
        points: list[Point] = []
        watches: list[Stopwatch] = []
        given_up = False
        for rtol in (*sorted(rtols, reverse=True), *further):
            if rtol in further and (points[-1].errors is None or points[-1].errors.worst <= ENOUGH):
                break
            watch = self.runner.stopwatch(setting, rtol)
            watches.append(watch)
            if given_up:
                points.append(Point(rtol, NOT_TRIED, "Looser tolerances met the limit of time."))
                continue
            try:
                run = self.runner.run(setting, rtol)
            except LinkwrightError as error:
                return Line(setting, refused=reason_of(error)), []
            watch.times.append(run.seconds)
            points.append(point_of(run, rtol, self.reference))
            given_up = [point.outcome for point in points[-GIVEN_UP:]] == [TIMEOUT] * GIVEN_UP
        return Line(setting, tuple(points)), watches


def point_of(run: Run, rtol: float, reference: ReferenceSolution) -> Point:
    """A run against the reference; its time is not measured yet."""
    result = run.result
    counts = {name: float(count) for name, count in result.stats.items() if "seconds" not in name}
    if run.outcome != DONE:
        return Point(rtol, run.outcome, result.message, counts=counts)
    errors = reference.errors(result)
    return Point(
        rtol,
        run.outcome,
        result.message,
        errors,
        beyond=errors.worst < reference.about.floor,
        counts=counts,
        position_residual=float(result.samples.residual[:, 0].max()) / reference.length,
        velocity_residual=float(result.samples.residual[:, 1].max()) / reference.speed,
        energy=reference.energy_error(result),
    )


def with_time(point: Point, watch: Stopwatch) -> Point:
    """A point with its time; that of a run that failed is the time until then."""
    if not watch.times:
        return point
    return replace(point, seconds=watch.seconds, spread=watch.spread, runs=len(watch.times))


def reason_of(error: LinkwrightError) -> str:
    """The message of a refusal in one line."""
    return " ".join(error.problems) if isinstance(error, InputError) else str(error)
