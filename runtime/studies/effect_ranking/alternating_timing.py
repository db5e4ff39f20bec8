"""Times of scenes against each other, on a machine that others use as well.

Processor time is counted and not time that passes: a run that is longer than a scheduler's slice is
interrupted nearly every time where processors are busy, a short one is not, and the longer would
look longer than it is. What others do to the caches only ever adds, so the least of many rounds is
kept, and every scene has its turn in each round.
"""

import math
from collections.abc import Sequence
from time import perf_counter, thread_time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from runtime.machine import Machine
    from runtime.studies.effect_ranking.trial_run import Plan

LEAST, MOST = 5, 40
"""Rounds, however long or short a run is."""
SECONDS = 3.0
"""Time for all rounds."""


def take_turns(machines: Sequence["Machine"], plan: "Plan", rounds: int | None) -> list[float]:
    """Least processor time in s of a run of each scene, from its call to its result.

    Parameters
    ----------
    rounds
        How many runs each scene has; what `SECONDS` allow, if None.
    """
    best = [math.inf] * len(machines)
    began = perf_counter()
    for done in range(rounds or MOST):
        if rounds is None and done >= LEAST and perf_counter() - began > SECONDS:
            break
        for k, machine in enumerate(machines):
            worked = thread_time()
            plan.run(machine, rtol=plan.rtol, instants=plan.instants(plan.points))
            best[k] = min(best[k], thread_time() - worked)
    return best
