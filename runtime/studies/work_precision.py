"""A work-precision study of one scene: every setting, every tolerance, its error and its time."""

import hashlib
import sys
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from os import PathLike
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import AnalysisError, LinkwrightError, SceneError
from codegen.readers import arguments as readers
from codegen.readers.values import KindError
from runtime.dynamics.formulations import FORMULATIONS
from runtime.integrate.method import METHODS
from runtime.machine_facade import Machine
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.mechanism import Values
from runtime.mechanism.table_rows import unknown
from runtime.results.result import Result
from runtime.studies import harness
from runtime.studies.diagram import Choice, Line, Point, WorkPrecision, fastest
from runtime.studies.harness import TIME, TIMEOUT, Place, Report, Runner, Setting, outcome_name
from runtime.studies.reference import (
    LIMIT_FACTOR,
    TIGHTEST,
    ReferenceFile,
    ReferenceSolution,
    default_quantities,
    find_reference,
    read_reference,
    series_of,
)
from runtime.validation.scene_support import refuse_massless, require_motion

if TYPE_CHECKING:
    from codegen import Model, Scene

RTOLS = tuple(10.0 ** -(2.0 + 0.5 * m) for m in range(17))  # 1e-2 to 1e-10, two a decade
# To 1e-12, for settings that do not reach nine digits with the others:
FURTHER = tuple(10.0 ** -(10.5 + 0.5 * m) for m in range(4))
QUICK = (1e-3, 1e-5, 1e-7, 1e-9)
LEAST_RTOL = 1e-12  # accuracy: tightest rtol of a compared run
REPEATS = 5, 0.1  # measured: least number of timed runs of a setting, and their time in s
QUICK_REPEATS = 3, 0.01  # measured: the same of a quick study
ENOUGH = 1e-9  # accuracy: scaled error beyond which no tighter tolerance is tried
GIVEN_UP = 2  # safety: timeouts in a row after which tighter tolerances are not tried
CHOICE_RTOLS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
_MODEL_ERROR = 0.1  # accuracy: share by which a run's error may differ from the tightest run's


def _some(thing: str, reader: readers.Reader, known: Sequence[str] = ()) -> readers.Reader:
    """What `reader` reads, one at least, and of the known names where there are any."""

    def read(value: Any) -> tuple[Any, ...]:
        found = tuple(reader(value))
        problems = [unknown(thing, one, known) for one in found if known and one not in known]
        if problems or not found:
            raise KindError(" ".join(problems) or f"there is no {thing} to try; name one.")
        return found

    return read


