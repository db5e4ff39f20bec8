"""Effect ranking: the scene in full, then without each effect in turn, compared and timed.

Each scene is run twice, the second time with tolerances a hundred times tighter and samples twice
as dense; a function of a result sees both sides of each event. A position of equilibrium is
searched for a second time from a point close to it. The difference of the two answers is the
uncertainty of the second.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import InputError, LinkwrightError
from codegen.readers import arguments as readers
from runtime.machine_facade import Machine
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.mechanism import Values
from runtime.results.motion_at_instants import with_both_sides
from runtime.results.result import Result
from runtime.studies import harness
from runtime.studies.harness import LEFT_OUT, Place, Report
from runtime.studies.quantity import Function, Quantity, QuantityValue, parse_quantity
from runtime.studies.ranking import Costs, Matters, Proposal, Row, Verdict
from runtime.validation.arguments import KINDS

if TYPE_CHECKING:
    from codegen import Model, Scene
    from codegen.reading.scene_selection import Variant

COARSER = 100.0  # accuracy: ratio of the tolerances of the two runs
LEAST_RTOL = 1e-13  # accuracy: tightest rtol of the second run
LEAST_ROUNDS = 5  # measured: rounds of timed runs, unless these are long
SECONDS = 3.0  # measured: processor time for all rounds
STILL = 1e-9  # accuracy: share of the full scene's motion below which nothing moves
_PERTURBATION = 1e-4  # accuracy: relative offset from which an equilibrium is searched for again
_ROUNDING = 1e-12  # accuracy: least relative uncertainty, however well two runs agree


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
    parameters: Values | None = None, guess: Values | None = None, start: Values | None = None,
    method: str = "dop853", formulation: str | None = None, rtol: float = 1e-10,
    points: int = 1001, rounds: int | None = None, folder: Place | None = None,
    generated: Place | None = None, progress: Report = lambda line: None, **run: Any,
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
        Whether the other fidelities of elements that have several are tried as well.
    parameters, guess, start
        As in the analyses, `start` by name; a variant ignores a value of an element that it lacks.
    method, formulation, rtol
        As in `simulate`. A second run with 100 `rtol`, and with 100 `atol` if `atol` is given,
        shows how far the numbers can be trusted.
    atol, controllers, until, correction, time_scale, first_step, max_step, max_steps, max_bytes
        As in `simulate`, for each of its runs.
    points
        Output instants of a timed run.
    rounds
        Timed runs of each scene, of which the shortest time counts; by default as many as three
        seconds allow.
    progress
        Receives a line before every step that takes time.

    Raises
    ------
    InputError
        If the quantity or another argument is invalid, or there is no effect to leave out.
    LinkwrightError
        If the full scene does not run to its end.
    """
    from codegen.reading.scene_selection import variants

    quantity = parse_quantity(asked)
    source = harness.read_source(model, scene, folder, generated)
    changes = variants(source.model, source.scene, fidelities=fidelities)
    if not changes:
        why = "a kinematic scene has no forces" if source.scene.effects else "no effect acts"
        raise InputError(
            f"{source.title}: {why}, and nothing in it has another fidelity, so there is nothing "
            "to leave out. Choose another scene of the model, or add effects."
        )
    harness.cache_folder(folder)  # refused now if it cannot be written
    progress(f"{source.title}: the full scene")
    machine = source.machine()
    kind = analysis or harness.analysis_of(machine)
    if kind == "equilibrium" and start:
        raise InputError(
            f"{source.title}: start has values, but an equilibrium is searched for: what the scene "
            "fixes is free there. Give guess= (--guess), where the search begins."
        )
    end = harness.require_time_span(machine, kind, t_start, t_end)
    words = harness.read_simulation_arguments(machine, run, kind)
    if kind == "simulate":
        words |= {"method": method, "formulation": formulation}
    given = {"parameters": parameters, "guess": guess, "start": start}
    words |= {name: dict(values) for name, values in given.items() if values}
    plan = Plan(quantity, kind, float(t_start), end, points, rtol, words)
    full = plan.trial(machine)
    ranking = Ranking(source, plan, full, error, progress)
    found = [(change, ranking.trial(change.of(source.scene))) for change in changes]
    ran = [(change, trial) for change, trial in found if isinstance(trial, Trial)]
    proposal, best = (None, full) if error is None else ranking.propose(ran)
    progress(f"{source.title}: timing in turns")
    trials = [*dict.fromkeys([full, *(trial for _, trial in ran), best])]
    times = harness.time_runs(
        [trial.repeat for trial in trials], [math.nan] * len(trials), rounds or LEAST_ROUNDS,
        0.0 if rounds else SECONDS / len(trials),
    )  # fmt: skip
    for trial, seconds in zip(trials, times, strict=True):
        trial.seconds = min(seconds)
    proposal = proposal and replace(proposal, costs=best.costs, time_share=best.saving)
    rows = sorted((ranking.row(*pair) for pair in found), key=lambda row: row.rank)
    return Matters(
        model=source.model.name, scene=source.scene.name, analysis=kind, quantity=quantity.text,
        value=full.quantity.value, unit=full.quantity.unit, size=full.size, doubt=full.doubt,
        costs=full.costs, rows=tuple(rows), error=error, proposal=proposal,
        notes=tuple(ranking.notes(changes)),
    )  # fmt: skip


