"""What a method without memory does after a step and at a new start: nothing."""

from runtime.core.jit import compiled
from runtime.core.signatures import HOOK, Integers, Vector
from runtime.core.workspace import Run


@compiled(HOOK)
def accepted(machine: Integers, t: float, h: float, w: Vector, run: Run) -> int:
    """Nothing is carried from one step to the next but the state and its derivative."""
    return 0


@compiled(HOOK)
def restart(machine: Integers, t: float, h: float, w: Vector, run: Run) -> int:
    """Nothing has to be forgotten."""
    return 0
