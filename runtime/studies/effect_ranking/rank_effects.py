"""The scene in full, then with each effect left out in turn: what it changes and what it costs."""

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from codegen.errors import AnalysisError, InputError, LinkwrightError
from runtime.load import load
from runtime.studies.effect_ranking.alternating_timing import take_turns
from runtime.studies.effect_ranking.quantity import Function, quantity
from runtime.studies.effect_ranking.ranking import Costs, Matters, Row, Verdict
from runtime.studies.effect_ranking.scene_proposal import Judge, proposed
from runtime.studies.effect_ranking.trial_run import (
    ANALYSES,
    LEAST_RTOL,
    LostError,
    Plan,
    Trial,
    tried,
)
from runtime.studies.variant_builds import cache, loaded

if TYPE_CHECKING:
    from codegen import Model, Scene
    from codegen.scene_variants import Variant
    from runtime.machine import Machine

STILL = 1e-9
"""Share of the full scene's motion below which nothing moves."""


def matters(
    model: "str | os.PathLike[str] | Model",
    scene: "str | Scene | None" = None,
    *,
    asked: str | Function,
    t_end: float | None = None,
    t_start: float = 0.0,
    error: float | None = None,
    analysis: str | None = None,
    fidelities: bool = True,
    parameters: Mapping[str, float] | None = None,
    guess: Mapping[str, float] | None = None,
    method: str = "dop853",
    rtol: float = 1e-10,
    points: int = 1001,
    rounds: int | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Callable[[str], None] = lambda line: None,
) -> Matters:
    """Which effects of a scene a question calls for.

    Parameters
    ----------
    model, scene
        As in `load`.
    asked
        The quantity: a text (`runtime.studies.effect_ranking.quantity`) or a function.
    t_end, t_start
        Of the run, s; an equilibrium needs none.
    error
        The largest relative change that is permitted; with it a cheaper scene is proposed.
    analysis
        "simulate", "kinematics", "inverse" or "equilibrium"; without it what the scene is for:
        inverse dynamics where drivers leave no freedom, else simulation.
    fidelities
        Whether what has several fidelities is tried in the others as well.
    parameters, guess
        As in the analyses; scenes without what they belong to do without them.
    method, rtol
        Of a simulation; it is also run with 100 `rtol`, to see how far it can be trusted.
    points
        Output instants of a timed run.
    rounds
        Runs by which times are taken, of which the least counts; what three seconds allow unless
        given.
    folder
        As in `load`. Scenes that nobody declared are compiled in its `.linkwright_cache`.
    progress
        Receives a line before every step that takes time.

    Raises
    ------
    InputError
        If the quantity, or anything else that was given, is none; or if there is nothing to judge.
    LinkwrightError
        If the full scene does not run to its end.
    """
    from codegen.scene_variants import declared, variants

    wanted = quantity(asked)
    _check(error, rtol, points, rounds, analysis)
    read, chosen = declared(
        model if not isinstance(model, os.PathLike) else Path(model), scene
    )  # fmt: skip
    changes = variants(read, chosen, fidelities=fidelities)
    if not changes:
        what = "no effect acts" if not chosen.effects else "a kinematic scene has no forces"
        raise InputError(
            f"{read.name}/{chosen.name}: {what}, and nothing in it has another fidelity, so there "
            "is nothing to leave out. Choose another scene of the model, or take effects in."
        )
    place = cache(folder)
    progress(f"{read.name}/{chosen.name}: all that the scene names")
    whole = loaded(model, scene, (read, chosen), folder)
    whole.parameter_values(parameters)  # what the full scene does not know is a mistake
    plan = Plan(
        _analysis(whole, analysis), float(t_start), _end(whole, analysis, t_end, t_start), points,
        rtol, method, dict(parameters or {}), dict(guess or {}),
    )  # fmt: skip
    if guess:
        whole.assemble(guess=guess, parameters=parameters, t=plan.t_start)
    try:
        full = tried(whole, plan, wanted)
    except LostError as lost:
        cause = lost.__cause__
        raise (cause if isinstance(cause, InputError) else LinkwrightError(str(lost))) from None
    value, scale = full.reading.value, full.reading.scale
    size = abs(value) if abs(value) > 10.0 * full.doubt else max(scale, abs(value))

    def trial(scene: "Scene") -> Trial:
        progress(f"{read.name}/{scene.name}")
        try:
            machine = load(read, scene, folder=place)
            found = tried(machine, plan, wanted)
        except InputError as problem:
            raise LostError("; ".join(problem.problems)) from problem
        if reason := _stopped(full, found):
            raise LostError(reason)
        return found

    judge = Judge(full, size, error, chosen, trial)
    rows: list[tuple[Row, Variant]] = []
    trials: list[Trial | None] = []
    for change in changes:
        row, found = judge.row(change)
        rows.append((row, change))
        trials.append(found)
    proposal, best = proposed(judge, rows, progress) if error is not None else (None, None)
    progress(f"{read.name}/{chosen.name}: taking times")
    run = [t for t in (full, *trials, best) if t is not None]
    seconds = iter(take_turns([t.machine for t in run], plan, rounds))
    base = replace(full.costs, seconds=next(seconds))
    done = [
        row if found is None else _with_time(row, base, next(seconds))
        for (row, _), found in zip(rows, trials, strict=True)
    ]
    if proposal is not None and best is not None:
        took = next(seconds)
        costs = replace(proposal.costs, seconds=took)
        proposal = replace(proposal, costs=costs, time_share=1.0 - took / base.seconds)
    return Matters(
        read.name, chosen.name, plan.analysis, wanted.text, value, full.reading.unit, size,
        full.doubt, base, tuple(sorted(done, key=_rank)), error, proposal,
        tuple(_notes(changes, full, size, error)),
    )  # fmt: skip


