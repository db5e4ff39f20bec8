"""The table of addresses for one run, and the arrays that it points to."""

from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from runtime.compiled import addresses
from runtime.constraints.correction import correct
from runtime.integrate import attempt, bent, control, events, modes, outputs, watch
from runtime.integrate.problem import System
from runtime.integrate.signatures import Integers
from runtime.integrate.slots import Slot

METHODS = ("dopri5", "dop853", "bdf", "radau5", "auto")
"""The methods; each is a module of this package."""

IMPLICIT = ("bdf", "radau5", "auto")
"""Those that need derivatives of the kernels, at times or throughout."""

_METHOD = ("stages", "error", "dense", "propose", "accepted", "restart")


class Wiring(NamedTuple):
    """A table and what must live as long as it."""

    table: Integers
    arrays: tuple[Any, ...]
    log_times: Any
    log_sets: Any


def method(name: str) -> ModuleType:
    """The module of a method, compiled when it is first asked for."""
    return import_module(f"runtime.integrate.{name}")


@cache
def _loop() -> Integers:
    """Addresses of the parts of the loop, in the order of `Slot` from CORRECT on."""
    return addresses(
        (
            correct,
            attempt.attempt,
            attempt.repartition,
            events.locate,
            modes.settle,
            modes.begin,
            control.first_step,
            outputs.emit,
            watch.watch,
            bent.bent,
        )
    )


@cache
def function_table(name: str) -> Integers:
    """Addresses of the functions of the method `name`, in the order of `Slot` from STAGES on."""
    parts = method(name)
    return addresses(getattr(parts, part) for part in _METHOD)


@cache
def _kernels(system: System) -> Integers:
    """Addresses of a machine's kernels, in the order of `Slot`."""
    return addresses(getattr(system, slot.name.lower()) for slot in Slot if slot < Slot.STAGES)


def wire(system: System, name: str, log_rows: int) -> Wiring:
    """Lay out the table of a run of `system` with the method `name`.

    Parameters
    ----------
    log_rows
        Room for changes of the partition.
    """
    n, m = system.coordinates, system.constraint_count
    table = np.zeros(len(Slot), np.int64)
    kernels, parts, loop = _kernels(system), function_table(name), _loop()
    table[: kernels.size] = kernels
    table[Slot.STAGES : Slot.STAGES + parts.size] = parts
    table[Slot.CORRECT : Slot.CORRECT + loop.size] = loop
    memory, notes = getattr(method(name), "memory", _no_memory)(n)
    nonzeros = len(system.jacobian_rows)
    arrays = {
        Slot.JACOBIAN_ROWS: np.ascontiguousarray(system.jacobian_rows, dtype=np.int64),
        Slot.JACOBIAN_COLUMNS: np.ascontiguousarray(system.jacobian_columns, dtype=np.int64),
        Slot.JACOBIAN_VALUES: np.zeros(nonzeros),
        Slot.DENSE_JACOBIAN: np.zeros((m, n)),
        Slot.ROW_ORDER: np.arange(m),
        Slot.COLUMN_ORDER: np.arange(n),
        Slot.LOG_TIMES: np.zeros(log_rows),
        Slot.LOG_SETS: np.zeros((log_rows, n), np.int64),
        Slot.MEMORY: np.zeros(memory),
        Slot.NOTES: np.zeros(notes, np.int64),
    }
    for slot, array in arrays.items():
        table[slot] = array.ctypes.data
    table[Slot.COORDINATES], table[Slot.CONSTRAINT_COUNT] = n, m
    table[Slot.SWITCHES], table[Slot.NONZEROS] = system.switches, nonzeros
    table[Slot.LOG_ROWS] = log_rows
    table[Slot.CORRECTING] = 1
    return Wiring(table, tuple(arrays.values()), arrays[Slot.LOG_TIMES], arrays[Slot.LOG_SETS])


def _no_memory(n: int) -> tuple[int, int]:
    return 0, 0
