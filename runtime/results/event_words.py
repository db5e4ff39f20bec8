"""What contacts, frictions and freewheels do at an event, in a word."""

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from runtime.core.modes_and_event_kinds import SLIDING, Direction
from runtime.mechanism.module_tables import Description

_CONTACTS = ("contact", "stop", "clearance joint")  # effects whose one condition is that they touch
_RIGID = {
    Direction.BEGAN: "leaves", Direction.CEASED: "touches", Direction.HOLDS: "rests",
    Direction.IMPACT: "touches",
}  # fmt: skip
_FREEWHEEL = {
    Direction.BEGAN: "overruns", Direction.HOLDS: "grips", Direction.IMPACT: "strikes",
}  # fmt: skip
_SOFT = {Direction.BEGAN: "touches", Direction.CEASED: "leaves", Direction.HOLDS: "rests"}


def event_words(
    description: Description, switches: Iterable[int], directions: Iterable[int],
    first_modes: npt.NDArray[np.int64],
) -> list[str]:  # fmt: skip
    """A word for each event, in their order; empty where its condition says more.

    `first_modes`, (1, s) or empty, are those in which the run began.
    """
    kinds = {row.name: row.kind for row in description.effects}
    modes = first_modes[0].tolist() if len(first_modes) else []
    stuck = {k: mode == SLIDING for k, mode in enumerate(modes)}
    words = []
    for k, direction in zip(map(int, switches), map(int, directions), strict=True):
        row = description.switches[k] if k < len(description.switches) else None
        word = ""
        if row is not None and row.kind == "contact":
            word = _RIGID.get(Direction(direction), "")
        elif row is not None and row.one_way:
            word = _FREEWHEEL.get(Direction(direction), "")
        elif row is not None and row.sticks:
            held, stuck[k] = stuck.get(k, False), direction == Direction.HOLDS
            word = "sticks" if stuck[k] else "slips" if held else "reverses"
        elif row is not None and kinds.get(row.name) in _CONTACTS:
            word = _SOFT.get(Direction(direction), "")
        words.append(word)
    return words