def _with_time(row: Row, base: Costs, seconds: float) -> Row:
    assert row.costs is not None
    share = 1.0 - seconds / base.seconds
    return replace(row, costs=replace(row.costs, seconds=seconds), time_share=share)


def _rank(row: Row) -> tuple[bool, bool, float]:
    """What is needed first, then by what it changes; what is only seen in the noise last."""
    return (
        row.change is not None,
        row.verdict is Verdict.NONE_SEEN,
        -(row.relative or 0.0),
    )


def _notes(
    changes: "tuple[Variant, ...]", full: Trial, size: float, error: float | None
) -> list[str]:
    told = []
    effects = [change for change in changes if change.word == "none"]
    if len(effects) == 1:
        told.append(
            f"{effects[0].name} is the only effect of the scene, so there is none to rank it with."
        )
    if not size:
        told.append("The quantity is zero throughout, so no change has a size to compare with.")
    elif size != abs(full.reading.value):
        told.append(
            f"The quantity is zero within what it is known to, so changes are relative to "
            f"{size:.4g} {full.reading.unit}, the largest magnitude on the way.".replace("  ", " ")
        )
    if error is not None and size and full.doubt > 0.1 * error * size:
        told.append(
            f"The quantity is known to {full.doubt / size:.1e} only, which is "
            f"{'more' if full.doubt > error * size else 'not much less'} than the error of "
            f"{error:g} that is permitted: lower rtol, give more points, or end the run earlier."
        )
    return told


def _stopped(full: Trial, found: Trial) -> str:
    """Why a machine does not do what the full scene's does; empty where it does."""
    if found.freedom != full.freedom:
        return f"it has {found.freedom} degrees of freedom, where the full scene has {full.freedom}"
    common = [name for name in found.reach if full.reach.get(name, 0.0) > 0.0]
    if common and all(found.reach[name] <= STILL * full.reach[name] for name in common):
        return "nothing moves without it"
    return ""


def _analysis(machine: "Machine", analysis: str | None) -> str:
    """What a scene is run as."""
    if analysis is not None:
        return analysis
    told = machine.description
    if told.analysis == "equilibrium":
        return "equilibrium"
    if told.drivers and machine.degrees_of_freedom == 0:
        return "inverse" if told.has_masses else "kinematics"
    return "simulate"


def _end(machine: "Machine", analysis: str | None, t_end: float | None, t_start: float) -> float:
    if _analysis(machine, analysis) == "equilibrium":
        return float(t_start)
    if t_end is None:
        raise AnalysisError(
            f"{machine.description.title}: t_end is missing; give the last instant in s (--t-end)."
        )
    if not t_start < t_end < float("inf"):
        raise AnalysisError(
            f"{machine.description.title}: the time span from {t_start:g} to {t_end:g} s must be "
            "finite and positive."
        )
    return float(t_end)


def _check(
    error: float | None, rtol: float, points: int, rounds: int | None, analysis: str | None
) -> None:
    """Refuse what makes no comparison, all at once."""
    problems = []
    if error is not None and not 0.0 < error < 1.0:
        problems.append(f"error is {error:g}; it is a share of the quantity, between 0 and 1.")
    if not LEAST_RTOL <= rtol <= 1e-4:
        problems.append(f"rtol is {rtol:g}; to compare runs it lies from {LEAST_RTOL:g} to 1e-4.")
    if points < 11:
        problems.append(f"points is {points}; a quantity is taken from at least 11 instants.")
    if rounds is not None and rounds < 1:
        problems.append(f"rounds is {rounds}; times are taken by at least one run.")
    if analysis is not None and analysis not in ANALYSES:
        problems.append(f"There is no analysis {analysis!r}; there are: {', '.join(ANALYSES)}.")
    if problems:
        raise InputError(problems)
