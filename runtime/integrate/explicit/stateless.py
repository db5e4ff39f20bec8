"""Hooks of a method without memory: nothing is done after a step, or at a new start."""

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