@dataclass(frozen=True)
class Plan:
    """The run that every scene of a ranking makes, and the quantity that is taken from it."""

    quantity: Quantity
    analysis: str  # one of `runtime.core.kinds.ANALYSES`
    t_start: float
    t_end: float
    points: int  # output instants of the first run, and of those that are timed
    rtol: float  # of the second run, and of those that are timed
    words: Mapping[str, Any]  # of the analysis, besides, values by name among them

    def run(
        self, machine: Machine, rtol: float, instants: FloatArray, **more: Mapping[str, float]
    ) -> Result:
        """The analysis of a machine, to its end."""
        words = {**self.words, **more, "progress": False}
        if words.get("atol") is not None:
            words["atol"] = words["atol"] * (rtol / self.rtol)
        if self.analysis == "simulate":
            words |= {"t_start": self.t_start, "rtol": rtol}
            result = machine.simulate(self.t_end, instants, **words)
        elif self.analysis == "equilibrium":
            result = machine.equilibrium(t=self.t_start, **words)
        else:
            result = getattr(machine, self.analysis)(instants, **words)
        if result.failed:
            raise LinkwrightError(f"{result.description.title}: {result.message}")
        return result

    def instants(self, count: int) -> FloatArray:
        """Equally spaced instants of the run."""
        return np.linspace(self.t_start, self.t_end, count)

    def trial(self, machine: Machine) -> "Trial":
        """Run a scene twice; LinkwrightError if it fails, or has no such quantity."""
        simulated, freedom = self.analysis == "simulate", 0
        if self.analysis != "equilibrium":  # whose start need not satisfy the constraints
            given = {x: self.words.get(x) for x in ("parameters", "guess", "start")}
            begin = machine.assemble(**given, t=self.t_start if simulated else 0.0)
            freedom = begin.degrees_of_freedom
        runs, sides = self._run_twice(machine), bool(self.quantity.function)
        first, second = (self.quantity.read(with_both_sides(x) if sides else x) for x in runs)
        least = max(_ROUNDING, self.rtol if simulated else 0.0)
        doubt = abs(second.value - first.value) + least * max(abs(second.value), second.scale)
        again = partial(self.run, machine, self.rtol, self.instants(self.points))
        return Trial(runs[1], second, doubt, freedom, lambda: harness.processor_time(again)[1])

    def _run_twice(self, machine: Machine) -> tuple[Result, Result]:
        """The run for comparison, and the run from which the quantity is taken."""
        rtol, instants = min(COARSER * self.rtol, 1e-3), self.instants(self.points)
        rough = self.run(machine, rtol, instants)
        if self.analysis == "equilibrium":
            q = rough.samples.q[0] + _PERTURBATION * (1.0 + np.abs(rough.samples.q[0]))
            near = dict(zip(machine.coordinates.names, q.tolist(), strict=True))
            return rough, self.run(
                machine, rtol, instants, guess={**self.words.get("guess", {}), **near}
            )
        return rough, self.run(machine, self.rtol, self.instants(2 * self.points - 1))


