"""Two tables of addresses for the compiled loop: a machine's kernels, and the loop's own parts.

The order of a table stands here once: where it is made, and where a function is taken out of it.
"""

from functools import cache, lru_cache
from importlib import import_module
from types import ModuleType

from runtime.compiled import addresses, at
from runtime.constraints.correction import correct
from runtime.integrate import attempt, control, events, modes, outputs, watch
from runtime.integrate.problem import System
from runtime.integrate.signatures import (
    Accelerations,
    Correct,
    Correction,
    Dense,
    Error,
    Integers,
    Jacobian,
    Stages,
    Switching,
    SwitchingRates,
)

METHODS = ("dopri5", "dop853")
"""The explicit methods; each is a module of this package."""

accelerations_of = at(Accelerations, 0)
correction_of = at(Correction, 1)
jacobian_of = at(Jacobian, 2)
switching_of = at(Switching, 3)
switching_rates_of = at(SwitchingRates, 4)


@lru_cache(maxsize=64)
def kernel_table(system: System) -> Integers:
    """Addresses of a machine's kernels."""
    return addresses(
        (
            system.accelerations,
            system.correction,
            system.jacobian,
            system.switching,
            system.switching_rates,
        )
    )


correct_of = at(Correct, 0)
stages_of = at(Stages, 1)
error_of = at(Error, 2)
dense_of = at(Dense, 3)
attempt_of = at(attempt.Attempt, 4)
repartition_of = at(attempt.Repartition, 5)
locate_of = at(events.Locate, 6)
settle_of = at(modes.Settle, 7)
begin_of = at(modes.Settle, 8)
first_step_of = at(control.FirstStep, 9)
emit_of = at(outputs.Emit, 10)
watch_of = at(watch.Watch, 11)


def method(name: str) -> ModuleType:
    """The module of a method, compiled when it is first asked for."""
    return import_module(f"runtime.integrate.{name}")


@cache
def function_table(name: str) -> Integers:
    """Addresses of the parts of the loop, with those of the method `name`."""
    parts = method(name)
    return addresses(
        (
            correct,
            parts.stages,
            parts.error,
            parts.dense,
            attempt.attempt,
            attempt.repartition,
            events.locate,
            modes.settle,
            modes.begin,
            control.first_step,
            outputs.emit,
            watch.watch,
        )
    )
