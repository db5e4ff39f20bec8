"""Effect ranking: the scene in full, then without each effect in turn, compared and timed.

With a permitted error, the cheapest scene within it: without all effects that are negligible alone,
and run before it is proposed.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from os import PathLike
from typing import TYPE_CHECKING, Any

from codegen.errors import InputError
from codegen.readers import arguments as readers
from runtime.studies import harness
from runtime.studies.quantity import Function, parse_quantity
from runtime.studies.ranking import Matters, Proposal, Row, Verdict
from runtime.studies.timing import time_runs
from runtime.studies.trials import LEAST_RTOL, Comparison, Plan, Trial
from runtime.validation.arguments import KINDS

if TYPE_CHECKING:
    from codegen import Model, Scene
    from codegen.reading.scene_selection import Variant

LEAST_ROUNDS = 5  # measured: rounds of timed runs, unless these are long
SECONDS = 3.0  # measured: processor time for all rounds


@readers.reads(**harness.READERS | {
    "asked": readers.either(readers.text("a quantity"), readers.function),
    "error": readers.optional(readers.number("a share between 0 and 1", above=0.0, below=1.0)),
    "fidelities": readers.flag, "method": KINDS["method"], "formulation": KINDS["formulation"],
    "rtol": readers.number(
        f"a number from {LEAST_RTOL:g} to 1e-4", above=LEAST_RTOL, below=1e-4, closed=True
    ),
    "points": readers.count(11), "rounds": readers.optional(readers.count(1)),
})  # fmt: skip
@harness.takes_simulation_arguments()
def matters(
    model: "str | PathLike[str] | Model", scene: "str | Scene | None" = None, *,
    asked: str | Function, t_end: float | None = None, t_start: float = 0.0,
    error: float | None = None, analysis: str | None = None, fidelities: bool = True,
    parameters: Mapping[str, float] | None = None, guess: Mapping[str, float] | None = None,
    start: Mapping[str, float] | None = None,
    method: str = "dop853", formulation: str | None = None, rtol: float = 1e-10,
    points: int = 1001, rounds: int | None = None, folder: str | PathLike[str] | None = None,
    generated: str | PathLike[str] | None = None,
    progress: Callable[[str], None] = lambda line: None, **run: Any,
) -> Matters:  # fmt: skip
    """Rank the effects of a scene by their influence on a quantity.

    Parameters
    ----------
    model, scene, folder, generated
        As in `load`. Undeclared scenes are compiled in the folder's `.linkwright_cache`.
    asked
        The quantity: a text (`runtime.studies.quantity`) or a function of a result.
    t_end, t_start
        Of the run, s; an equilibrium needs none.
    error
        The largest relative change that is permitted; with it a cheaper scene is proposed.
    analysis
        "simulate", "kinematics", "inverse_dynamics" or "equilibrium"; unless given, it follows from
        the scene: inverse dynamics where drivers leave no freedom, else simulation.
    fidelities
        Whether the other fidelities of things that have several are tried as well.
    parameters, guess, start
        As in the analyses, `start` by name; a variant without the thing that a value belongs to
        ignores it.
    method, formulation, rtol
        Of a simulation; a second one with 100 `rtol`, and 100 `atol` where that is given, shows how
        far it can be trusted.
    atol, controllers, until, correction, time_scale, first_step, max_step, max_steps, max_bytes
        As in `simulate`, for each of its runs.
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
    source = harness.read_source(model, scene, folder, generated)
    changes = _changes(source, fidelities)
    harness.cache_folder(folder)  # refused now if it cannot be written
    title = f"{source.model.name}/{source.scene.name}"
    progress(f"{title}: the full scene")
    machine, end = source.machine(), t_start
    kind = analysis or harness.analysis_of(machine)
    if kind != "equilibrium":
        end = harness.require_time_span(machine, t_start, t_end)
    elif start:
        raise InputError(
            f"{title}: start has values, but an equilibrium is searched for: what the scene fixes "
            "is free there. Give guess= (--guess), where the search begins."
        )
    words = harness.read_simulation_arguments(machine, run, kind)
    if kind == "simulate":
        words |= {"method": method, "formulation": formulation}
    given = {"parameters": parameters, "guess": guess, "start": start}
    words |= {name: dict(values) for name, values in given.items() if values}
    plan = Plan(quantity, kind, float(t_start), float(end), points, rtol, words)
    full = plan.trial(machine)
    comparison = Comparison(source, plan, full, error, progress)
    found = [(change, comparison.trial(change.of(source.scene))) for change in changes]
    ran = [(change, trial) for change, trial in found if isinstance(trial, Trial)]
    proposal, best = (None, full) if error is None else _propose_scene(comparison, ran)
    progress(f"{title}: timing in turns")
    trials = dict.fromkeys([full, *(trial for _, trial in ran), best])
    runs, first = [trial.repeat for trial in trials], [math.nan] * len(trials)
    each = 0.0 if rounds else SECONDS / len(trials)
    for trial, times in zip(
        trials, time_runs(runs, first, rounds or LEAST_ROUNDS, each), strict=True
    ):
        trial.seconds = min(times)
    proposal = proposal and replace(proposal, costs=best.costs, time_share=comparison.saving(best))
    return Matters(
        model=source.model.name, scene=source.scene.name, analysis=kind, quantity=quantity.text,
        value=full.quantity.value, unit=full.quantity.unit, size=comparison.size, doubt=full.doubt,
        costs=full.costs, rows=tuple(sorted((comparison.row(*pair) for pair in found), key=_rank)),
        error=error, proposal=proposal, notes=tuple(_notes(comparison, changes)),
    )  # fmt: skip


