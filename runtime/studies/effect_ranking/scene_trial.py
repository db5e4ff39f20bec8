"""Two runs of a scene for one number: its value, its uncertainty and its cost.

The second run has tolerances a hundred times tighter and samples twice as dense. Quantities that
jump at an event are sampled on both sides of it, nearer to it in the second run. A position of
equilibrium is searched for a second time from a point close to it. The difference of the two
answers is the uncertainty of the second.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from codegen.errors import InputError, LinkwrightError
from runtime.machine import Machine
from runtime.results.result import Result
from runtime.studies.effect_ranking.quantity import Quantity, QuantityValue
from runtime.studies.effect_ranking.ranking import Costs
from runtime.studies.scene_loading import known_values
from runtime.studies.series_by_name import FloatArray
from runtime.studies.timing import Stopwatch, processor_time

ANALYSES = ("simulate", "kinematics", "inverse", "equilibrium")
COARSER = 100.0  # accuracy: ratio of the tolerances of the two runs
LEAST_RTOL = 1e-13  # accuracy: tightest rtol of the second run
NONE = np.zeros(0)
_BESIDE_EVENT = 1e-7  # accuracy: share of the run between an event and the samples beside it
_PERTURBATION = 1e-4  # accuracy: relative offset from which an equilibrium is searched for again
_ROUNDING = 1e-12  # accuracy: least relative uncertainty, however well two runs agree


@dataclass(frozen=True)
class Plan:
    """The run that every scene of a ranking makes."""

    analysis: str  # one of `ANALYSES`
    t_start: float
    t_end: float
    points: int  # output instants of the first run, and of those that are timed
    rtol: float  # of the second run, and of those that are timed
    method: str
    parameters: Mapping[str, float]  # a scene gets those that it has
    guess: Mapping[str, float]  # the same

    def values(self, machine: Machine) -> dict[str, dict[str, float]]:
        """Those of the parameters and start values that a machine has."""
        return known_values(machine, self.parameters, self.guess)

    def run(self, machine: Machine, *, rtol: float, instants: FloatArray) -> Result:
        """The analysis of a machine."""
        values: dict[str, Any] = {**self.values(machine), "progress": False}
        if self.analysis == "simulate":
            values |= {"t_start": self.t_start, "method": self.method, "rtol": rtol}
            return machine.simulate(self.t_end, instants, **values)
        if self.analysis == "equilibrium":
            return machine.equilibrium(**values, t=self.t_start)
        driven = self.analysis == "kinematics"
        return (machine.kinematics if driven else machine.inverse_dynamics)(instants, **values)

    def stopwatch(self, machine: Machine) -> Stopwatch:
        """Repeats the run; its time is that from the call to the result."""
        instants = self.instants(self.points)
        return Stopwatch(
            lambda: processor_time(lambda: self.run(machine, rtol=self.rtol, instants=instants))[1]
        )

    def instants(self, count: int, events: FloatArray = NONE, beside: float = 0.0) -> FloatArray:
        """Equally spaced instants, and those before and after events by a share of the run."""
        even = np.linspace(self.t_start, self.t_end, count)
        step = beside * (self.t_end - self.t_start)
        more = np.concatenate([events - step, events + step])
        inside = more[(more > self.t_start) & (more < self.t_end)]
        return np.unique(np.concatenate([even, inside])) if len(events) else even


@dataclass(frozen=True)
class Trial:
    """A scene that was run."""

    machine: Machine
    quantity: QuantityValue
    doubt: float  # uncertainty of the quantity
    freedom: int  # degrees of freedom at the start
    reach: dict[str, float]  # coordinate → largest less least value, in its unit
    costs: Costs  # of the second run, its time not measured yet


class TrialError(LinkwrightError):
    """A scene has no such quantity, or does not run; says why."""


def run_trial(machine: Machine, plan: Plan, quantity: Quantity) -> Trial:
    """Run a scene twice.

    Raises TrialError if it does not run to its end, and InputError if it has no such quantity.
    """
    try:
        freedom = _degrees_of_freedom(machine, plan)
        rough, fine = _run_twice(machine, plan)
    except InputError as error:
        raise TrialError("; ".join(error.problems)) from error
    for run in (rough, fine):
        if run.failed:
            raise TrialError(f"{run.description.title}: {run.message}")
    first, second = quantity.read(rough), quantity.read(fine)
    least = max(_ROUNDING, plan.rtol if plan.analysis == "simulate" else 0.0)
    doubt = abs(second.value - first.value) + least * max(abs(second.value), second.scale)
    spans = np.ptp(fine.samples.q, axis=0).tolist()
    reach = dict(zip(machine.coordinates.names, spans, strict=True))
    return Trial(machine, second, doubt, freedom, reach, count_costs(machine, fine))


def _degrees_of_freedom(machine: Machine, plan: Plan) -> int:
    """At the start; 0 of an equilibrium, whose start need not satisfy the constraints."""
    if plan.analysis == "equilibrium":
        return 0
    t = plan.t_start if plan.analysis == "simulate" else 0.0
    return machine.assemble(**plan.values(machine), t=t).degrees_of_freedom


def _run_twice(machine: Machine, plan: Plan) -> tuple[Result, Result]:
    """The run for comparison, and the run from which the quantity is taken."""
    rtol, points = min(COARSER * plan.rtol, 1e-3), plan.points
    rough = plan.run(machine, rtol=rtol, instants=plan.instants(points))
    if rough.failed:
        return rough, rough
    if plan.analysis == "equilibrium":
        q = rough.samples.q[0] + _PERTURBATION * (1.0 + np.abs(rough.samples.q[0]))
        near = dict(zip(machine.coordinates.names, q.tolist(), strict=True))
        again = replace(plan, guess={**plan.guess, **near})
        return rough, again.run(machine, rtol=rtol, instants=plan.instants(points))
    events = NONE
    if plan.analysis == "simulate" and rough.events:
        events = np.array([event.time for event in rough.events])
        instants = plan.instants(points, events, 4.0 * _BESIDE_EVENT)
        rough = plan.run(machine, rtol=rtol, instants=instants)
    instants = plan.instants(2 * points - 1, events, _BESIDE_EVENT)
    return rough, plan.run(machine, rtol=plan.rtol, instants=instants)


def count_costs(machine: Machine, run: Result) -> Costs:
    """Costs of a run: operations of its accelerations and in all, evaluations, steps and events."""
    operations = dict(machine.description.operations)
    evaluations, steps = (int(run.stats.get(name, 0)) for name in ("rhs_evaluations", "steps"))
    # Calls of `correction`: a simulation counts them by that name, kinematics as its iterations.
    corrections = int(run.stats.get("corrections", run.stats.get("newton_iterations", 0)))
    accelerations, total = operations.get("accelerations", 0), sum(operations.values())
    work = evaluations * accelerations + corrections * operations.get("correction", 0)
    return Costs(
        accelerations, total, evaluations, steps, len(run.events), work or total, seconds=math.nan
    )
