"""A work-precision study of one scene: every setting, every tolerance, and what it takes."""

import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError, InputError
from runtime.integrate.method import METHODS
from runtime.studies.effect_ranking.trial_run import Plan
from runtime.studies.variant_builds import loaded
from runtime.studies.work_precision.build_costs import build_costs
from runtime.studies.work_precision.compared_quantities import (
    Given,
    default_names,
    distinct,
    named,
    read_reference,
)
from runtime.studies.work_precision.diagram import Choice, Line, Setting, WorkPrecision
from runtime.studies.work_precision.environment import environment
from runtime.studies.work_precision.interpretation import time_at
from runtime.studies.work_precision.measurement import lines
from runtime.studies.work_precision.modelling_choices import alternatives, choices
from runtime.studies.work_precision.reference_solution import PATIENCE, find_truth
from runtime.studies.work_precision.settings_grid import (
    FORMULATIONS,
    FURTHER,
    QUICK,
    RTOLS,
    check_grid,
    check_sequences,
    settings,
)
from runtime.studies.work_precision.timed_runs import Runner
from runtime.validation.scene_support import refuse_massless, require_motion

if TYPE_CHECKING:
    from codegen import Model, Scene
    from runtime.machine import Machine

FloatArray = npt.NDArray[np.float64]
ROUNDS, SECONDS = 5, 0.1
"""Runs by which a time is taken at least, and their time in s."""
QUICK_ROUNDS, QUICK_SECONDS = 3, 0.01


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
    """What the accuracy of a scene's motion costs: digits against time, by every method.

    Parameters
    ----------
    model, scene
        As in `load`.
    quantities
        Series that are compared, as `Result.series` names them; unless given, the coordinates from
        which the scene starts and their velocities. ``a.x|b.x`` is the one that a scene has, where
        modelling choices have bodies of other names.
    t_end, t_start
        Of the run, s. A reference from a file ends it where no end is given.
    methods, formulations
        As in `simulate`; each with each. With "dop853" in all coordinates correction at every stage
        and projection are tried as well.
    rtols
        Relative tolerances, 1e-12 at least; unless given, two a decade from 1e-2 to 1e-10, and on
        to 1e-12 for settings that need them for nine digits. Absolute ones follow from them as in
        `simulate`.
    points
        Instants at which runs are compared, equally spaced, the start not among them.
    reference
        A .csv file with columns t, in s, and the quantities, to compare with at its instants.
        Without one, a run of one method at 1e-13 that other methods confirm.
    modelling
        Whether the scene is also run with another fidelity of each thing that has several.
    beside
        Further scenes of the model that stand for the same machine, judged in the same way.
    building
        Whether the scene is built anew, to tell what that takes; not if `quick`, unless given. Only
        files that a method and formulation take are built.
    quick
        Four tolerances, and few runs a time.
    limit, steps
        Time in s and steps that a run may take; a reference may take more.
    parameters, guess
        As in the analyses.
    folder
        As in `load`. Scenes that nobody declared are compiled in its `.linkwright_cache`.
    progress
        Receives a line before every step that takes time.

    Raises
    ------
    InputError
        If anything that was given is none, or nothing is integrated in the scene.
    LinkwrightError
        If no reference can be had.
    """
    from codegen.scene_variants import declared

    tolerances = tuple(rtols) if rtols is not None else QUICK if quick else RTOLS
    further = () if quick or rtols is not None else FURTHER
    check_sequences(
        quantities=quantities, methods=methods, formulations=formulations, beside=beside
    )
    check_grid(methods, formulations, tolerances, points, limit, steps)
    found = declared(model if not isinstance(model, os.PathLike) else Path(model), scene)
    machine = loaded(model, scene, found, folder)
    _require_integration(machine)
    told = machine.description
    quantities = distinct(told, quantities)
    given = (
        None if reference is None else _given(machine, Path(reference), quantities, t_start, t_end)
    )
    names = given.names if given is not None else quantities or default_names(told)
    named(told, names)
    alternatives(*found, modelling, beside)
    instants = _instants(machine, t_start, t_end, points) if given is None else given.t
    values = dict(parameters or {})
    begin = machine.assemble(guess, values, t_start)
    if begin.degrees_of_freedom == 0:
        raise AnalysisError(
            f"{told.title}: drivers leave no freedom, so nothing is integrated, and accuracy is "
            "that of Newton's method. Choose a scene that forces move."
        )
    runner = Runner(machine, begin, instants, values, float(limit), int(steps))
    progress(
        f"{told.title}: at most {limit:g} s and {steps:g} steps a run, {PATIENCE * limit:g} s for "
        "a reference"
    )
    tried = settings(tuple(methods), tuple(formulations))
    costs = {}
    if building if building is not None else not quick:
        progress(f"{told.title}: built anew")
        costs = build_costs(*found, {setting.companion for setting in tried})
    truth = find_truth(runner, names, given, progress, tried)
    rounds, least = (QUICK_ROUNDS, QUICK_SECONDS) if quick else (ROUNDS, SECONDS)
    made = lines(runner, truth, tried, tolerances, further, rounds, least, progress)
    others: tuple[Choice, ...] = ()

    def another(other: "Scene") -> "Machine":
        named = other.name if other.root is None else other
        return loaded(model, named, (found[0], other), folder)

    if modelling or beside:
        plan = Plan(
            "simulate", float(t_start), float(instants[-1]), points, min(tolerances),
            methods[0], values, dict(guess or {}),
        )  # fmt: skip
        others = choices(
            alternatives(*found, modelling, beside), another, runner, plan, truth,
            _for_choices(made), rounds, least, progress,
        )  # fmt: skip
    return WorkPrecision(
        told.model, told.scene, float(t_start), float(instants[-1]), len(instants), truth.scales,
        truth.energy, float(limit), int(steps), truth.reference, made, others, costs,
        environment(), told.sources[0][1] if told.sources else "",
        hashlib.sha256(machine.path.read_bytes()).hexdigest(),
    )  # fmt: skip


