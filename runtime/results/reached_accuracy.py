"""The estimated global error of a simulation, and how it was determined."""

from dataclasses import asdict, dataclass
from typing import Any

from runtime.results.json_values import plain


@dataclass(frozen=True)
class Estimate:
    """The global error of one quantity.

    Attributes
    ----------
    name
        Of the series.
    scale
        s of the error |y - r| / (s + |r|), in its unit.
    error
        The largest at the output instants, estimated.
    time
        Where that is, s.
    """

    name: str
    scale: float
    error: float
    time: float


@dataclass(frozen=True)
class Trial:
    """One of the runs behind an estimate.

    Attributes
    ----------
    seconds
        Processor time of the integration.
    evaluations, steps, events
        Calls of `accelerations`, accepted steps, changes of modes.
    outcome
        How it ended.
    difference
        Largest scaled difference from the run that it was compared with; None of the first.
    """

    method: str
    formulation: str
    rtol: float
    seconds: float
    evaluations: int
    steps: int
    events: int
    outcome: str
    difference: float | None


@dataclass(frozen=True)
class ReachedAccuracy:
    """The accuracy target of a simulation, and the accuracy reached.

    Attributes
    ----------
    asked
        The relative global error that was asked for.
    estimated
        The largest error of the quantities, to a factor of ten or so; of all the time that was
        asked for, also where the result ends at the horizon.
    quantities
        The estimate of each, the worst first.
    method, formulation, rtol
        Of the run that is the result.
    runs
        All runs, in their order.
    horizon
        Last output instant up to which the target is met, s; None where it is met at all of them.
    tenfold
        Time in which errors grow tenfold, s, where they grow exponentially; else None.
    means
        By what means it was found, in a sentence.
    seconds
        Processor time of all integrations.
    """

    asked: float
    estimated: float
    quantities: tuple[Estimate, ...]
    method: str
    formulation: str
    rtol: float
    runs: tuple[Trial, ...]
    horizon: float | None
    tenfold: float | None
    means: str
    seconds: float

    @property
    def reached(self) -> bool:
        """Whether the target is met over the whole run."""
        return self.horizon is None

    @property
    def chaotic(self) -> bool:
        """Whether errors grow exponentially."""
        return self.tenfold is not None

    @property
    def _taken(self) -> Trial:
        final = self.method, self.formulation, self.rtol
        return next(one for one in self.runs if (one.method, one.formulation, one.rtol) == final)

    def sentences(self) -> list[str]:
        """Sentences for a person."""
        worst = self.quantities[0]
        error = (
            f"Global error estimated as about {self.estimated:.1e}, {self.asked:.1e} asked; the "
            f"largest is that of {worst.name} at t = {worst.time:.6g} s."
        )
        cost = (
            f"Cost: {self.seconds * 1e3:.3g} ms of integration in {len(self.runs)} runs, this one "
            f"{self._taken.seconds * 1e3:.3g} ms. Taken: {self.method}, {self.formulation}, "
            f"rtol = {self.rtol:.1e}."
        )
        lines = [error, self.means, cost]
        if self.tenfold is not None:
            lines.append(f"Errors grow tenfold every {self.tenfold:.3g} s: the motion is chaotic.")
        return lines

    def facts(self) -> dict[str, Any]:
        """All of it as JSON knows it; what is no finite number becomes null."""
        found: dict[str, Any] = plain(asdict(self))
        return {**found, "reached": self.reached, "chaotic": self.chaotic}
