"""The instants at which a joint was released or engaged in a run."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from codegen.object_display import without_rounding
from runtime.results.assembled_state import State

_SHOWN = 4  # layout: changes of joints that a message tells


class Ending(NamedTuple):
    """The end of a part of a run, where a joint comes or goes."""

    row: int  # of WATCHED
    state: State
    discrete: Any  # where clocks and conditions stand
    length: float  # typical of the machine, m


class Reconnection(NamedTuple):
    """A joint that came or went."""

    time: float  # s
    joint: str
    action: str  # "release" or "engage"
    # component → impulse of the joint on its second body, N s or N m s; empty at a release
    impulse: dict[str, float]
    energy_lost: float  # kinetic energy that the impact took, J
    units: dict[str, str]  # component → unit of its impulse, "" of an expression without one

    def __str__(self) -> str:
        """In a sentence."""
        if self.action == "release":
            return f"Joint '{self.joint}' was released at t = {self.time:.9g} s."
        values = without_rounding(self.impulse.values())
        rows = zip(self.impulse, values, self.units.values(), strict=True)
        parts = ", ".join(f"{name} {value:.6g} {unit}".rstrip() for name, value, unit in rows)
        return (
            f"Joint '{self.joint}' engaged at t = {self.time:.9g} s with the impulse ({parts}), "
            f"which took {self.energy_lost:.6g} J."
        )


def sentences(changes: Sequence[Reconnection]) -> str:
    """What happened to the joints; of many changes the first and the last ones."""
    texts = [str(change) for change in changes]
    if len(texts) > _SHOWN:
        half = _SHOWN // 2
        rest = f"… {len(texts) - 2 * half} more changes, in `reconnections` …"
        texts = [*texts[:half], rest, *texts[-half:]]
    return " ".join(texts)