def _for_choices(made: Sequence[Line]) -> tuple[Setting, ...]:
    """Settings for other models: the fastest first, then those that bear most."""
    first: list[Setting] = []
    for target in (1e-3, 1e-6):
        times = [
            (seconds, k)
            for k, line in enumerate(made)
            if line.setting.correction == "step" and (seconds := time_at(line, target)) is not None
        ]
        first = [made[min(times)[1]].setting] if times else first
    return tuple(dict.fromkeys([*first, Setting("dop853"), Setting("auto")]))


def _require_integration(machine: "Machine") -> None:
    require_motion(machine.mechanism, "accuracy")
    if not machine.description.has_masses:
        refuse_massless(machine.mechanism)


def _given(
    machine: "Machine",
    path: Path,
    quantities: Sequence[str],
    t_start: float,
    t_end: float | None,
) -> Given:
    """The reference that a file holds, up to the end that is asked for."""
    given = read_reference(path, quantities, t_start)
    if t_end is None:
        return given
    if t_end > given.t[-1]:
        raise InputError(
            f"--reference {path}: it ends at t = {given.t[-1]:g} s, before {t_end:g} s."
        )
    return given.until(t_end)


def _instants(machine: "Machine", t_start: float, t_end: float | None, points: int) -> FloatArray:
    """Equally spaced, the start not among them."""
    title = machine.description.title
    if t_end is None:
        raise AnalysisError(f"{title}: t_end is missing; give the last instant in s (--t-end).")
    if not t_start < t_end < float("inf"):
        raise AnalysisError(
            f"{title}: the time span from {t_start:g} to {t_end:g} s must be finite and positive."
        )
    return np.linspace(t_start, t_end, points + 1)[1:]
