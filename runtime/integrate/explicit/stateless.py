"""What a method without memory does after a step and at a new start: nothing."""

from runtime.core.array_types import Integers
from runtime.core.function_table import HOOK
from runtime.core.jit import compiled


@compiled(HOOK)
def accepted(context: Integers, t: float, h: float) -> int:
    """Nothing is carried from one step to the next but the state and its derivative."""
    return 0


@compiled(HOOK)
def restart(context: Integers, t: float, h: float) -> int:
    """Nothing has to be forgotten."""
    return 0
