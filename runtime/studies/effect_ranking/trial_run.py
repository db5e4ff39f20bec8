"""A scene run for the sake of one number: how large, how far to be trusted, what it took.

Everything is run twice, the second time with tolerances a hundred times tighter and samples twice
as dense. What jumps at an event is sampled on both sides of it, the second time nearer to it. A
rest is looked for once more from close by. By how much the two answers differ is how far the second
may be off.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError, LinkwrightError
from runtime.studies.effect_ranking.quantity import Quantity, Reading
from runtime.studies.effect_ranking.ranking import Costs

if TYPE_CHECKING:
    from runtime.machine import Machine
    from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]

ANALYSES = ("simulate", "kinematics", "inverse", "equilibrium")
COARSER = 100.0
"""Times the tolerance with which the first of two runs is made."""
LEAST_RTOL = 1e-13
BESIDE = 1e-7
"""Share of the run by which samples lie before and after an event."""
ASIDE = 1e-4
"""Share by which a rest is looked for once more from beside the one that was found."""
FLOOR = 1e-12
"""Share of a quantity that rounding may take, however well two runs agree."""


@dataclass(frozen=True)
class Plan:
    """How every scene is run.

    Attributes
    ----------
    analysis
        One of `ANALYSES`.
    points
        Output instants of the first run, and of those that are timed.
    rtol
        Relative tolerance of the second run, and of those that are timed.
    parameters, guess
        By name; a scene gets those that it has.
    """

    analysis: str
    t_start: float
    t_end: float
    points: int
    rtol: float
    method: str
    parameters: Mapping[str, float] = field(default_factory=dict)
    guess: Mapping[str, float] = field(default_factory=dict)

    def run(self, machine: "Machine", *, rtol: float, instants: FloatArray) -> "Result":
        """The analysis of a machine, with what it has of the parameters and the guess."""
        about: dict[str, Any] = {
            "parameters": self.parameters_of(machine),
            "guess": self.guess_of(machine),
            "progress": False,
        }
        match self.analysis:
            case "simulate":
                return machine.simulate(
                    self.t_end, instants, t_start=self.t_start, method=self.method, rtol=rtol,
                    **about,
                )  # fmt: skip
            case "kinematics":
                return machine.kinematics(instants, **about)
            case "inverse":
                return machine.inverse_dynamics(instants, **about)
            case _:
                return machine.equilibrium(**about, t=self.t_start)

    def parameters_of(self, machine: "Machine") -> dict[str, float]:
        """The parameters, as far as the scene has them."""
        return {k: x for k, x in self.parameters.items() if k in machine.parameters.names}

    def guess_of(self, machine: "Machine") -> dict[str, float]:
        """The guess, as far as the scene has its coordinates."""
        rows = machine.coordinates
        states = {*rows.names, *(row.velocity for row in rows)}
        return {k: x for k, x in self.guess.items() if k in states}

    def instants(
        self, count: int, events: FloatArray | None = None, beside: float = 0.0
    ) -> FloatArray:
        """Equally spaced instants, and those before and after events by a share of the run."""
        even = np.linspace(self.t_start, self.t_end, count)
        if events is None or not len(events):
            return even
        step = beside * (self.t_end - self.t_start)
        more = np.concatenate([events - step, events + step])
        inside = more[(more > self.t_start) & (more < self.t_end)]
        return np.unique(np.concatenate([even, inside]))


@dataclass(frozen=True)
class Trial:
    """A scene that was run.

    Attributes
    ----------
    reading, doubt
        The quantity, and by how much it may be off.
    freedom
        Degrees of freedom at the start.
    reach
        Coordinate → largest less least value, in its unit.
    costs
        Of the second run, its time not measured yet.
    """

    machine: "Machine"
    reading: Reading
    doubt: float
    freedom: int
    reach: dict[str, float]
    costs: Costs


class LostError(LinkwrightError):
    """A scene has no such quantity, or does not run; says why."""


def tried(machine: "Machine", plan: Plan, asked: Quantity) -> Trial:
    """Run a scene twice.

    Raises
    ------
    LostError
        If it cannot be run, or does not run to its end.
    InputError
        If it has no such quantity.
    """
    try:
        freedom = _freedom(machine, plan)
        rough, fine = _twice(machine, plan)
    except InputError as error:
        raise LostError("; ".join(error.problems)) from error
    for run in (rough, fine):
        if run.failed:
            raise LostError(f"{run.description.title}: {run.message}")
    first, second = asked.read(rough), asked.read(fine)
    floor = max(FLOOR, plan.rtol if plan.analysis == "simulate" else 0.0)
    doubt = abs(second.value - first.value) + floor * max(abs(second.value), second.scale)
    reach = np.ptp(fine.samples.q, axis=0)
    return Trial(
        machine,
        second,
        doubt,
        freedom,
        dict(zip(machine.coordinates.names, reach.tolist(), strict=True)),
        _costs(machine, fine),
    )


def _freedom(machine: "Machine", plan: Plan) -> int:
    """Degrees of freedom at the start; of a rest, whose start need not hold, none are counted."""
    if plan.analysis == "equilibrium":
        return 0
    t = plan.t_start if plan.analysis == "simulate" else 0.0
    start = machine.assemble(plan.guess_of(machine), plan.parameters_of(machine), t)
    return start.degrees_of_freedom


def _twice(machine: "Machine", plan: Plan) -> tuple["Result", "Result"]:
    """The run that is compared with, and that from which the quantity is taken."""
    rtol, points = min(COARSER * plan.rtol, 1e-3), plan.points
    rough = plan.run(machine, rtol=rtol, instants=plan.instants(points))
    if rough.failed:
        return rough, rough
    if plan.analysis == "equilibrium":
        q = rough.samples.q[0] + ASIDE * (1.0 + np.abs(rough.samples.q[0]))
        near = dict(zip(machine.coordinates.names, q.tolist(), strict=True))
        again = replace(plan, guess={**plan.guess, **near})
        return rough, again.run(machine, rtol=rtol, instants=plan.instants(points))
    events = np.array([event.time for event in rough.events])
    if plan.analysis == "simulate" and len(events):
        rough = plan.run(machine, rtol=rtol, instants=plan.instants(points, events, 4.0 * BESIDE))
    else:
        events = np.zeros(0)
    instants = plan.instants(2 * points - 1, events, BESIDE)
    return rough, plan.run(machine, rtol=plan.rtol, instants=instants)


def _costs(machine: "Machine", run: "Result") -> Costs:
    operations = dict(machine.description.operations)
    evaluations = int(run.stats.get("rhs_evaluations", 0))
    iterations = int(run.stats.get("newton_iterations", 0))
    work = evaluations * operations.get("accelerations", 0)
    work += iterations * operations.get("correction", 0)
    return Costs(
        accelerations=operations.get("accelerations", 0),
        operations=sum(operations.values()),
        evaluations=evaluations,
        steps=int(run.stats.get("steps", 0)),
        events=len(run.events),
        work=work or sum(operations.values()),
        seconds=math.nan,
    )