@dataclass(eq=False)
class Trial:
    """A scene that was run."""

    result: Result  # of the second run
    quantity: QuantityValue
    doubt: float  # uncertainty of the quantity
    freedom: int  # degrees of freedom at the start
    repeat: Callable[[], float]  # the run, from the call to the result; its processor time, s
    seconds: float = math.nan  # the least time measured
    base: "Trial | None" = None  # the full scene's, with which it is compared; None of that itself

    @property
    def change(self) -> float:
        """Change of the quantity from the full scene."""
        return self.quantity.value - (self.base or self).quantity.value

    @property
    def uncertainty(self) -> float:
        """That of the change."""
        return self.doubt + (self.base or self).doubt

    @property
    def size(self) -> float:
        """Divisor of relative changes: see `Matters`."""
        full = self.base or self
        value = abs(full.quantity.value)
        return value if value > 10.0 * full.doubt else max(full.quantity.scale, value)

    def share(self, amount: float) -> float:
        """An amount over the quantity's size; infinite if the quantity is zero throughout."""
        return amount / self.size if self.size else (math.inf if amount else 0.0)

    @property
    def relative(self) -> float:
        """Magnitude of the change over the quantity's size."""
        return self.share(abs(self.change))

    @property
    def saving(self) -> float:
        """Share of the full scene's time that it saves, once both are timed."""
        return 1.0 - self.seconds / (self.base or self).seconds

    @property
    def reach(self) -> dict[str, float]:
        """Coordinate → largest less least value, in its unit."""
        spans = np.ptp(self.result.samples.q, axis=0).tolist()
        return dict(zip(self.result.description.coordinates.names, spans, strict=True))

    @property
    def costs(self) -> Costs:
        """Costs of the second run, and the least time measured."""
        run, operations = self.result, dict(self.result.description.operations)
        evaluations, steps = (int(run.stats.get(x, 0)) for x in ("rhs_evaluations", "steps"))
        # Calls of `correction`: a simulation counts them by that name, kinematics as iterations.
        corrections = int(run.stats.get("corrections", run.stats.get("newton_iterations", 0)))
        accelerations, total = operations.get("accelerations", 0), sum(operations.values())
        work = evaluations * accelerations + corrections * operations.get("correction", 0)
        return Costs(
            accelerations, total, evaluations, steps, len(run.events), work or total, self.seconds
        )


