"""What a run takes over from a state of another run: scene, clocks and watched conditions.

Samples that wait for their delay act when they would have acted, and a condition that holds does
not begin to hold again. What the two runs do not have in common begins anew.
"""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from runtime.core.arrays import Vector
from runtime.integrate.clocks import queue_length, read_clocks, set_clocks
from runtime.integrate.problem import Discrete
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.mechanism.sibling_scenes import sibling_named
from runtime.results.assembled_state import DiscreteState, State
from runtime.results.result import Result

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


def scene_of_start(mechanism: Mechanism, start: object) -> Mechanism:
    """The mechanism with the joints that act in the state `start`, where these come and go.

    A state of any other scene, and values by name, leave the mechanism as it is.
    """
    state = start.state() if isinstance(start, Result) else start
    scene = state.scene if isinstance(state, State) else ""
    return sibling_named(mechanism, scene) or mechanism


def parameters_there(
    there: Mechanism, mechanism: Mechanism, parameters: Values | None
) -> Values | None:
    """Values of the parameters of `mechanism`, without those that only its other scenes need.

    `there` is the mechanism of the scene in which a run begins.
    """
    rows = there.description.watched
    if not parameters or there is mechanism or any(row.reconnects for row in rows):
        return parameters
    idle = {*there.description.unused} - {*mechanism.description.unused}
    return {name: value for name, value in parameters.items() if name not in idle}
