"""A scene in every setting, and other models of it, compared with the reference and timed.

However tight the tolerance, the error of another model remains. The loosest run whose error is
hardly anything else shows the cost of the choice; in looser runs the two errors add up, or cancel.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from codegen.errors import InputError, LinkwrightError
from runtime.studies.timing import Stopwatch
from runtime.studies.work_precision import timed_runs as timed
from runtime.studies.work_precision.diagram import Choice, Line, Point, Setting
from runtime.studies.work_precision.reference_solution import ReferenceSolution
from runtime.studies.work_precision.timed_runs import Runner

if TYPE_CHECKING:
    from codegen import Scene

ENOUGH = 1e-9  # accuracy: scaled error beyond which no tighter tolerance is tried
GIVEN_UP = 2  # safety: successive timeouts after which tighter tolerances, as slow, are not tried
CHOICE_RTOLS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
TimedPoint = tuple[Point, Stopwatch]
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
        measured: list[tuple[Line, list[TimedPoint]]] = []
        for setting in settings:
            self.progress(f"{self.runner.title}: {setting.title}")
            try:
                measured.append((Line(setting), self._points(setting, rtols, further)))
            except LinkwrightError as error:
                measured.append((Line(setting, refused=_reason(error)), []))
        self.progress(f"{self.runner.title}: timing in turns")
        done = [watch for _, points in measured for point, watch in points if point.errors]
        timed.time_runs(done, self.rounds, self.least)
        return tuple(
            replace(line, points=tuple(_with_time(*run) for run in points))
            for line, points in measured
        )

    def _points(
        self, setting: Setting, rtols: Sequence[float], further: Sequence[float]
    ) -> list[TimedPoint]:
        points: list[TimedPoint] = []
        for rtol in (*sorted(rtols, reverse=True), *further):
            if rtol in further and not points[-1][0].worst > ENOUGH:
                break
            last = [point.outcome for point, _ in points[-GIVEN_UP:]]
            if len(last) == GIVEN_UP and set(last) <= {timed.TIMEOUT, timed.NOT_TRIED}:
                point = Point(rtol, timed.NOT_TRIED, "Looser tolerances met the limit of time.")
                points.append((point, self.runner.stopwatch(setting, rtol)))
            else:
                points.append(self._point(self.runner, setting, rtol))
        return points

    def _point(self, runner: Runner, setting: Setting, rtol: float) -> TimedPoint:
        """A run against the reference, and its stopwatch; it is not timed yet."""
        result = runner.run(setting, rtol)
        watch = runner.stopwatch(setting, rtol, timed.integration_time(result))
        counts = {name: float(x) for name, x in result.stats.items() if "seconds" not in name}
        outcome, reference = timed.outcome_name(result), self.reference
        if outcome != timed.DONE:
            return Point(rtol, outcome, result.message, counts=counts), watch
        errors = reference.errors(result)
        position, velocity = result.samples.residual.max(axis=0)[:2].tolist()
        point = Point(
            rtol, outcome, result.message, errors, errors.worst < reference.about.floor,
            counts=counts, position_residual=position / reference.length,
            velocity_residual=velocity / reference.speed, energy=reference.energy_error(result),
        )  # fmt: skip
        return point, watch

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
                timed.time_runs([watch], self.rounds, self.least)
            except InputError as error:
                reasons.append(_reason(error))
            except LinkwrightError as error:
                reasons.append(f"{setting.title}: {error}")
            else:
                return replace(choice, setting=setting, point=_with_time(point, watch))
        return replace(choice, reason=" ".join(dict.fromkeys(reasons)))

    def _cheapest(self, runner: Runner, setting: Setting) -> TimedPoint:
        """The loosest run whose error is that of the model, as it is in all tighter runs."""
        points = [self._point(runner, setting, rtol) for rtol in CHOICE_RTOLS]
        tightest = points[-1][0]
        if tightest.errors is None:
            raise LinkwrightError(tightest.message)
        done = [(point, watch) for point, watch in points if point.errors]
        limit = _MODEL_ERROR * tightest.worst
        other = [k for k, (p, _) in enumerate(done) if abs(p.worst - tightest.worst) > limit]
        return done[other[-1] + 1 if other else 0]


def _with_time(point: Point, watch: Stopwatch) -> Point:
    """A point with its time; that of a run that failed is the time until then."""
    if not watch.times:
        return point
    return replace(point, seconds=watch.seconds, spread=watch.spread, runs=len(watch.times))


def _reason(error: LinkwrightError) -> str:
    """The message of a refusal in one line."""
    return " ".join(error.problems) if isinstance(error, InputError) else str(error)
