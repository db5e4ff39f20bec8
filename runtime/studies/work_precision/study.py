"""A work-precision study of one scene: every setting, every tolerance, its error and its time."""

import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError
from runtime.integrate.method import METHODS
from runtime.studies.scenes import known_guess, known_parameters, read_source, require_time_span
from runtime.studies.work_precision.build_costs import build_costs
from runtime.studies.work_precision.compared_quantities import (
    ReferenceFile,
    default_quantities,
    distinct_quantities,
    read_reference,
    series_of,
)
from runtime.studies.work_precision.diagram import Choice, Line, Setting, WorkPrecision
from runtime.studies.work_precision.interpretation import time_at
from runtime.studies.work_precision.json_records import environment
from runtime.studies.work_precision.measurement import Measurement
from runtime.studies.work_precision.modelling_choices import alternatives, measure_choices
from runtime.studies.work_precision.reference_solution import (
    LIMIT_FACTOR,
    ReferenceSolution,
    find_reference,
)
from runtime.studies.work_precision.settings_grid import (
    FORMULATIONS,
    FURTHER,
    QUICK,
    RTOLS,
    all_settings,
    check_grid,
    check_sequences,
)
from runtime.studies.work_precision.timed_runs import Runner
from runtime.validation.scene_support import refuse_massless, require_motion

if TYPE_CHECKING:
    from codegen import Model, Scene
    from runtime.machine import Machine
    from runtime.results.assembled_state import Assembly

FloatArray = npt.NDArray[np.float64]

ROUNDS, SECONDS = 5, 0.1  # measured: least number of timed runs of a setting, and their time in s
QUICK_ROUNDS, QUICK_SECONDS = 3, 0.01  # measured: the same of a quick study


def accuracy(
    model: "str | os.PathLike[str] | Model",
    scene: "str | Scene | None" = None,
    *,
    quantities: Sequence[str] = (),
    t_end: float | None = None,
    t_start: float = 0.0,
    methods: Sequence[str] = METHODS,
    formulations: Sequence[str] = FORMULATIONS,
    rtols: Sequence[float] | None = None,
    points: int = 200,
    reference: str | os.PathLike[str] | None = None,
    modelling: bool = True,
    beside: "Sequence[str | Scene]" = (),
    building: bool | None = None,
    quick: bool = False,
    limit: float = 10.0,
    steps: int = 1_000_000,
    parameters: Mapping[str, float] | None = None,
    guess: Mapping[str, float] | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Callable[[str], None] = lambda line: None,
) -> WorkPrecision:
    """The work-precision diagram of a scene: digits against time, by every method.

    Parameters
    ----------
    model, scene, folder
        As in `load`. Undeclared scenes are compiled in the folder's `.linkwright_cache`.
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
        to 1e-12 for settings that need them for nine digits. Absolute tolerances follow from them
        as in `simulate`.
    points
        Instants at which runs are compared, equally spaced, the start not among them.
    reference
        A .csv file with columns t, in s, and the quantities, to compare with at its instants.
        Without one, a run of one method at 1e-13 that other methods confirm.
    modelling
        Whether the scene is also run with each other fidelity of things that have several.
    beside
        Further scenes of the model that stand for the same machine, compared in the same way.
    building
        Whether the scene is built anew and each stage timed, with the companion modules that the
        methods and formulations take; by default unless `quick`.
    quick
        Four tolerances, and few runs a time.
    limit, steps
        Time in s and steps that a run may take; a reference may take more.
    parameters, guess
        As in the analyses.
    progress
        Receives a line before every step that takes time.

    Raises
    ------
    InputError
        If an argument is invalid, or nothing is integrated in the scene.
    LinkwrightError
        If no reference can be computed.
    """
    rtols, further = (QUICK if quick else RTOLS, FURTHER) if rtols is None else (tuple(rtols), ())
    check_sequences(
        quantities=quantities, methods=methods, formulations=formulations, beside=beside
    )
    check_grid(methods, formulations, rtols, points, limit, steps)
    source = read_source(model, scene, folder)
    machine = source.machine()
    path = None if reference is None else Path(reference)
    names, instants, file = _comparison(machine, quantities, path, t_start, t_end, points)
    others = alternatives(source.model, source.scene, modelling, beside)
    values = dict(parameters or {})
    begin = _start(machine, guess, values, t_start)
    runner = Runner(machine, begin, instants, values, float(limit), int(steps))
    progress(
        f"{machine.description.title}: at most {limit:g} s and {steps:g} steps per run, "
        f"{LIMIT_FACTOR * limit:g} s for a reference"
    )
    settings = all_settings(tuple(methods), tuple(formulations))
    costs = {}
    if building or (building is None and not quick):
        progress(f"{machine.description.title}: built anew")
        companions = {setting.companion for setting in settings}
        costs = build_costs(source.model, source.scene, companions)
    solution = find_reference(runner, names, file, progress, settings)
    repeats = (QUICK_ROUNDS, QUICK_SECONDS) if quick else (ROUNDS, SECONDS)
    measurement = Measurement(runner, solution, *repeats, progress)
    lines = measurement.lines(settings, rtols, () if quick else further)

    def prepare(scene: "Scene") -> Runner:
        other = source.other(scene)
        own = known_parameters(other, values)
        begin = other.assemble(known_guess(other, guess or {}), own, float(t_start))
        return replace(runner, machine=other, begin=begin, parameters=own)

    choices = measure_choices(measurement, others, prepare, _settings_of_choices(lines))
    return _answer(runner, solution, lines, choices, costs)


