"""Effect ranking: the scene in full, then without each effect in turn, compared and timed."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, TypeVar

from codegen.errors import InputError, LinkwrightError
from runtime.machine import Machine
from runtime.studies.effect_ranking import scene_trial
from runtime.studies.effect_ranking.comparison_and_proposal import Comparison, propose_scene
from runtime.studies.effect_ranking.quantity import Function, Quantity, parse_quantity
from runtime.studies.effect_ranking.ranking import Matters, Proposal, Row, Verdict
from runtime.studies.effect_ranking.scene_trial import Plan, Trial, TrialError, run_trial
from runtime.studies.scene_loading import (
    LEFT_OUT,
    Source,
    cache_folder,
    read_source,
    require_time_span,
)
from runtime.studies.timing import Stopwatch, take_turns

if TYPE_CHECKING:
    from codegen import Model, Scene
    from codegen.one_change_scenes import Variant

LEAST_ROUNDS, MOST_ROUNDS = 5, 40  # measured: rounds of timed runs, however long or short these are
SECONDS = 3.0  # measured: wall-clock time for all rounds

Timed = TypeVar("Timed", Row, Proposal)


def matters(
    model: "str | os.PathLike[str] | Model", scene: "str | Scene | None" = None, *,
    asked: str | Function, t_end: float | None = None, t_start: float = 0.0,
    error: float | None = None, analysis: str | None = None, fidelities: bool = True,
    parameters: Mapping[str, float] | None = None, guess: Mapping[str, float] | None = None,
    method: str = "dop853", rtol: float = 1e-10, points: int = 1001, rounds: int | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Callable[[str], None] = lambda line: None,
) -> Matters:  # fmt: skip
    """Rank the effects of a scene by their influence on a quantity.

    Parameters
    ----------
    model, scene, folder
        As in `load`. Undeclared scenes are compiled in the folder's `.linkwright_cache`.
    asked
        The quantity: a text (`runtime.studies.effect_ranking.quantity`) or a function of a result.
    t_end, t_start
        Of the run, s; an equilibrium needs none.
    error
        The largest relative change that is permitted; with it a cheaper scene is proposed.
    analysis
        "simulate", "kinematics", "inverse" or "equilibrium"; unless given, it follows from the
        scene: inverse dynamics where drivers leave no freedom, else simulation.
    fidelities
        Whether the other fidelities of things that have several are tried as well.
    parameters, guess
        As in the analyses; a variant without the thing that a value belongs to ignores it.
    method, rtol
        Of a simulation; a second one with 100 `rtol` shows how far it can be trusted.
    points
        Output instants of a timed run.
    rounds
        Timed runs of each scene, of which the least time counts; as many as three seconds allow
        unless given.
    progress
        Receives a line before every step that takes time.

    Raises
    ------
    InputError
        If the quantity or another argument is invalid, or there is no effect to leave out.
    LinkwrightError
        If the full scene does not run to its end.
    """
    quantity = parse_quantity(asked)
    _check(error, rtol, points, rounds, analysis)
    source = read_source(model, scene, folder)
    changes = _changes(source, fidelities)
    cache_folder(folder)  # refused now if it cannot be written
    title = f"{source.model.name}/{source.scene.name}"
    progress(f"{title}: the full scene")
    machine = source.machine()
    machine.parameter_values(parameters)  # a name that the full scene does not know is a mistake
    kind = analysis or _analysis_of(machine)
    end = t_start if kind == "equilibrium" else require_time_span(machine, t_start, t_end)
    values = dict(parameters or {}), dict(guess or {})
    plan = Plan(kind, float(t_start), float(end), points, rtol, method, *values)
    full = _full_trial(machine, plan, quantity)
    comparison = Comparison(source, plan, quantity, full, error, progress)
    rows = [comparison.row(change) for change in changes]
    proposal, best = None, None
    if error is not None:
        judged = [(row, change) for (row, _), change in zip(rows, changes, strict=True)]
        proposal, best = propose_scene(comparison, judged)
    progress(f"{title}: timing in turns")
    trials = [trial for trial in (full, *(trial for _, trial in rows), best) if trial is not None]
    seconds = _time([plan.stopwatch(trial.machine) for trial in trials], rounds)
    return _answer(comparison, changes, [row for row, _ in rows], proposal, seconds)


def _answer(
    comparison: Comparison, changes: "tuple[Variant, ...]", rows: Sequence[Row],
    proposal: Proposal | None, times: Sequence[float],
) -> Matters:  # fmt: skip
    """The ranking, with the times of the full scene, of the rows that ran and of the proposal."""
    full, seconds = comparison.full, iter(times)
    costs = replace(full.costs, seconds=next(seconds))

    def timed(answer: Timed) -> Timed:
        if answer.costs is None:
            return answer
        own = replace(answer.costs, seconds=next(seconds))
        return replace(answer, costs=own, time_share=1.0 - own.seconds / costs.seconds)

    return Matters(
        model=comparison.source.model.name, scene=comparison.source.scene.name,
        analysis=comparison.plan.analysis, quantity=comparison.quantity.text,
        value=full.quantity.value, unit=full.quantity.unit, size=comparison.size, doubt=full.doubt,
        costs=costs, rows=tuple(sorted([timed(row) for row in rows], key=_rank)),
        error=comparison.error, proposal=None if proposal is None else timed(proposal),
        notes=tuple(_notes(changes, full, comparison.size, comparison.error)),
    )  # fmt: skip


def _changes(source: Source, fidelities: bool) -> "tuple[Variant, ...]":
    """Everything that can be left out of the scene, or taken in another fidelity."""
    from codegen.one_change_scenes import variants

    changes = variants(source.model, source.scene, fidelities=fidelities)
    if not changes:
        why = "a kinematic scene has no forces" if source.scene.effects else "no effect acts"
        raise InputError(
            f"{source.model.name}/{source.scene.name}: {why}, and nothing in it has another "
            "fidelity, so there is nothing to leave out. Choose another scene of the model, or add "
            "effects."
        )
    return changes


def _full_trial(machine: Machine, plan: Plan, quantity: Quantity) -> Trial:
    """The trial of the full scene; a failure is the user's."""
    if plan.guess:
        machine.assemble(guess=plan.guess, parameters=plan.parameters, t=plan.t_start)
    try:
        return run_trial(machine, plan, quantity)
    except TrialError as error:
        cause = error.__cause__
        raise (cause if isinstance(cause, InputError) else LinkwrightError(str(error))) from None


