"""The equations of the floor in another arithmetic: symbols, another tool, more digits."""

from collections.abc import Callable
from types import FunctionType
from typing import Any


def in_terms_of(equation: Any, mathematics: Any) -> Callable[..., Any]:
    """A compiled equation as a plain function of whatever `mathematics` has sin, cos, sqrt for."""
    python = getattr(equation, "py_func", equation)
    space = {
        name: in_terms_of(value, mathematics) if hasattr(value, "py_func") else value
        for name, value in python.__globals__.items()
        if name in python.__code__.co_names
    }
    space["math"] = mathematics
    return FunctionType(python.__code__, space, python.__name__, python.__defaults__)
