"""A scene in every setting, and other models of it, compared with the reference and timed.

However tight the tolerance, the error of another model remains. The loosest run whose error is
hardly anything else shows the cost of the choice; in looser runs the two errors add up, or cancel.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from codegen.errors import InputError, LinkwrightError
from runtime.core.outcomes import Outcome
from runtime.results.result import Result
from runtime.studies.timing import Stopwatch
from runtime.studies.work_precision import timed_runs
from runtime.studies.work_precision.diagram import Choice, Line, Point, Setting
from runtime.studies.work_precision.reference_solution import ReferenceSolution
from runtime.studies.work_precision.timed_runs import Runner, integration_time

if TYPE_CHECKING:
    from codegen import Scene

ENOUGH = 1e-9  # accuracy: scaled error beyond which no tighter tolerance is tried
GIVEN_UP = 2  # safety: successive timeouts after which tighter tolerances, as slow, are not tried
CHOICE_RTOLS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
_MODEL_ERROR = 0.1  # accuracy: share by which a run's error may differ from the tightest run's


@dataclass(frozen=True)
class Measurement:
    """How the runs of a study are compared and timed."""

    runner: Runner  # of the scene as declared
    reference: ReferenceSolution
    rounds: int  # of each run, as in `time_runs`
    least: float  # s, as in `time_runs`
    progress: Callable[[str], None]  # receives a line before every step that takes time

    def lines(
        self, settings: Sequence[Setting], rtols: Sequence[float], further: Sequence[float]
    ) -> tuple[Line, ...]:
        """Every setting at every tolerance, the loosest first.

        The `further` ones, tighter, are for settings that do not reach `ENOUGH` before.
        """
        measured: list[tuple[Line, list[Stopwatch]]] = []
        for setting in settings:
            self.progress(f"{self.runner.title}: {setting.title}")
            measured.append(self._line(setting, rtols, further))
        self.progress(f"{self.runner.title}: timing in turns")
        completed = [
            watch
            for line, watches in measured
            for point, watch in zip(line.points, watches, strict=True)
            if point.outcome == timed_runs.DONE
        ]
        timed_runs.time_runs(completed, self.rounds, self.least)
        return tuple(
            replace(line, points=tuple(map(_with_time, line.points, watches)))
            for line, watches in measured
        )

    def _line(
        self, setting: Setting, rtols: Sequence[float], further: Sequence[float]
    ) -> tuple[Line, list[Stopwatch]]:
        points: list[Point] = []
        watches: list[Stopwatch] = []
        given_up = False
        for rtol in (*sorted(rtols, reverse=True), *further):
            if rtol in further and not points[-1].worst > ENOUGH:
                break
            watch = self.runner.stopwatch(setting, rtol)
            watches.append(watch)
            if given_up:
                points.append(
                    Point(rtol, timed_runs.NOT_TRIED, "Looser tolerances met the limit of time.")
                )
                continue
            try:
                result = self.runner.run(setting, rtol)
            except LinkwrightError as error:
                return Line(setting, refused=_reason(error)), []
            watch.times.append(integration_time(result))
            points.append(_point(result, rtol, self.reference))
            given_up = [point.outcome for point in points[-GIVEN_UP:]] == [
                timed_runs.TIMEOUT
            ] * GIVEN_UP
        return Line(setting, tuple(points)), watches

    def choices(
        self, others: "Sequence[tuple[Choice, Scene]]", prepare: "Callable[[Scene], Runner]",
        settings: Sequence[Setting],
    ) -> tuple[Choice, ...]:  # fmt: skip
        """Other models of the scene, each run until the error of its model is all that is left.

        A scene is tried in the settings until one runs; `prepare` raises LinkwrightError where it
        does not assemble.
        """
        measured = []
        for choice, scene in others:
            self.progress(f"{self.runner.machine.model}/{scene.name}")
            try:
                runner = prepare(scene)
            except LinkwrightError as error:
                measured.append(replace(choice, reason=_reason(error)))
            else:
                measured.append(self._choice(choice, runner, settings))
        return tuple(measured)

    def _choice(self, choice: Choice, runner: Runner, settings: Sequence[Setting]) -> Choice:
        """A choice in the first setting that works."""
        reasons = []
        for setting in settings:
            try:
                point, watch = self._cheapest(runner, setting)
                timed_runs.time_runs([watch], self.rounds, self.least)
            except InputError as error:
                reasons.append(_reason(error))
            except LinkwrightError as error:
                reasons.append(f"{setting.title}: {error}")
            else:
                return replace(choice, setting=setting, point=_with_time(point, watch))
        return replace(choice, reason=" ".join(dict.fromkeys(reasons)))

    def _cheapest(self, runner: Runner, setting: Setting) -> tuple[Point, Stopwatch]:
        """The loosest run whose error is that of the model, as it is in all tighter runs."""
        runs: list[tuple[Point, Stopwatch]] = []
        for rtol in CHOICE_RTOLS:
            result = runner.run(setting, rtol)
            if result.outcome is Outcome.OK:
                watch = runner.stopwatch(setting, rtol, integration_time(result))
                runs.append((_point(result, rtol, self.reference), watch))
            elif rtol == CHOICE_RTOLS[-1]:
                raise LinkwrightError(result.message)
        last = runs[-1][0].worst
        other = [k for k, (p, _) in enumerate(runs) if abs(p.worst - last) > _MODEL_ERROR * last]
        return runs[other[-1] + 1 if other else 0]


def _point(result: Result, rtol: float, reference: ReferenceSolution) -> Point:
    """A run against the reference; its time is not measured yet."""
    counts = {name: float(count) for name, count in result.stats.items() if "seconds" not in name}
    if result.outcome is not Outcome.OK:
        return Point(rtol, timed_runs.outcome_name(result), result.message, counts=counts)
    errors = reference.errors(result)
    position, velocity = result.samples.residual.max(axis=0)[:2].tolist()
    return Point(
        rtol, timed_runs.DONE, result.message, errors, errors.worst < reference.about.floor,
        counts=counts, position_residual=position / reference.length,
        velocity_residual=velocity / reference.speed, energy=reference.energy_error(result),
    )  # fmt: skip


def _with_time(point: Point, watch: Stopwatch) -> Point:
    """A point with its time; that of a run that failed is the time until then."""
    if not watch.times:
        return point
    return replace(point, seconds=watch.seconds, spread=watch.spread, runs=len(watch.times))


def _reason(error: LinkwrightError) -> str:
    """The message of a refusal in one line."""
    return " ".join(error.problems) if isinstance(error, InputError) else str(error)
