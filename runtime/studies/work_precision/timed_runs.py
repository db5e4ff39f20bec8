"""Runs of a scene in a setting, with a limit of time and steps; the integration alone is timed.

Assembly before the motion, and reactions and energies after it, take a millisecond, often more than
the motion: they do not count.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from runtime.core.outcomes import Outcome
from runtime.dynamics.simulation import simulate
from runtime.studies.timing import Stopwatch, TimeLimit, take_turns
from runtime.studies.work_precision.diagram import DONE, TIMEOUT, Setting

if TYPE_CHECKING:
    from runtime.integrate.problem import Correction, Formulation
    from runtime.machine import Machine
    from runtime.results.assembled_state import Assembly
    from runtime.results.result import Result

MOST = 30  # safety: runs by which a time is taken, however short

FloatArray = npt.NDArray[np.float64]


class Run(NamedTuple):
    """A run: its result, its outcome or "TIMEOUT", the processor time of its integration in s."""

    result: "Result"
    outcome: str
    seconds: float


@dataclass(frozen=True)
class Runner:
    """A scene, assembled and ready to be run in any setting.

    Attributes
    ----------
    begin
        Its assembled start.
    instants : (k,)
        At which it is compared, s.
    parameters
        By name, over its defaults.
    limit, steps
        Time in s and trial steps that a run may take.
    """

    machine: "Machine"
    begin: "Assembly"
    instants: FloatArray
    parameters: dict[str, float]
    limit: float
    steps: int

    def run(self, setting: Setting, rtol: float) -> Run:
        """Run once.

        Raises
        ------
        LinkwrightError
            If the scene cannot be run in this setting.
        """
        limit = TimeLimit(self.limit)
        result = simulate(
            self.machine.mechanism,
            float(self.instants[-1]),
            self.instants,
            t_start=self.begin.t,
            method=setting.method,
            rtol=rtol,
            parameters=self.parameters,
            start=self.begin,
            correction=cast("Correction", setting.correction),
            formulation=cast("Formulation", setting.formulation),
            max_steps=self.steps,
            progress=limit,
        )
        outcome = DONE if result.outcome is Outcome.OK else str(result.outcome)
        if result.outcome is Outcome.INTERRUPTED:
            if not limit.exceeded:
                raise KeyboardInterrupt  # by the user
            outcome = TIMEOUT
        return Run(result, outcome, result.stats["integration_seconds"])

    def stopwatch(self, setting: Setting, rtol: float, *times: float) -> Stopwatch:
        """Repeats a run; one that meets the limit of time has no time of a whole run."""

        def seconds() -> float | None:
            run = self.run(setting, rtol)
            return run.seconds if run.outcome == DONE else None

        return Stopwatch(seconds, *times)


def time_runs(watches: Sequence[Stopwatch], rounds: int, least: float) -> None:
    """Repeat runs in turns, until each was run often and long enough.

    Parameters
    ----------
    watches
        Each with the time of a first run, which counts only if it was long: a short one met cold
        caches.
    rounds, least
        Runs that each has at least, and their total time in s, for which `MOST` suffice. A run that
        takes that time alone is repeated once.
    """
    first = [list(watch.times) for watch in watches]
    for watch in watches:
        if watch.seconds < least:
            watch.times.clear()

    def finished(watch: Stopwatch) -> bool:
        enough = rounds if sum(watch.times) >= least else MOST
        return watch.seconds >= least or len(watch.times) >= enough

    take_turns(watches, finished)
    for watch, times in zip(watches, first, strict=True):
        watch.times = watch.times or times
