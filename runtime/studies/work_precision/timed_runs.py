"""One run of a scene: with a limit of time, and the processor time that its integration takes.

What a run is asked for beside the motion (assembly before it, reactions and energies after it)
takes a millisecond, often more than the motion: it is not counted.
"""

import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, cast

import numpy as np
import numpy.typing as npt

from runtime.core.outcomes import Outcome
from runtime.dynamics.simulation import simulate
from runtime.studies.work_precision.diagram import DONE, TIMEOUT, Setting

if TYPE_CHECKING:
    from runtime.integrate.problem import Correction, Formulation
    from runtime.machine import Machine
    from runtime.results.assembled_state import Assembly
    from runtime.results.result import Result

MOST = 30
"""Runs by which a time is taken, however short."""

FloatArray = npt.NDArray[np.float64]


class Stopwatch:
    """Times of a setting at a tolerance."""

    def __init__(self) -> None:
        self.times: list[float] = []

    @property
    def seconds(self) -> float:
        """The least: what others do to the caches only ever adds."""
        return min(self.times)

    @property
    def spread(self) -> float:
        """The median of the runs over the least."""
        return statistics.median(self.times) / self.seconds


class _Patience:
    """Ends a run that takes too long from its first sign of life on, once all is compiled."""

    def __init__(self, limit: float) -> None:
        self.limit, self.lost = limit, False
        self.began: float | None = None

    def __call__(self, fraction: float) -> None:
        if self.began is None:
            self.began = perf_counter()
        elif perf_counter() - self.began > self.limit:
            self.lost = True
            raise KeyboardInterrupt  # ends the run with what it has


@dataclass(frozen=True)
class Runner:
    """A scene, assembled and ready to be run in any setting.

    Attributes
    ----------
    begin
        Its start.
    instants : (k,)
        At which it is compared.
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

    def run(self, setting: Setting, rtol: float, watch: Stopwatch) -> tuple["Result", str]:
        """Run once; the result, and its outcome or "TIMEOUT".

        Raises
        ------
        LinkwrightError
            If the scene cannot be run so.
        """
        patience = _Patience(self.limit)

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
            progress=patience,
        )
        watch.times.append(result.stats["integration_seconds"])
        if result.outcome is Outcome.OK:
            return result, DONE
        if result.outcome is not Outcome.INTERRUPTED:
            return result, str(result.outcome)
        if not patience.lost:
            raise KeyboardInterrupt  # the user's own
        return result, TIMEOUT


def take_turns(
    runner: Runner, runs: Sequence[tuple[Setting, float, Stopwatch]], rounds: int, least: float
) -> None:
    """Run all once more in turns, until each has so many runs and so much time.

    What others do to the caches lasts a while; runs of a setting that lie apart do not all meet it.

    Parameters
    ----------
    rounds, least
        Runs that each has at least, and their time in s, for which `MOST` suffice. One that takes
        that time alone has two.
    """
    waiting = list(runs)
    for _, _, watch in waiting:
        if watch.seconds < least:
            watch.times.clear()
    while waiting:
        lost = []
        for setting, rtol, watch in waiting:
            _, outcome = runner.run(setting, rtol, watch)
            if outcome != DONE:
                # Others had the processor until the limit: that is not the time of a whole run.
                lost.append(watch)
                if len(watch.times) > 1:
                    watch.times.pop()
        waiting = [
            (setting, rtol, watch)
            for setting, rtol, watch in waiting
            if watch not in lost
            and len(watch.times) < (MOST if sum(watch.times) < least else rounds)
            and watch.seconds < least
        ]
