"""Clocks and watched conditions at the start of a run that goes on from a state of another run.

Samples that wait for their delay act when they would have acted, and a condition that holds does
not begin to hold again. What the two runs do not have in common begins anew.
"""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from runtime.core.array_types import Vector
from runtime.integrate.clocks import queue_length, read_clocks, set_clocks
from runtime.integrate.problem import Discrete
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.results.assembled_state import State
from runtime.results.discrete_state import DiscreteState

Row = TypeVar("Row")


def discrete_state(mechanism: Mechanism, p: Vector, stand: Discrete | None) -> DiscreteState | None:
    """Where clocks and conditions of a run with the parameters p, (np,), stand, by their names."""
    if stand is None:
        return None
    description = mechanism.description
    return DiscreteState(
        description.scene, description.sampled, read_clocks(mechanism.system, p),
        tuple(row[:3] for row in description.watched), stand,
    )  # fmt: skip


def discrete_at_start(
    mechanism: Mechanism, p: Vector, start: State
) -> tuple[Discrete | None, list[str]]:
    """What a run takes over from the state, and values whose waiting samples it does not."""
    description, given = mechanism.description, start.discrete
    clocks = read_clocks(mechanism.system, p)
    if given is None:
        return None, [name for name, clock in zip(description.sampled, clocks, strict=True)
                      if clock[1] > 0.0]  # fmt: skip
    if not (description.sampled or description.watched):
        return None, []
    count, queue = len(clocks), queue_length(clocks)
    ticks, waiting, lost = np.zeros((count, 2), np.int64), np.zeros((count, queue)), list[str]()
    rows = {key: j for j, key in enumerate(numbered(given.sampled))}
    for k, key in enumerate(numbered(description.sampled)):
        j = rows.get(key)
        known = j is not None
        set_clocks(start.t, clocks[k : k + 1], ticks[k], taken=start.sampled and known)
        if j is None:
            continue
        following, acting = given.stand.ticks.reshape(-1, 2)[j]
        if np.array_equal(clocks[k], given.clocks[j]):
            ticks[k] = following, acting
            for number in range(acting, following):
                sample = given.stand.waiting[j, number % given.stand.waiting.shape[1]]
                waiting[k, number % queue] = sample
        elif acting < following:
            lost.append(description.sampled[k])
    held = dict(zip(numbered(given.watched), given.stand.held.tolist(), strict=True))
    same = given.scene == description.scene  # else with other joints, which come or go anew
    keys = numbered([row[:3] for row in description.watched])
    holds = [
        held.get(key, 0.0) if same or not row.reconnects else 0.0
        for key, row in zip(keys, description.watched, strict=True)
    ]
    return Discrete(ticks.ravel(), waiting, np.array(holds, np.float64)), lost


def numbered(rows: Sequence[Row]) -> list[tuple[Row, int]]:
    """Each row, with how often it stood there before: a latch has two of its name."""
    return [(row, rows[:k].count(row)) for k, row in enumerate(rows)]