def _comparison(
    machine: "Machine",
    quantities: Sequence[str],
    reference: Path | None,
    t_start: float,
    t_end: float | None,
    points: int,
) -> tuple[tuple[str, ...], FloatArray, ReferenceFile | None]:
    """The quantities that are compared, the instants in s, and the reference from a file."""
    description = machine.description
    require_motion(machine.mechanism, "accuracy")
    if not description.has_masses:
        refuse_massless(machine.mechanism)
    names = distinct_quantities(description, quantities)
    if reference is None:
        end = require_time_span(machine, t_start, t_end)
        return (
            names or default_quantities(description),
            np.linspace(t_start, end, points + 1)[1:],
            None,
        )
    file = read_reference(reference, names, t_start, t_end)
    series_of(description, file.names)
    return file.names, file.t, file


def _start(
    machine: "Machine",
    guess: Mapping[str, float] | None,
    parameters: Mapping[str, float],
    t_start: float,
) -> "Assembly":
    begin = machine.assemble(guess, parameters, t_start)
    if begin.degrees_of_freedom == 0:
        raise AnalysisError(
            f"{machine.description.title}: drivers leave no freedom, so nothing is integrated, and "
            "accuracy is that of Newton's method. Choose a scene that forces move."
        )
    return begin


def _answer(
    runner: Runner,
    solution: ReferenceSolution,
    lines: tuple[Line, ...],
    choices: tuple[Choice, ...],
    costs: dict[str, float],
) -> WorkPrecision:
    description = runner.machine.description
    return WorkPrecision(
        model=description.model,
        scene=description.scene,
        t_start=float(runner.begin.t),
        t_end=float(runner.instants[-1]),
        instants=len(runner.instants),
        quantities=solution.scales,
        energy=solution.energy,
        limit=runner.limit,
        steps=runner.steps,
        reference=solution.about,
        lines=lines,
        choices=choices,
        build=costs,
        environment=environment(),
        model_sha256=description.sources[0][1] if description.sources else "",
        artefact=hashlib.sha256(runner.machine.path.read_bytes()).hexdigest(),
    )


def _settings_of_choices(lines: Sequence[Line]) -> tuple[Setting, ...]:
    """Settings for other models: the fastest first, then those that most scenes can take."""
    first: list[Setting] = []
    for target in (1e-3, 1e-6):
        times = [
            (seconds, k)
            for k, line in enumerate(lines)
            if line.setting.correction == "step" and (seconds := time_at(line, target)) is not None
        ]
        first = [lines[min(times)[1]].setting] if times else first
    return tuple(dict.fromkeys([*first, Setting("dop853"), Setting("auto")]))