def _time(watches: Sequence[Stopwatch], rounds: int | None) -> list[float]:
    """Least processor time in s of each run, in `rounds` turns or as many as `SECONDS` allow."""
    started = perf_counter()

    def finished(watch: Stopwatch) -> bool:
        count = len(watch.times)
        if rounds is not None:
            return count >= rounds
        return count >= MOST_ROUNDS or (
            count >= LEAST_ROUNDS and perf_counter() - started > SECONDS
        )

    take_turns(watches, finished)
    return [watch.seconds for watch in watches]


def _rank(row: Row) -> tuple[bool, bool, float]:
    """Needed and impossible first, then by change; changes below their uncertainty last."""
    return row.change is not None, row.verdict is Verdict.NONE_SEEN, -(row.relative or 0.0)


def _notes(
    changes: "tuple[Variant, ...]", full: Trial, size: float, error: float | None
) -> list[str]:
    notes = []
    effects = [change for change in changes if change.word == LEFT_OUT]
    if len(effects) == 1:
        notes.append(
            f"{effects[0].name} is the only effect of the scene, so there is none to rank it with."
        )
    if not size:
        notes.append("The quantity is zero throughout, so a relative change is not defined.")
    elif size != abs(full.quantity.value):
        unit = f" {full.quantity.unit}" if full.quantity.unit else ""
        notes.append(
            "The quantity is zero within its uncertainty, so changes are relative to "
            f"{size:.4g}{unit}, the largest magnitude during the run."
        )
    if error is not None and size and full.doubt > 0.1 * error * size:
        notes.append(
            f"The quantity is known to {full.doubt / size:.1e} only, which is "
            f"{'more' if full.doubt > error * size else 'not much less'} than the permitted error "
            f"of {error:g}: lower rtol, give more points, or end the run earlier."
        )
    return notes


def _analysis_of(machine: Machine) -> str:
    """The analysis that a scene is meant for."""
    description = machine.description
    if description.analysis == "equilibrium":
        return "equilibrium"
    if description.drivers and machine.degrees_of_freedom == 0:
        return "inverse" if description.has_masses else "kinematics"
    return "simulate"


def _check(
    error: float | None, rtol: float, points: int, rounds: int | None, analysis: str | None
) -> None:
    """Refuse arguments that make no comparison, all at once."""
    problems = []
    if error is not None and not 0.0 < error < 1.0:
        problems.append(f"error is {error:g}; it is a share of the quantity, between 0 and 1.")
    if not scene_trial.LEAST_RTOL <= rtol <= 1e-4:
        least = scene_trial.LEAST_RTOL
        problems.append(f"rtol is {rtol:g}; to compare runs it lies from {least:g} to 1e-4.")
    if points < 11:
        problems.append(f"points is {points}; a quantity is taken from at least 11 instants.")
    if rounds is not None and rounds < 1:
        problems.append(f"rounds is {rounds}; a time takes at least one run.")
    if analysis is not None and analysis not in scene_trial.ANALYSES:
        known = ", ".join(scene_trial.ANALYSES)
        problems.append(f"There is no analysis {analysis!r}; there are: {known}.")
    if problems:
        raise InputError(problems)