@readers.reads(**harness.READERS | {
    "quantities": readers.texts('("crank.phi",)'), "reference": readers.optional(readers.path),
    "methods": _some("method", readers.texts('("dop853",)'), METHODS),
    "formulations": _some("formulation", readers.texts('("reduced",)'), FORMULATIONS),
    "rtols": readers.optional(_some("tolerance", readers.several(
        readers.number("a number", above=LEAST_RTOL, below=0.1, closed=True),
        f"numbers from {LEAST_RTOL:g} to 0.1, so that the reference, at {TIGHTEST:g}, is better",
    ))),
    "beside": readers.several(readers.scene, "a sequence of scenes, by name or as a Scene"),
    "building": readers.optional(readers.flag), "points": readers.count(2),
    "limit": readers.number("a positive time in s", above=0.0), "steps": readers.count(1),
    **dict.fromkeys(("modelling", "quick"), readers.flag),
})  # fmt: skip
@harness.takes_simulation_arguments("correction")
def accuracy(
    model: "str | PathLike[str] | Model", scene: "str | Scene | None" = None, *,
    quantities: Sequence[str] = (), t_end: float | None = None, t_start: float = 0.0,
    methods: Sequence[str] = METHODS, formulations: Sequence[str] = FORMULATIONS,
    rtols: Sequence[float] | None = None, points: int = 200, reference: Place | None = None,
    modelling: bool = True, beside: "Sequence[str | Scene]" = (), building: bool | None = None,
    quick: bool = False, limit: float = 10.0, steps: int = 1_000_000,
    parameters: Values | None = None, guess: Values | None = None, start: Values | None = None,
    folder: Place | None = None, generated: Place | None = None,
    progress: Report = lambda line: None, **run: Any,
) -> WorkPrecision:  # fmt: skip
    """The work-precision diagram of a scene: digits against time, by every method.

    Parameters
    ----------
    model, scene, folder, generated, parameters, guess, start
        As in `load` and the analyses, `start` by name. Undeclared scenes are compiled in
        `.linkwright_cache`.
    quantities
        Series that are compared, as `Result.series` names them; unless given, the coordinates from
        which the scene starts and their velocities. ``a.x|b.x`` is the one of the two that a scene
        has, for modelling choices whose bodies have different names.
    t_end, t_start
        Of the run, s. Without `t_end`, the run ends with the reference from a file.
    methods, formulations
        As in `simulate`; all combinations run. With "dop853" in all coordinates, correction at
        every stage and projection are tried as well.
    rtols
        Relative tolerances, 1e-12 at least; unless given, two per decade from 1e-2 to 1e-10, and to
        1e-12 where nine digits need it. Absolute tolerances follow as in `simulate`.
    points
        Number of equally spaced instants, without the start, at which runs are compared.
    reference
        A .csv file with columns t, in s, and the quantities, to compare with at its instants.
        Without a file, the reference is a run of one method at 1e-13 that other methods confirm.
    modelling, beside
        `modelling`: whether the scene also runs with each other fidelity of elements that have
        several. `beside`: further scenes that model the same machine, compared in the same way.
    building
        Whether the scene is built anew and each stage timed, with the companion modules of the
        methods; by default unless `quick`, which runs four tolerances with few repeats.
    limit, steps
        Limits of a run: time in s, and number of steps. A reference may take more.
    atol, controllers, until, time_scale, first_step, max_step, max_steps, max_bytes
        As in `simulate`, for each of its runs; `correction` follows from the setting.
    progress
        Receives a line before every step that takes time.

    Raises
    ------
    InputError
        If an argument is invalid, or nothing is integrated in the scene.
    LinkwrightError
        If no reference can be computed.
    """
    from codegen.reading.scene_selection import declared, variants

    further = () if rtols or quick else FURTHER
    rtols = rtols or (QUICK if quick else RTOLS)
    source = harness.read_source(model, scene, folder, generated)
    machine = source.machine()
    names, instants, file = _comparison(machine, quantities, reference, t_start, t_end, points)
    # Scenes of the same machine: other fidelities of things that have several, and those named.
    changes = variants(source.model, source.scene) if modelling else ()
    others = [
        (change.title, change.kind, change.of(source.scene))
        for change in changes
        if change.word != harness.LEFT_OUT
    ]
    named = [declared(source.model, one)[1] for one in beside]
    others += [(scene.name, "scene", scene) for scene in named]
    words = harness.read_simulation_arguments(machine, run) | {"parameters": parameters}
    values = {"parameters": parameters, "guess": guess, "start": start}
    runner = Runner(machine, machine.assemble(**values, t=t_start), instants, limit, steps, words)
    if runner.begin.is_determined:
        raise AnalysisError(
            f"{runner.title}: drivers leave no freedom, so nothing is integrated, and accuracy is "
            "that of Newton's method. Choose a scene that forces move."
        )
    progress(
        f"{runner.title}: at most {limit:g} s and {steps:g} steps per run, "
        f"{LIMIT_FACTOR * limit:g} s for a reference"
    )
    settings, costs = harness.all_settings(methods, formulations), dict[str, float]()
    if building or (building is None and not quick):
        progress(f"{runner.title}: built anew")
        costs = build_costs(source.model, source.scene, {setting.companion for setting in settings})
    solution = find_reference(runner, names, file, progress, settings)
    measurement = Measurement(runner, solution, *(QUICK_REPEATS if quick else REPEATS), progress)
    lines = measurement.lines(settings, rtols, further)
    once = [line for line in lines if line.setting.correction == "step"]
    best = fastest(once, 1e-6) or fastest(once, 1e-3)
    # Those that most scenes take follow the fastest setting of the declared one.
    taken = dict.fromkeys([*([best.setting] if best else []), Setting("dop853"), Setting("auto")])

    def prepare(scene: "Scene") -> Runner:
        other = source.machine(scene)
        words = harness.arguments_of_variant(other, {**runner.words, **values})
        given = {name: words.pop(name, None) for name in ("guess", "start")}
        begin = other.assemble(parameters=words.get("parameters"), t=t_start, **given)
        return replace(runner, machine=other, begin=begin, words=words)

    sources = machine.description.sources
    return WorkPrecision(
        model=machine.model, scene=machine.scene, t_start=float(runner.begin.t),
        t_end=float(solution.t[-1]), instants=len(solution.t), quantities=solution.scales,
        energy=solution.energy, limit=limit, steps=steps, reference=solution.about, lines=lines,
        choices=tuple(
            measurement.choice(Choice(title, kind, other.name), partial(prepare, other), taken)
            for title, kind, other in others
        ),
        build=costs, environment=harness.environment(),
        model_sha256=sources[0][1] if sources else "",
        artefact=hashlib.sha256(machine.path.read_bytes()).hexdigest(),
    )  # fmt: skip


