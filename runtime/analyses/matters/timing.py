"""Times of scenes against each other, on a machine that others use as well.

What others do only ever adds to a time, so the least of many rounds is kept, and every scene has
its turn in each round. But a run that is longer than a scheduler's slice is interrupted nearly
every time where processors are busy, and a short one is not: the longer would look longer than it
is. A run counts as undisturbed if the processor worked on it nearly all the time that it took.
"""

import math
from collections.abc import Sequence
from time import perf_counter, thread_time
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from runtime.analyses.matters.trial import Plan
    from runtime.machine import Machine

UNDISTURBED = 0.97
"""Share of a run's time that the processor works on it."""
ENOUGH = 3
"""Undisturbed runs of every scene, at least, while patience lasts."""
USUAL, MOST = 25, 100
"""Rounds where all is calm, and at most."""
SECONDS, PATIENCE = 2.0, 6.0
"""Time for all rounds where all is calm, and at most."""


class Turns(NamedTuple):
    """Least seconds of a run of each scene, and which of them were never run undisturbed."""

    seconds: list[float]
    disturbed: list[int]


def take_turns(machines: Sequence["Machine"], plan: "Plan", rounds: int | None) -> Turns:
    """Run every scene once a round; `rounds` of them, or what patience allows."""
    calm: list[list[float]] = [[] for _ in machines]
    least = [math.inf] * len(machines)
    began = perf_counter()
    for done in range(rounds or MOST):
        spent = perf_counter() - began
        over = done >= USUAL or spent > SECONDS
        settled = over and all(len(times) >= ENOUGH for times in calm)
        if rounds is None and done >= ENOUGH and (settled or spent > PATIENCE):
            break
        for k, machine in enumerate(machines):
            seconds, undisturbed = _timed(machine, plan)
            least[k] = min(least[k], seconds)
            if undisturbed:
                calm[k].append(seconds)
    best = [min(times, default=other) for times, other in zip(calm, least, strict=True)]
    return Turns(best, [k for k, times in enumerate(calm) if not times])


def _timed(machine: "Machine", plan: "Plan") -> tuple[float, bool]:
    """Seconds of one run, of the integration where there is one; whether it was undisturbed."""
    began, worked = perf_counter(), thread_time()
    found = plan.run(machine, rtol=plan.rtol, instants=plan.instants(plan.points))
    worked, took = thread_time() - worked, perf_counter() - began
    seconds = found.stats.get("integration_seconds", found.stats["wall_seconds"])
    return float(seconds), worked >= UNDISTURBED * took
