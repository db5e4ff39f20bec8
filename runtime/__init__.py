"""Linkwright's runtime: loads a generated module and answers the engineer's four questions with it.

    from runtime import load

    machine = load("slider_crank", scene="compressor")
    result = machine.simulate(t_end=1.0)

Importing this package loads neither numba nor the code generator; `load` does what it needs.
"""

from typing import TYPE_CHECKING, Any

from runtime.load import load

if TYPE_CHECKING:
    from runtime.analyses.matters import matters
    from runtime.analyses.precision import accuracy
    from runtime.machine import Machine
    from runtime.outcomes import Outcome
    from runtime.results.result import Result

_HOMES = {
    "Machine": "runtime.machine",
    "Outcome": "runtime.outcomes",
    "Result": "runtime.results.result",
    "accuracy": "runtime.analyses.precision",
    "matters": "runtime.analyses.matters",
}

__all__ = ["Machine", "Outcome", "Result", "accuracy", "load", "matters"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'runtime' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value
