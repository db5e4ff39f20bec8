"""A scene in every setting, and other models of it, compared with the reference and timed.

However tight the tolerance, the error of another model remains. The loosest run whose error is
hardly anything else shows the cost of the choice; in looser runs the two errors add up, or cancel.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from codegen.errors import LinkwrightError
from runtime.studies.harness import TIME, TIMEOUT, Runner, Setting, outcome_name
from runtime.studies.timing import Stopwatch, time_runs
from runtime.studies.work_precision.diagram import Choice, Line, Point
from runtime.studies.work_precision.reference import ReferenceSolution

ENOUGH = 1e-9  # accuracy: scaled error beyond which no tighter tolerance is tried
GIVEN_UP = 2  # safety: successive timeouts after which tighter tolerances, as slow, are not tried
CHOICE_RTOLS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
NOT_TRIED, OTHER_END = "NOT_TRIED", "OTHER_END"
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
        """Every setting at every tolerance; at `further` ones if it does not reach `ENOUGH`."""
        measured: list[tuple[Line, list[TimedPoint]]] = []
        for setting in settings:
            self.progress(f"{self.runner.title}: {setting.title}")
            try:
                measured.append((Line(setting), self._points(setting, rtols, further)))
            except LinkwrightError as error:
                measured.append((Line(setting, refused=" ".join(error.problems)), []))
        self.progress(f"{self.runner.title}: timing in turns")
        done = [watch for _, points in measured for point, watch in points if point.errors]
        time_runs(done, self.rounds, self.least)
        return tuple(
            replace(line, points=tuple(_with_time(*run) for run in points))
            for line, points in measured
        )

    def choice(
        self, choice: Choice, prepare: Callable[[], Runner], settings: Sequence[Setting]
    ) -> Choice:
        """Another model of the scene, in the first setting in which it assembles and runs."""
        self.progress(f"{self.runner.machine.model}/{choice.scene}")
        try:
            runner = prepare()
        except LinkwrightError as error:
            return replace(choice, reason=" ".join(error.problems))
        reasons = []
        for setting in settings:
            try:
                point, watch = self._cheapest(runner, setting)
            except LinkwrightError as error:
                reasons.append(" ".join(error.problems))
            else:
                time_runs([watch], self.rounds, self.least)
                return replace(choice, setting=setting, point=_with_time(point, watch))
        return replace(choice, reason=" ".join(dict.fromkeys(reasons)))

    def _points(
        self, setting: Setting, rtols: Sequence[float], further: Sequence[float]
    ) -> list[TimedPoint]:
        points: list[TimedPoint] = []
        for rtol in (*sorted(rtols, reverse=True), *further):
            if rtol in further and not points[-1][0].worst > ENOUGH:
                break
            last = [point.outcome for point, _ in points[-GIVEN_UP:]]
            if len(last) == GIVEN_UP and set(last) <= {TIMEOUT, NOT_TRIED}:
                point = Point(rtol, NOT_TRIED, "Looser tolerances met the limit of time.")
                points.append((point, self.runner.stopwatch(setting, rtol)))
            else:
                points.append(self._point(self.runner, setting, rtol))
        return points

    def _cheapest(self, runner: Runner, setting: Setting) -> TimedPoint:
        """The loosest run whose error is that of the model, as it is in all tighter runs."""
        points = [self._point(runner, setting, rtol) for rtol in CHOICE_RTOLS]
        tightest = points[-1][0]
        if tightest.errors is None:
            raise LinkwrightError(f"{setting.title}: {tightest.message}")
        done = [(point, watch) for point, watch in points if point.errors]
        limit = _MODEL_ERROR * tightest.worst
        other = [k for k, (p, _) in enumerate(done) if abs(p.worst - tightest.worst) > limit]
        return done[other[-1] + 1 if other else 0]

    def _point(self, runner: Runner, setting: Setting, rtol: float) -> TimedPoint:
        """A run against the reference, and its stopwatch; it is not timed yet."""
        result = runner.run(setting, rtol)
        watch = runner.stopwatch(setting, rtol, result.stats[TIME])
        counts = {name: float(x) for name, x in result.stats.items() if "seconds" not in name}
        point = Point(rtol, outcome_name(result), result.message, counts=counts)
        if result.failed:
            return point, watch
        reference = self.reference
        if different := reference.places.difference(result):
            return replace(point, outcome=OTHER_END, message=different), watch
        errors = reference.errors(result)
        position, velocity = result.samples.residual.max(axis=0)[:2].tolist()
        point = replace(
            point, errors=errors, beyond=errors.worst < reference.about.floor,
            position_residual=position / reference.length,
            velocity_residual=velocity / reference.speed, energy=reference.energy_error(result),
        )  # fmt: skip
        return point, watch


def _with_time(point: Point, watch: Stopwatch) -> Point:
    """A point with its time; that of a run that failed is the time until then."""
    return replace(point, seconds=watch.seconds, spread=watch.spread, runs=len(watch.times))