def _comparison(
    machine: Machine, quantities: Sequence[str], reference: Place | None,
    t_start: float, t_end: float | None, points: int,
) -> tuple[Sequence[str], FloatArray, ReferenceFile | None]:  # fmt: skip
    """The quantities that are compared, the instants in s, and the reference from a file."""
    description = machine.description
    require_motion(machine.mechanism, "accuracy")
    if not description.has_masses:
        refuse_massless(machine.mechanism)
    series = series_of(description, quantities)
    names = [text for k, text in enumerate(quantities) if series.index(series[k]) == k]
    if reference is None:
        end = harness.require_time_span(machine, "simulate", t_start, t_end)
        instants = np.linspace(t_start, end, points + 1)[1:]
        return names or default_quantities(description), instants, None
    file = read_reference(Path(reference), names, t_start, t_end)
    series_of(description, file.names)
    return file.names, file.t, file


@dataclass(frozen=True)
class Measurement:
    """A scene in every setting, and other models of it, compared with the reference and timed."""

    runner: Runner  # of the scene as declared
    reference: ReferenceSolution
    rounds: int  # of each run, as in `time_runs`
    least: float  # s, as in `time_runs`
    progress: Report

    def lines(
        self, settings: Sequence[Setting], rtols: Sequence[float], further: Sequence[float]
    ) -> tuple[Line, ...]:
        """Every setting at every tolerance; at `further` ones if it does not reach `ENOUGH`."""
        lines = list[Line]()
        for setting in settings:
            self.progress(f"{self.runner.title}: {setting.title}")
            try:
                points = tuple(self._points(self.runner, setting, rtols, further))
                lines.append(Line(setting, points))
            except LinkwrightError as error:
                lines.append(Line(setting, refused=" ".join(error.problems)))
        self.progress(f"{self.runner.title}: timing in turns")
        done = [(line.setting, point) for line in lines for point in line.done]
        timed = iter(self._timed(self.runner, done))
        return tuple(
            replace(line, points=tuple(next(timed) if x.errors else x for x in line.points))
            for line in lines
        )

    def choice(
        self, choice: Choice, prepare: Callable[[], Runner], settings: Iterable[Setting]
    ) -> Choice:
        """Another model of the scene, in the first setting in which it assembles and runs.

        Its point is the loosest run whose error is that of the model, as it is in all tighter runs;
        in looser ones that error and the run's own add up, or cancel.
        """
        self.progress(f"{self.runner.machine.model}/{choice.scene}")
        reasons = dict[str, None]()
        for setting in settings:
            try:
                runner = prepare()
                points = self._points(runner, setting, CHOICE_RTOLS)
            except LinkwrightError as error:
                reasons[" ".join(error.problems)] = None
                continue
            if points[-1].errors is None:
                reasons[f"{setting.title}: {points[-1].message}"] = None
                continue
            done, last = [point for point in points if point.errors], points[-1].worst
            other = [k for k, p in enumerate(done) if abs(p.worst - last) > _MODEL_ERROR * last]
            cheapest = done[other[-1] + 1 if other else 0]
            (point,) = self._timed(runner, [(setting, cheapest)])
            return replace(choice, setting=setting, point=point)
        return replace(choice, reason=" ".join(reasons))

    def _timed(self, runner: Runner, points: Sequence[tuple[Setting, Point]]) -> list[Point]:
        """The points of runs to the end, with their times."""
        runs = [partial(runner.seconds, setting, point.rtol) for setting, point in points]
        first = [point.seconds for _, point in points]
        timed = harness.time_runs(runs, first, self.rounds, self.least)
        return [
            replace(point, seconds=min(times), spread=median(times) / min(times), runs=len(times))
            for (_, point), times in zip(points, timed, strict=True)
        ]

    def _points(
        self, runner: Runner, setting: Setting, rtols: Sequence[float],
        further: Sequence[float] = (),
    ) -> list[Point]:  # fmt: skip
        """Runs against the reference, with the time of a first run; a failed one until then."""
        points: list[Point] = []
        for rtol in (*sorted(rtols, reverse=True), *further):
            if rtol in further and not points[-1].worst > ENOUGH:
                break
            last = [point.outcome for point in points[-GIVEN_UP:]]
            if len(last) == GIVEN_UP and {*last} <= {TIMEOUT, "NOT_TRIED"}:
                why = "Looser tolerances met the limit of time."
                points.append(Point(rtol, "NOT_TRIED", why))
            else:
                points.append(self._point(runner.run(setting, rtol), rtol))
        return points

    def _point(self, result: Result, rtol: float) -> Point:
        counts = {name: float(x) for name, x in result.stats.items() if "seconds" not in name}
        point = Point(
            rtol, outcome_name(result), result.message, counts=counts, spread=1.0, runs=1,
            seconds=result.stats[TIME],
        )  # fmt: skip
        if result.failed:
            return point
        reference = self.reference
        if different := reference.difference(result):
            return replace(point, outcome="OTHER_END", message=different)
        errors = reference.errors(reference.values(result))
        position, velocity = result.samples.residual.max(axis=0)[:2].tolist()
        return replace(
            point, errors=errors, beyond=errors.worst < reference.about.floor,
            position_residual=position / reference.length,
            velocity_residual=velocity / reference.speed, energy=reference.energy_error(result),
        )  # fmt: skip


def build_costs(
    model: "Model", scene: "Scene", companions: Collection[str] = ("tangents", "reduced")
) -> dict[str, float]:
    """Stage → wall-clock seconds, in order, from the declared model on.

    Companion modules (derivatives, which implicit methods take, and reduced equations) have stages
    of their own, which follow where the scene has them; files are compiled concurrently.
    """
    from codegen import build
    from codegen.files.generated_modules import import_generated

    with TemporaryDirectory() as folder:
        out, tangents, reduced = Path(folder), "tangents" in companions, "reduced" in companions
        try:
            report = build(model, scene, out, tangents=tangents, reduced=reduced).scenes[0]
        except SceneError:  # a scene without reduced equations: sticking by the force of a reaction
            if not reduced:
                raise
            report = build(model, scene, out, tangents=tangents).scenes[0]
        seconds = {stage: time for stage, time in report.seconds.items() if stage != "read"}
        for companion in report.companions:
            seconds |= {
                stage if stage != "compile" else f"compile {companion.title}": time
                for stage, time in companion.seconds.items()
            }
        del sys.modules[import_generated(report.path).__name__]  # as in a new process
        began = perf_counter()
        import_generated(report.path)
        return seconds | {"load, warm": perf_counter() - began}
