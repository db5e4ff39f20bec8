"""Two runs of a scene for one number, its uncertainty and its cost; compared with the full scene.

The second run has tolerances a hundred times tighter and samples twice as dense. Quantities that
jump at an event are sampled on both sides of it, nearer to it in the second run. A position of
equilibrium is searched for a second time from a point close to it. The difference of the two
answers is the uncertainty of the second.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from codegen.errors import LinkwrightError
from runtime.machine_facade import Machine
from runtime.mechanism.dense_equations import FloatArray
from runtime.results.result import Result
from runtime.studies.harness import LEFT_OUT, Source, arguments_of_variant
from runtime.studies.quantity import Quantity, QuantityValue, jumps
from runtime.studies.ranking import Costs, Row, Verdict
from runtime.studies.timing import processor_time

if TYPE_CHECKING:
    from codegen import Scene
    from codegen.reading.scene_selection import Variant

COARSER = 100.0  # accuracy: ratio of the tolerances of the two runs
LEAST_RTOL = 1e-13  # accuracy: tightest rtol of the second run
NONE = np.zeros(0)
STILL = 1e-9  # accuracy: share of the full scene's motion below which nothing moves
_BESIDE_EVENT = 1e-7  # accuracy: share of the run between an event and the samples beside it
_PERTURBATION = 1e-4  # accuracy: relative offset from which an equilibrium is searched for again
_ROUNDING = 1e-12  # accuracy: least relative uncertainty, however well two runs agree


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

    def run(self, machine: Machine, rtol: float, instants: FloatArray) -> Result:
        """The analysis of a machine."""
        words = {**self.words, "progress": False}
        if self.analysis == "equilibrium":
            return machine.equilibrium(t=self.t_start, **words)
        if self.analysis != "simulate":
            result: Result = getattr(machine, self.analysis)(instants, **words)
            return result
        if (atol := words.get("atol")) is not None:
            words["atol"] = atol * (rtol / self.rtol)
        return machine.simulate(self.t_end, instants, t_start=self.t_start, rtol=rtol, **words)

    def instants(self, count: int, events: FloatArray = NONE, beside: float = 0.0) -> FloatArray:
        """Equally spaced instants, and those before and after events by a share of the run."""
        first, last = self.t_start, self.t_end
        step = beside * (last - first)
        every = np.concatenate([np.linspace(first, last, count), events - step, events + step])
        return np.unique(np.clip(every, first, last))

    def trial(self, machine: Machine) -> "Trial":
        """Run a scene twice; LinkwrightError if it fails, or has no such quantity."""
        simulated, freedom = self.analysis == "simulate", 0
        if self.analysis != "equilibrium":  # whose start need not satisfy the constraints
            given = {x: self.words.get(x) for x in ("parameters", "guess", "start")}
            begin = machine.assemble(**given, t=self.t_start if simulated else 0.0)
            freedom = begin.degrees_of_freedom
        rough, fine = self._run_twice(machine)
        for run in (rough, fine):
            if run.failed:
                raise LinkwrightError(f"{run.description.title}: {run.message}")
        first, second = self.quantity.read(rough), self.quantity.read(fine)
        least = max(_ROUNDING, self.rtol if simulated else 0.0)
        doubt = abs(second.value - first.value) + least * max(abs(second.value), second.scale)
        again = partial(self.run, machine, self.rtol, self.instants(self.points))
        return Trial(fine, second, doubt, freedom, lambda: processor_time(again)[1])

    def _run_twice(self, machine: Machine) -> tuple[Result, Result]:
        """The run for comparison, and the run from which the quantity is taken."""
        rtol, instants, events = min(COARSER * self.rtol, 1e-3), self.instants(self.points), NONE
        rough = self.run(machine, rtol, instants)
        if rough.failed:
            return rough, rough
        if self.analysis == "equilibrium":
            q = rough.samples.q[0] + _PERTURBATION * (1.0 + np.abs(rough.samples.q[0]))
            near = dict(zip(machine.coordinates.names, q.tolist(), strict=True))
            guess = {**self.words.get("guess", {}), **near}
            return rough, replace(self, words={**self.words, "guess": guess}).run(
                machine, rtol, instants
            )
        if self.analysis == "simulate" and len(events := jumps(rough)):
            rough = self.run(machine, rtol, self.instants(self.points, events, 4.0 * _BESIDE_EVENT))
        dense = self.instants(2 * self.points - 1, events, _BESIDE_EVENT)
        return rough, self.run(machine, self.rtol, dense)


@dataclass(eq=False)
class Trial:
    """A scene that was run."""

    result: Result  # of the second run
    quantity: QuantityValue
    doubt: float  # uncertainty of the quantity
    freedom: int  # degrees of freedom at the start
    repeat: Callable[[], float]  # the run, from the call to the result; its processor time, s
    seconds: float = math.nan  # the least time measured

    @property
    def reach(self) -> dict[str, float]:
        """Coordinate → largest less least value, in its unit."""
        spans = np.ptp(self.result.samples.q, axis=0).tolist()
        return dict(zip(self.result.description.coordinates.names, spans, strict=True))

    @property
    def costs(self) -> Costs:
        """Costs of the second run, and the least time measured."""
        return count_costs(self.result, self.seconds)


def count_costs(run: Result, seconds: float = math.nan) -> Costs:
    """Costs of a run: operations of its accelerations and in all, evaluations, steps and events."""
    operations = dict(run.description.operations)
    evaluations, steps = (int(run.stats.get(name, 0)) for name in ("rhs_evaluations", "steps"))
    # Calls of `correction`: a simulation counts them by that name, kinematics as its iterations.
    corrections = int(run.stats.get("corrections", run.stats.get("newton_iterations", 0)))
    accelerations, total = operations.get("accelerations", 0), sum(operations.values())
    work = evaluations * accelerations + corrections * operations.get("correction", 0)
    return Costs(accelerations, total, evaluations, steps, len(run.events), work or total, seconds)


class Change(NamedTuple):
    """The change of the quantity from the full scene to another."""

    value: float
    doubt: float  # its uncertainty
    relative: float  # its magnitude over the quantity's size
    is_permitted: bool  # by the error, together with its uncertainty


@dataclass(frozen=True)
class Comparison:
    """Compares scenes with the full one, that of the source."""

    source: Source
    plan: Plan
    full: Trial  # of the full scene
    error: float | None  # the relative change that is permitted
    progress: Callable[[str], None]  # receives a line before every step that takes time

    @property
    def size(self) -> float:
        """Divisor of relative changes: see `Matters`."""
        value = abs(self.full.quantity.value)
        return value if value > 10.0 * self.full.doubt else max(self.full.quantity.scale, value)

    def trial(self, scene: "Scene") -> Trial | LinkwrightError:
        """Run a variant; an error where it does not work as the full scene does."""
        self.progress(f"{self.source.model.name}/{scene.name}")
        machine, full = None, self.full
        try:
            machine = self.source.variant(scene)
            words = arguments_of_variant(machine, self.plan.words)
            trial = replace(self.plan, words=words).trial(machine)
        except LinkwrightError as error:
            return error if machine is None else self._without_state(machine) or error
        if trial.freedom != full.freedom:
            return LinkwrightError(
                f"it has {trial.freedom} degrees of freedom, where the full scene has "
                f"{full.freedom}"
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

    def _without_state(self, machine: Machine) -> LinkwrightError | None:
        """The error of a scene that lacks the state of the quantity, if it does."""
        state, here = self.plan.quantity.name, machine.description.states.names
        if state in here or state not in self.full.result.description.states.names:
            return None
        return LinkwrightError(
            f"the state {state!r} leaves the scene with it, because nothing else contains it; so "
            f"{self.plan.quantity.text} has no value there"
        )

    def row(self, change: "Variant", trial: Trial | LinkwrightError) -> Row:
        """The verdict on one change."""
        about = (change.name, change.kind, change.word, change.of(self.source.scene).name)
        if isinstance(trial, LinkwrightError):
            verdict = Verdict.NEEDED if change.word == LEFT_OUT else Verdict.IMPOSSIBLE
            reason = "; ".join(trial.problems)
            return Row(*about, None, None, None, 0.0, None, None, verdict, reason)
        found = self.change(trial)
        verdict = Verdict.NEGLIGIBLE if found.is_permitted else Verdict.MATTERS
        if abs(found.value) <= found.doubt:
            verdict = Verdict.NONE_SEEN
        return Row(
            *about, trial.quantity.value, found.value, found.relative, found.doubt, trial.costs,
            self.saving(trial), verdict,
        )  # fmt: skip

    def change(self, trial: Trial) -> Change:
        """The change of the quantity from the full scene."""
        delta = trial.quantity.value - self.full.quantity.value
        doubt = trial.doubt + self.full.doubt
        permitted = self.error is not None and abs(delta) + doubt <= self.error * self.size
        return Change(delta, doubt, self.relative(abs(delta)), permitted)

    def relative(self, amount: float) -> float:
        """An amount over the quantity's size; infinite if the quantity is zero throughout."""
        return amount / self.size if self.size else (math.inf if amount else 0.0)

    def saving(self, trial: Trial) -> float:
        """Share of the full scene's time that a trial saves, once both are timed."""
        return 1.0 - trial.seconds / self.full.seconds
