"""What contacts, frictions and freewheels do at an event, in a word."""

import re
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from runtime.core.modes_and_event_kinds import SLIDING, Direction
from runtime.mechanism.module_tables import Description

_CONTACTS = ("contact", "stop", "clearance joint", "gear with backlash")  # springs along gaps
_RIGID = {
    Direction.BEGAN: "leaves", Direction.CEASED: "touches", Direction.HOLDS: "rests",
    Direction.IMPACT: "touches",
}  # fmt: skip
_FREEWHEEL = {
    Direction.BEGAN: "overruns", Direction.HOLDS: "grips", Direction.IMPACT: "strikes",
}  # fmt: skip
_WORD = re.compile(r"\w+")


class _Springs:
    """What springs along gaps do: they push while a gap is closed and no damper outweighs them."""

    def __init__(self, description: Description, modes: Sequence[int]) -> None:
        rates = {row.velocity.replace(".", "_") for row in description.coordinates}
        self.holds = {k: mode != 0 for k, mode in enumerate(modes)}
        self.sides: dict[int, tuple[int, ...]] = {}  # switch → those of its side, the gap's first
        for effect in description.effects:
            own = [k for k, row in enumerate(description.switches) if row.name == effect.name]
            if effect.kind not in _CONTACTS:
                continue
            bounds = [k for k in own if rates & {*_WORD.findall(description.switches[k].condition)}]
            gaps = [k for k in own if k not in bounds]
            paired = len(bounds) == len(gaps)
            for number, gap in enumerate(gaps):
                side = (gap, bounds[number]) if paired else (gap,)
                self.sides |= dict.fromkeys(side, side)

    def word(self, switch: int, direction: int) -> str:
        """The word for an event, which is noted; empty where nothing pushes or ceases to."""
        side = self.sides.get(switch, (switch,))
        pushed = all(self.holds.get(k, False) for k in side)
        self.holds[switch] = direction != Direction.CEASED
        pushes = all(self.holds.get(k, False) for k in side)
        if direction == Direction.HOLDS:
            return "rests"
        if pushes != pushed:
            return "touches" if pushes else "leaves"
        if switch != side[0]:
            return ""
        return "closes" if self.holds[switch] else "opens"


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
    springs = _Springs(description, modes)
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
            word = springs.word(k, direction)
        words.append(word)
    return words
