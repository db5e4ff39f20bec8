"""Records of a run: the joints that came or went, and the accuracy that it reached."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

from codegen.object_display import without_rounding
from runtime.results.assembled_state import State
from runtime.results.samples import plain

_SHOWN = 4  # layout: changes of joints that a message tells


class Ending(NamedTuple):
    """The end of a part of a run, where a joint comes or goes."""

    row: int  # of WATCHED
    state: State  # with clocks and conditions
    length: float  # typical of the machine, m


class Reconnection(NamedTuple):
    """A joint that came or went."""

    time: float  # s
    joint: str
    action: str  # "release" or "engage"
    # component → impulse of the joint on its second body, N s or N m s; empty at a release
    impulse: dict[str, float]
    energy_lost: float  # kinetic energy that the impact took, J
    units: dict[str, str]  # component → unit of its impulse, "" of an expression without one

    def __str__(self) -> str:
        """In a sentence."""
        if self.action == "release":
            return f"Joint '{self.joint}' was released at t = {self.time:.9g} s."
        values = without_rounding(self.impulse.values())
        rows = zip(self.impulse, values, self.units.values(), strict=True)
        parts = ", ".join(f"{name} {value:.6g} {unit}".rstrip() for name, value, unit in rows)
        return (
            f"Joint '{self.joint}' engaged at t = {self.time:.9g} s with the impulse ({parts}), "
            f"which took {self.energy_lost:.6g} J."
        )


def sentences(changes: Sequence[Reconnection]) -> str:
    """What happened to the joints; of many changes the first and the last ones."""
    texts = [str(change) for change in changes]
    if len(texts) > _SHOWN:
        half = _SHOWN // 2
        rest = f"… {len(texts) - 2 * half} more changes, in `reconnections` …"
        texts = [*texts[:half], rest, *texts[-half:]]
    return " ".join(texts)


@dataclass(frozen=True)
class Estimate:
    """The global error of one quantity."""

    name: str  # of the series
    scale: float  # s in the error |y - r| / (s + |r|), in its unit
    error: float  # the largest at the output instants, as estimated
    time: float  # instant of the largest error, s


@dataclass(frozen=True)
class Trial:
    """One of the runs."""

    method: str
    formulation: str
    rtol: float
    seconds: float  # processor time of the integration
    evaluations: int  # calls of `accelerations`
    steps: int  # accepted ones
    events: int  # changes of modes
    outcome: str  # name of its `Outcome`
    # largest scaled one from the run with which it was compared; None for the first
    difference: float | None


@dataclass(frozen=True)
class ReachedAccuracy:
    """The accuracy target of a simulation, and the accuracy reached."""

    asked: float  # the target: the largest permitted relative global error
    # The largest error of the quantities, to a factor of ten or so; over the whole simulated time,
    # also where the result ends at the horizon.
    estimated: float
    quantities: tuple[Estimate, ...]  # the estimate of each, the worst first
    method: str  # as formulation and rtol: of the run that is the result
    formulation: str
    rtol: float
    runs: tuple[Trial, ...]  # all, in their order
    # last output instant up to which the target is met, s; None where it is met at all
    horizon: float | None
    tenfold: float | None  # time in which errors grow tenfold, s, if they grow exponentially
    means: str  # the evidence for the estimate, in a sentence
    seconds: float  # processor time of all integrations

    def __repr__(self) -> str:
        """Error, evidence and cost, a line each; `facts` has every number."""
        return "\n  ".join(self.sentences())

    @property
    def reached(self) -> bool:
        """Whether the target is met at all output instants."""
        return self.horizon is None

    @property
    def chaotic(self) -> bool:
        """Whether errors grow exponentially."""
        return self.tenfold is not None

    def sentences(self) -> list[str]:
        """Error, evidence and cost."""
        worst, settings = self.quantities[0], (self.method, self.formulation, self.rtol)
        delivered = next(
            run for run in self.runs if (run.method, run.formulation, run.rtol) == settings
        )
        error = (
            f"Global error estimated as about {self.estimated:.1e}, target {self.asked:.1e}; the "
            f"largest is that of {worst.name} at t = {worst.time:.6g} s."
        )
        cost = (
            f"Cost: {self.seconds * 1e3:.3g} ms of integration in {len(self.runs)} runs, this one "
            f"{delivered.seconds * 1e3:.3g} ms. Settings: {self.method}, {self.formulation}, "
            f"rtol = {self.rtol:.1e}."
        )
        lines = [error, self.means, cost]
        if self.tenfold is not None:
            lines.append(f"Errors grow tenfold every {self.tenfold:.3g} s: the motion is chaotic.")
        return lines

    def facts(self) -> dict[str, Any]:
        """All fields, as JSON; a number that is not finite is null."""
        facts: dict[str, Any] = plain(asdict(self))
        return {**facts, "reached": self.reached, "chaotic": self.chaotic}
