"""Runs of a scene in a setting, with a limit of time and steps; the integration alone is timed.

Assembly before the motion, and reactions and energies after it, take a millisecond, often more than
the motion: they do not count.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any

from runtime.core.outcomes import Outcome
from runtime.dynamics.connected_simulation import simulate
from runtime.dynamics.output_conditions import read_conditions, simulate_until
from runtime.machine_facade import Machine
from runtime.results.assembled_state import Assembly
from runtime.results.result import Result
from runtime.studies.series_by_name import FloatArray
from runtime.studies.simulation_arguments import arguments_of_variant
from runtime.studies.timing import Stopwatch, TimeLimit, take_turns
from runtime.studies.work_precision.diagram import Setting

TIMEOUT, NOT_TRIED, OTHER_END = "TIMEOUT", "NOT_TRIED", "OTHER_END"
TIME = "integration_seconds"  # entry of `Result.stats`
MOST = 30  # safety: runs by which a time is taken, however short


@dataclass(frozen=True)
class Runner:
    """A scene, assembled and ready to be run in any setting."""

    machine: Machine
    begin: Assembly
    instants: FloatArray  # at which it is compared, s, (k,)
    parameters: dict[str, float]  # over the scene's defaults
    limit: float  # time of a run, s
    steps: int  # trial steps of a run
    # of `Machine.simulate`, besides
    words: Mapping[str, Any] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """MODEL/SCENE."""
        return self.machine.description.title

    def run(self, setting: Setting, rtol: float) -> Result:
        """Run once; `Outcome.INTERRUPTED` is a run that the limit of time ended."""
        others = any(row.reconnects for row in self.machine.description.watched)
        for _ in range(2 if others else 1):  # in the first run scenes that follow may be built
            limit = TimeLimit(self.limit)
            words = arguments_of_variant(self.machine, self.words)
            until = words.pop("until", None)
            given = {
                "t_end": float(self.instants[-1]), "t_eval": self.instants, "rtol": rtol,
                "t_start": self.begin.t, "parameters": self.parameters, "start": self.begin,
                "step_limit": self.steps, "progress": limit, **asdict(setting), **words,
            }  # fmt: skip
            analyse = partial(simulate, self.machine.mechanism)
            if until is None:
                result = analyse(**given)
            else:
                conditions = read_conditions(self.machine.description, until)
                result = simulate_until(analyse, conditions, given)
            if not limit.exceeded:
                break
        if result.outcome is Outcome.INTERRUPTED and not limit.exceeded:
            raise KeyboardInterrupt  # by the user
        return result

    def stopwatch(self, setting: Setting, rtol: float, *times: float) -> Stopwatch:
        """Repeats a run; one that does not reach its end has no time of a whole run."""

        def seconds() -> float | None:
            result = self.run(setting, rtol)
            return None if result.failed else result.stats[TIME]

        return Stopwatch(seconds, *times)


def outcome_name(result: Result) -> str:
    """The name of the `Outcome`, or "TIMEOUT": the limit of time alone interrupts a run."""
    return TIMEOUT if result.outcome is Outcome.INTERRUPTED else str(result.outcome)


def time_runs(watches: Sequence[Stopwatch], rounds: int, least: float) -> None:
    """Repeat runs in turns, until each was run `rounds` times and for `least` s, or `MOST` times.

    Each has the time of a first run, which counts only if it was long: a short one met cold caches.
    A run that takes `least` alone is repeated once.
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
