"""A scene run for the sake of one number: how large, how far to be trusted, what it took.

Everything is run twice. The second time tolerances are a hundred times tighter, samples twice as
dense, and what jumps at an event is sampled on both sides of it; a rest is looked for once more
from where it was found. By how much the two answers differ is how far the second may be off.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError, LinkwrightError
from runtime.analyses.matters.answer import Costs
from runtime.analyses.matters.quantity import Quantity, Reading

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

    def instants(self, count: int, events: FloatArray | None = None) -> FloatArray:
        """Equally spaced instants, and those just before and after events."""
        even = np.linspace(self.t_start, self.t_end, count)
        if events is None or not len(events):
            return even
        beside = BESIDE * (self.t_end - self.t_start)
        more = np.concatenate([events - beside, events + beside])
        inside = more[(more > self.t_start) & (more < self.t_end)]
        return np.unique(np.concatenate([even, inside]))

    def timed(self, machine: "Machine") -> float:
        """Seconds of one run: of the integration, or where there is none of the whole analysis."""
        found = self.run(machine, rtol=self.rtol, instants=self.instants(self.points))
        return float(found.stats.get("integration_seconds", found.stats["wall_seconds"]))


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
        rough = plan.run(
            machine, rtol=min(COARSER * plan.rtol, 1e-3), instants=plan.instants(plan.points)
        )
        if not rough.failed:
            fine = _again(machine, plan, rough)
    except InputError as error:
        raise LostError("; ".join(error.problems)) from error
    for run in (rough, fine) if not rough.failed else (rough,):
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


def _again(machine: "Machine", plan: Plan, rough: "Result") -> "Result":
    """The run from which the quantity is taken."""
    if plan.analysis == "equilibrium":
        found = dict(zip(machine.coordinates.names, rough.samples.q[0].tolist(), strict=True))
        again = replace(plan, guess={**plan.guess, **found})
        return again.run(machine, rtol=plan.rtol, instants=plan.instants(1))
    events = None
    if plan.analysis == "simulate":
        events = np.array([event.time for event in rough.events])
    return plan.run(machine, rtol=plan.rtol, instants=plan.instants(2 * plan.points - 1, events))


def _costs(machine: "Machine", run: "Result") -> Costs:
    operations = dict(machine.description.operations)
    return Costs(
        accelerations=operations.get("accelerations", 0),
        operations=sum(operations.values()),
        evaluations=int(run.stats.get("rhs_evaluations", 0)),
        steps=int(run.stats.get("steps", 0)),
        events=len(run.events),
        seconds=math.nan,
    )


def take_turns(
    machines: list["Machine"], plan: Plan, rounds: int | None, clock: Callable[[], float]
) -> list[float]:
    """Least seconds of a run of each machine; in each round every one has its turn.

    Parameters
    ----------
    rounds
        How many; as many as fit into two seconds, 3 to 25, unless given.
    """
    best = [math.inf] * len(machines)
    began, done = clock(), 0
    while done < (rounds or 25):
        for k, machine in enumerate(machines):
            best[k] = min(best[k], plan.timed(machine))
        done += 1
        if rounds is None and done >= 3 and clock() - began > 2.0:
            break
    return best
