"""A work-precision study of one scene: every setting, every tolerance, its error and its time."""

import hashlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import AnalysisError, InputError, SceneError
from codegen.readers import arguments as readers
from runtime.integrate.method import METHODS
from runtime.machine_facade import Machine
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.table_rows import unknown
from runtime.results.assembled_state import Assembly
from runtime.studies import harness
from runtime.studies.harness import (
    FORMULATIONS,
    Runner,
    Setting,
    all_settings,
    read_simulation_arguments,
    takes_simulation_arguments,
)
from runtime.studies.timing import environment
from runtime.studies.work_precision.diagram import Choice, Line, WorkPrecision
from runtime.studies.work_precision.interpretation import fastest
from runtime.studies.work_precision.measurement import Measurement
from runtime.studies.work_precision.reference import (
    LIMIT_FACTOR,
    TIGHTEST,
    ReferenceFile,
    default_quantities,
    distinct_quantities,
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

_LOAD = """
import sys, pathlib, time
import numba
from codegen.files.generated_modules import import_generated
began = time.perf_counter()
import_generated(pathlib.Path(sys.argv[1]))
sys.stdout.write(repr(time.perf_counter() - began))
"""


@readers.reads(
    **harness.READERS, quantities=readers.texts('("crank.phi",)'),
    methods=readers.texts('("dop853",)'), formulations=readers.texts('("cartesian",)'),
    rtols=readers.optional(readers.several(readers.number("a number"), "a sequence of numbers")),
    reference=readers.optional(readers.path),
    beside=readers.several(readers.scene, "a sequence of scenes, by name or as a Scene"),
    building=readers.optional(readers.flag), points=readers.count(-(2**62)),
    limit=readers.number("a finite number of seconds"), steps=readers.count(-(2**62)),
    **dict.fromkeys(("modelling", "quick"), readers.flag),
)  # fmt: skip
@takes_simulation_arguments("correction")
def accuracy(
    model: "str | os.PathLike[str] | Model", scene: "str | Scene | None" = None, *,
    quantities: Sequence[str] = (), t_end: float | None = None, t_start: float = 0.0,
    methods: Sequence[str] = METHODS, formulations: Sequence[str] = FORMULATIONS,
    rtols: Sequence[float] | None = None, points: int = 200,
    reference: str | os.PathLike[str] | None = None, modelling: bool = True,
    beside: "Sequence[str | Scene]" = (), building: bool | None = None, quick: bool = False,
    limit: float = 10.0, steps: int = 1_000_000, parameters: Mapping[str, float] | None = None,
    guess: Mapping[str, float] | None = None, start: Mapping[str, float] | None = None,
    folder: str | os.PathLike[str] | None = None, generated: str | os.PathLike[str] | None = None,
    progress: Callable[[str], None] = lambda line: None, **run: Any,
) -> WorkPrecision:  # fmt: skip
    """The work-precision diagram of a scene: digits against time, by every method.

    Parameters
    ----------
    model, scene, folder, generated, parameters, guess, start
        As in `load` and the analyses, `start` by name. Undeclared scenes are compiled in
        `.linkwright_cache`.
    quantities
        Series that are compared, as `Result.series` names them; unless given, the coordinates from
        which the scene starts and their velocities. ``a.x|b.x`` is whichever of them a scene has,
        where modelling choices have bodies of other names.
    t_end, t_start
        Of the run, s. A reference from a file ends it where no end is given.
    methods, formulations
        As in `simulate`; each with each. With "dop853" in all coordinates, correction at every
        stage and projection are tried as well.
    rtols
        Relative tolerances, 1e-12 at least; unless given, two a decade from 1e-2 to 1e-10, and on
        to 1e-12 for settings that need them for nine digits. Absolute ones follow as in `simulate`.
    points
        Instants at which runs are compared, equally spaced, the start not among them.
    reference
        A .csv file with columns t, in s, and the quantities, to compare with at its instants.
        Without one, a run of one method at 1e-13 that other methods confirm.
    modelling, beside
        Whether the scene is also run with each other fidelity of things that have several. Further
        scenes of the model that stand for the same machine, compared in the same way.
    building
        Whether the scene is built anew and each stage timed, with the companion modules that the
        methods and formulations take; by default unless `quick`: four tolerances, few runs a time.
    limit, steps
        Time in s and steps that a run may take; a reference may take more.
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
    further = FURTHER if rtols is None and not quick else ()
    rtols = (QUICK if quick else RTOLS) if rtols is None else rtols
    _check(methods, formulations, rtols, points, limit, steps)
    source = harness.read_source(model, scene, folder, generated)
    machine = source.machine()
    names, instants, file = _comparison(machine, quantities, reference, t_start, t_end, points)
    others = _other_models(source, modelling, beside)
    given = guess or {}, start or {}
    begin = _assemble_with_freedom(machine, *given, parameters, t_start)
    words = read_simulation_arguments(machine, run)
    values = dict(parameters or {})
    runner = Runner(machine, begin, instants, values, float(limit), int(steps), words)
    progress(
        f"{runner.title}: at most {limit:g} s and {steps:g} steps per run, "
        f"{LIMIT_FACTOR * limit:g} s for a reference"
    )
    settings, costs = all_settings(methods, formulations), {}
    if building or (building is None and not quick):
        progress(f"{runner.title}: built anew")
        costs = build_costs(source.model, source.scene, {setting.companion for setting in settings})
    solution = find_reference(runner, names, file, progress, settings)
    measurement = Measurement(runner, solution, *(QUICK_REPEATS if quick else REPEATS), progress)
    lines = measurement.lines(settings, rtols, further)
    return WorkPrecision(
        model=machine.model, scene=machine.scene, t_start=float(begin.t),
        t_end=float(solution.places.t[-1]), instants=len(solution.places.t),
        quantities=solution.scales, energy=solution.energy,
        limit=runner.limit, steps=runner.steps, lines=lines, build=costs, environment=environment(),
        choices=_choices(others, source, *given, measurement, lines), reference=solution.about,
        model_sha256=machine.description.sources[0][1] if machine.description.sources else "",
        artefact=hashlib.sha256(machine.path.read_bytes()).hexdigest(),
    )  # fmt: skip


def _assemble_with_freedom(
    machine: Machine, guess: Mapping[str, float], start: Mapping[str, float],
    parameters: Mapping[str, float] | None, t: float,
) -> Assembly:  # fmt: skip
    """The assembled start of a motion; AnalysisError where drivers leave no freedom."""
    begin = machine.assemble(guess, parameters, t, start=start)
    if begin.is_determined:
        raise AnalysisError(
            f"{machine.description.title}: drivers leave no freedom, so nothing is integrated, and "
            "accuracy is that of Newton's method. Choose a scene that forces move."
        )
    return begin


def _comparison(
    machine: Machine, quantities: Sequence[str], reference: str | os.PathLike[str] | None,
    t_start: float, t_end: float | None, points: int,
) -> tuple[tuple[str, ...], FloatArray, ReferenceFile | None]:  # fmt: skip
    """The quantities that are compared, the instants in s, and the reference from a file."""
    description = machine.description
    require_motion(machine.mechanism, "accuracy")
    if not description.has_masses:
        refuse_massless(machine.mechanism)
    names = distinct_quantities(description, quantities)
    if reference is None:
        end = harness.require_time_span(machine, t_start, t_end)
        names = names or default_quantities(description)
        return names, np.linspace(t_start, end, points + 1)[1:], None
    file = read_reference(Path(reference), names, t_start, t_end)
    series_of(description, file.names)
    return file.names, file.t, file


def _other_models(
    source: harness.Source, modelling: bool, beside: "Sequence[str | Scene]"
) -> "list[tuple[Choice, Scene]]":
    """Scenes of the same machine: other fidelities of things that have several, and those named."""
    from codegen.reading.scene_selection import declared, variants

    others = []
    for change in variants(source.model, source.scene) if modelling else ():
        if change.word != harness.LEFT_OUT:
            scene = change.of(source.scene)
            others.append((Choice(change.title, change.kind, scene.name), scene))
    named = [declared(source.model, scene)[1] for scene in beside]
    return others + [(Choice(scene.name, "scene", scene.name), scene) for scene in named]


def _choices(
    others: "Sequence[tuple[Choice, Scene]]", source: harness.Source,
    guess: Mapping[str, float], start: Mapping[str, float], measurement: Measurement,
    lines: Sequence[Line],
) -> tuple[Choice, ...]:  # fmt: skip
    """Other models, in the fastest setting of the declared one, or those that most scenes take."""
    once = [line for line in lines if line.setting.correction == "step"]
    best = fastest(once, 1e-6) or fastest(once, 1e-3)
    first = [best.line.setting] if best else []
    settings = tuple(dict.fromkeys([*first, Setting("dop853"), Setting("auto")]))
    runner = measurement.runner

    def prepare(scene: "Scene") -> Runner:
        machine = source.machine(scene)
        values = harness.known_values(machine, runner.parameters, guess, start)
        begin = machine.assemble(**values, t=runner.begin.t)
        return replace(runner, machine=machine, begin=begin, parameters=values["parameters"])

    return tuple(
        measurement.choice(choice, partial(prepare, scene), settings) for choice, scene in others
    )


def _check(
    methods: Sequence[str], formulations: Sequence[str], rtols: Sequence[float], points: int,
    limit: float, steps: int,
) -> None:  # fmt: skip
    """Refuse arguments that make no study, all at once."""
    names = {"method": methods, "formulation": formulations}
    problems = []
    for thing, known in (("method", METHODS), ("formulation", FORMULATIONS)):
        problems += [unknown(thing, name, known) for name in names[thing] if name not in known]
    for thing, values in (("method", methods), ("formulation", formulations), ("rtol", rtols)):
        if not values:
            problems.append(f"There is no {thing} to try; name one, or leave the argument out.")
    problems += [
        f"rtol is {rtol:g}; it lies from {LEAST_RTOL:g} to 0.1, so that the reference, at "
        f"{TIGHTEST:g}, is better."
        for rtol in rtols
        if not LEAST_RTOL <= rtol <= 0.1
    ]
    if points < 2:
        problems.append(f"points is {points}; runs are compared at 2 or more instants.")
    if not limit > 0.0:
        problems.append(f"limit is {limit:g}; a run may take a positive time, in s.")
    if steps < 1:
        problems.append(f"steps is {steps}; a run takes at least one step.")
    if problems:
        raise InputError(problems)


def build_costs(
    model: "Model", scene: "Scene", companions: Collection[str] = ("tangents", "reduced")
) -> dict[str, float]:
    """Stage → wall-clock seconds, in order, from the declared model on.

    Companion modules (derivatives, which implicit methods take, and reduced equations) have stages
    of their own, which follow where the scene has them; files are compiled concurrently.
    """
    from codegen import build

    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "generated"
        tangents, reduced = "tangents" in companions, "reduced" in companions
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
        return seconds | {"load, warm": _warm_load(report.path)}


def _warm_load(path: Path) -> float:
    root = Path(__file__).resolve().parents[3]
    paths = os.pathsep.join(filter(None, [str(root), os.environ.get("PYTHONPATH")]))
    environment = {**os.environ, "PYTHONPATH": paths}
    command = [sys.executable, "-P", "-c", _LOAD, str(path)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)