def _changes(source: harness.Source, fidelities: bool) -> "tuple[Variant, ...]":
    """Everything that can be left out of the scene, or taken in another fidelity."""
    from codegen.reading.scene_selection import variants

    changes = variants(source.model, source.scene, fidelities=fidelities)
    if not changes:
        why = "a kinematic scene has no forces" if source.scene.effects else "no effect acts"
        raise InputError(
            f"{source.model.name}/{source.scene.name}: {why}, and nothing in it has another "
            "fidelity, so there is nothing to leave out. Choose another scene of the model, or add "
            "effects."
        )
    return changes


def _propose_scene(
    comparison: Comparison, trials: "Sequence[tuple[Variant, Trial]]"
) -> tuple[Proposal, Trial]:
    """The scene without all that is negligible, or as much of it as the error permits together.

    While the scene is beyond the error, the effect that changes the quantity most is put back and
    the scene run again; the proposed scene has therefore been run. It is not timed yet.
    """
    full = comparison.source.scene
    scene, trial, left_out = full, comparison.full, _negligible(comparison, trials)
    put_back: list[str] = []
    tried: list[tuple[tuple[str, ...], float | None]] = []
    while left_out:
        titles = tuple(change.title for change in left_out)
        comparison.progress(f"checking the scene without {', '.join(titles)}")
        cheaper = reduce(lambda scene, change: change.of(scene), left_out, full)
        found = comparison.trial(cheaper)
        change = comparison.change(found) if isinstance(found, Trial) else None
        tried.append((titles, change and change.relative))
        if isinstance(found, Trial) and change and change.is_permitted:
            scene, trial = cheaper, found
            break
        put_back.append(left_out.pop().title)
    change = comparison.change(trial)
    proposal = Proposal(
        left_out=tuple(change.title for change in left_out), put_back=tuple(put_back),
        scene=scene.name, spelled=scene.expression, value=trial.quantity.value,
        relative=change.relative, doubt=comparison.relative(change.doubt), costs=trial.costs,
        time_share=math.nan, tried=tuple(tried),
    )  # fmt: skip
    return proposal, trial


def _negligible(
    comparison: Comparison, trials: "Sequence[tuple[Variant, Trial]]"
) -> "list[Variant]":
    """Changes that the error permits alone and that make a run cheaper; the least first.

    An element is left out if that is permitted; else it is taken in the fidelity that changes the
    quantity least, if the run then takes less work.
    """
    most, chosen = comparison.full.costs.work, dict[str, "Variant"]()
    found = [(variant, trial, comparison.change(trial)) for variant, trial in trials]
    found.sort(key=lambda one: (one[2].relative, one[0].title))
    for variant, trial, change in sorted(found, key=lambda one: one[0].word != harness.LEFT_OUT):
        cheaper = variant.word == harness.LEFT_OUT or trial.costs.work < most
        if cheaper and change.is_permitted:
            chosen.setdefault(variant.name, variant)
    return [variant for variant, _, _ in found if chosen.get(variant.name) is variant]


def _rank(row: Row) -> tuple[bool, bool, float]:
    """Needed and impossible first, then by change; changes below their uncertainty last."""
    return row.change is not None, row.verdict is Verdict.NONE_SEEN, -(row.relative or 0.0)


def _notes(comparison: Comparison, changes: "tuple[Variant, ...]") -> Iterator[str]:
    full, size, error = comparison.full, comparison.size, comparison.error
    effects = [change for change in changes if change.word == harness.LEFT_OUT]
    if len(effects) == 1:
        name = effects[0].name
        yield f"{name} is the only effect of the scene, so there is none to rank it with."
    if not size:
        yield "The quantity is zero throughout, so a relative change is not defined."
    elif size != abs(full.quantity.value):
        whole = f"{size:.4g} {full.quantity.unit}".rstrip()
        yield (
            "The quantity is zero within its uncertainty, so changes are relative to "
            f"{whole}, the largest magnitude during the run."
        )
    if error is not None and size and full.doubt > 0.1 * error * size:
        yield (
            f"The quantity is known to {full.doubt / size:.1e} only, which is "
            f"{'more' if full.doubt > error * size else 'not much less'} than the permitted error "
            f"of {error:g}: lower rtol, give more points, or end the run earlier."
        )