@dataclass(frozen=True)
class Ranking:
    """Compares scenes with the full one, that of the source."""

    source: harness.Source
    plan: Plan
    full: Trial  # of the full scene
    error: float | None  # the relative change that is permitted
    progress: Report

    def trial(self, scene: "Scene") -> Trial | LinkwrightError:
        """Run a variant; an error where it does not work as the full scene does."""
        self.progress(f"{self.source.model.name}/{scene.name}")
        state, full, lost = self.plan.quantity.name, self.full, set[str]()
        try:
            machine = self.source.variant(scene)
            lost = {*full.result.description.states.names} - {*machine.description.states.names}
            words = harness.arguments_of_variant(machine, self.plan.words)
            trial = replace(self.plan, words=words).trial(machine)
            trial.base = full
        except LinkwrightError as error:
            if state not in lost:
                return error
            return LinkwrightError(
                f"the state {state!r} leaves the scene with it, because nothing else contains it; "
                f"so {self.plan.quantity.text} has no value there"
            )
        if (own := trial.freedom) != full.freedom:
            return LinkwrightError(
                f"it has {own} degrees of freedom, where the full scene has {full.freedom}"
            )
        ends = [one.result.ended_by for one in (trial, full)]
        if ends[0] != ends[1]:
            ways = [f"ends where {name!r} begins to hold" if name else "goes on" for name in ends]
            return LinkwrightError(f"it {ways[0]}, where the full scene {ways[1]}")
        moved, reach = full.reach, trial.reach
        common = [name for name in reach if moved.get(name, 0.0) > 0.0]
        if common and all(reach[name] <= STILL * moved[name] for name in common):
            return LinkwrightError("nothing moves without it")
        return trial

    def row(self, change: "Variant", trial: Trial | LinkwrightError) -> Row:
        """The verdict on one change."""
        about = (change.name, change.kind, change.word, change.of(self.source.scene).name)
        if isinstance(trial, LinkwrightError):
            verdict = Verdict.NEEDED if change.word == LEFT_OUT else Verdict.IMPOSSIBLE
            return Row(*about, verdict, "; ".join(trial.problems))
        verdict = Verdict.NEGLIGIBLE if self._permits(trial) else Verdict.MATTERS
        if abs(trial.change) <= trial.uncertainty:
            verdict = Verdict.NONE_SEEN
        return Row(
            *about, verdict, "", trial.quantity.value, trial.change, trial.relative,
            trial.uncertainty, trial.costs, trial.saving,
        )  # fmt: skip

    def _permits(self, trial: Trial) -> bool:
        """Whether the change, with its uncertainty, is within the error."""
        most = abs(trial.change) + trial.uncertainty
        return self.error is not None and most <= self.error * trial.size

    def propose(self, trials: "Sequence[tuple[Variant, Trial]]") -> tuple[Proposal, Trial]:
        """The scene without what is negligible together: else the largest change is put back."""
        full, put_back = self.source.scene, list[str]()
        scene, best, left_out = full, self.full, self._negligible(trials)
        tried: list[tuple[tuple[str, ...], float | None]] = []
        while left_out:
            titles = tuple(change.title for change in left_out)
            self.progress(f"checking the scene without {', '.join(titles)}")
            cheaper = reduce(lambda scene, change: change.of(scene), left_out, full)
            trial = self.trial(cheaper)
            tried.append((titles, trial.relative if isinstance(trial, Trial) else None))
            if isinstance(trial, Trial) and self._permits(trial):
                scene, best = cheaper, trial
                break
            put_back.append(left_out.pop().title)
        return Proposal(
            left_out=tuple(change.title for change in left_out), put_back=tuple(put_back),
            scene=scene.name, spelled=scene.expression, value=best.quantity.value,
            relative=best.relative, doubt=best.share(best.uncertainty), costs=best.costs,
            time_share=math.nan, tried=tuple(tried),
        ), best  # fmt: skip

    def _negligible(self, trials: "Sequence[tuple[Variant, Trial]]") -> "list[Variant]":
        """What the error permits alone, the least first: left out, or in a cheaper fidelity."""
        most, chosen = self.full.costs.work, dict[str, "Variant"]()
        found = sorted(trials, key=lambda one: (one[1].relative, one[0].title))
        for variant, trial in sorted(found, key=lambda one: one[0].word != LEFT_OUT):
            cheaper = variant.word == LEFT_OUT or trial.costs.work < most
            if cheaper and self._permits(trial):
                chosen.setdefault(variant.name, variant)
        return [variant for variant, _ in found if chosen.get(variant.name) is variant]

    def notes(self, changes: "Sequence[Variant]") -> Iterator[str]:
        """Remarks on the quantity and what is ranked."""
        full, size, error = self.full, self.full.size, self.error
        effects = [change.name for change in changes if change.word == LEFT_OUT]
        if len(effects) == 1:
            yield f"{effects[0]} is the scene's only effect, so there is none to rank it with."
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
                f"{'more' if full.doubt > error * size else 'not much less'} than the permitted "
                f"error of {error:g}: lower rtol, give more points, or end the run earlier."
            )
