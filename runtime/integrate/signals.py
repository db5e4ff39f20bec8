"""What the parts of a step tell the loop, and the loop its caller."""

from enum import IntEnum

from runtime.core.array_types import Integers
from runtime.core.jit import inner
from runtime.core.run_record import run_record


class Signal(IntEnum):
    """How a run goes on; codes of outcomes, which are not negative, end it."""

    GOING = -1
    """The run is not over."""

    LOOK = -2
    """A singular configuration has to be looked at, see `singular_crossing`."""

    CHANGE = -3
    """Another method is due."""

    PROCEED = -4
    """The step goes on with its next part."""

    RETRY = -5
    """The step is not taken; the next one is shorter."""


UNFINISHED = (Signal.GOING, Signal.LOOK, Signal.CHANGE)
"""Those that the loop returns."""


@inner
def reject(context: Integers, reason: int, next_length: float) -> None:
    """Count a rejected step, and set the length of the next one."""
    r = run_record(context)
    r.rejected += 1
    r.reason = reason
    r.rejected_before = 1
    r.h = next_length
