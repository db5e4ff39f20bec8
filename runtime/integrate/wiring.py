"""The table of addresses for one run, and the arrays that it points to."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from runtime.constraints import repartitioning as repartition
from runtime.constraints.newton_return import return_to_constraints
from runtime.core.array_types import Integers, Vector
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    CORRECTING,
    LOG_ROWS,
    LOOPS,
    METHOD_FLOATS_SIZE,
    METHOD_INTEGERS_SIZE,
    NONZEROS,
    PARAMETER_COUNT,
    PIVOT_SIZE,
    PLAN_SIZE,
    RANK,
    REACTION_ROWS,
    RECORD,
    RIGID_COUNT,
    SWITCHES,
    SWITCHING_SIZE,
    TABLE,
    WORKSPACE_SIZE,
)
from runtime.core.jit import addresses
from runtime.core.kernel_abi import KERNELS
from runtime.core.run_record import RUN
from runtime.core.system import System
from runtime.core.workspace import ROWS, SWITCH_ROWS
from runtime.hybrid import event_location, impact, mode_selection, sliding_rhs
from runtime.hybrid.event_resolution import screen_step
from runtime.hybrid.loop_branch_guard import guard_branches
from runtime.hybrid.mode_reactions import compute_friction_margin
from runtime.hybrid.mode_transition import change_modes
from runtime.hybrid.switching_functions import write_margins
from runtime.integrate import sampling as outputs
from runtime.integrate import step
from runtime.integrate import step_control as control
from runtime.integrate.method import find_method
from runtime.linalg.elimination_plan import plan_capacity
from runtime.singularity.detection import PIVOT_ROWS, predict_vanishing_pivot

METHOD_SLOTS = slice(TABLE.slots["stages"], TABLE.slots["correct"])
"""Slots of the method's functions."""

_LOOP_SLOTS = slice(TABLE.slots["correct"], TABLE.slots["guard_branches"] + 1)


class Wiring(NamedTuple):
    """A function table, and the arrays by name that must live as long as it."""

    table: Integers
    arrays: dict[str, Any]


@cache
def _loop() -> Integers:
    """Addresses of the parts of the loop, in the order of the function table from `correct` on."""
    return addresses(
        (
            return_to_constraints,
            step.take_trial_step,
            repartition.repartition,
            event_location.locate_event,
            event_location.sample_function,
            mode_selection.select_modes,
            mode_selection.initialize_modes,
            control.first_step,
            outputs.emit,
            screen_step,
            sliding_rhs.evaluate_modified_accelerations,
            sliding_rhs.evaluate_modified_rhs,
            impact.apply_impact,
            impact.return_to_surfaces,
            change_modes,
            compute_friction_margin,
            write_margins,
            predict_vanishing_pivot,
            guard_branches,
        )
    )


@cache
def function_table(name: str) -> Integers:
    """Addresses of the functions of the method `name`, in the order of the function table."""
    return addresses(find_method(name).functions)


@cache
def _kernels(system: System) -> Integers:
    """Addresses of a machine's kernels, in the order of the function table."""
    return system.table()


def wire(system: System, name: str, p: Vector, log_rows: int) -> Wiring:
    """Lay out the table of a run of `system` with the method `name`.

    Parameters
    ----------
    p
        Parameters and derived constants.
    log_rows
        Room for changes of the partition.
    """
    n, m, s = system.coordinates, system.constraint_count, system.switches
    nonzeros, loops = len(system.jacobian_rows), len(system.loop_rows)
    table = np.zeros(TABLE.size, np.int64)
    table[: len(KERNELS)] = _kernels(system)
    table[METHOD_SLOTS] = function_table(name)
    table[_LOOP_SLOTS] = _loop()
    memory, notes = find_method(name).memory(n)
    numbers = {
        COORDINATES: n,
        CONSTRAINT_COUNT: m,
        SWITCHES: s,
        RANK: system.rank,
        NONZEROS: nonzeros,
        PARAMETER_COUNT: p.size,
        RIGID_COUNT: len(system.rigid),
        REACTION_ROWS: system.reaction_rows,
        LOOPS: loops,
        PLAN_SIZE: plan_capacity(m, nonzeros),
        WORKSPACE_SIZE: 2 * n * ROWS,
        SWITCHING_SIZE: s * SWITCH_ROWS,
        PIVOT_SIZE: PIVOT_ROWS * m,
        METHOD_FLOATS_SIZE: memory,
        METHOD_INTEGERS_SIZE: notes,
        LOG_ROWS: log_rows,
        CORRECTING: 1,
    }
    table[list(numbers)] = list(numbers.values())
    arrays = TABLE.allot(table)
    place(table, arrays, "parameters", p)
    place(table, arrays, "jacobian_rows", np.ascontiguousarray(system.jacobian_rows, np.int64))
    columns = np.ascontiguousarray(system.jacobian_columns, np.int64)
    place(table, arrays, "jacobian_columns", columns)
    record = arrays["record"] = np.zeros(1, RUN)
    table[RECORD] = record.ctypes.data
    arrays["row_order"][:], arrays["column_order"][:] = np.arange(m), np.arange(n)
    arrays["recent_events"][:] = -np.inf
    if loops:
        arrays["loop_rows"][:] = system.loop_rows
    if s:
        _describe_switches(system, p, arrays)
    return Wiring(table, arrays)


def place(table: Integers, arrays: dict[str, Any], name: str, array: Any) -> None:
    """Put an array that was made elsewhere into a table."""
    arrays[name] = array
    table[TABLE.slots[name]] = array.ctypes.data


def _describe_switches(system: System, p: Vector, arrays: dict[str, Any]) -> None:
    """Fill in what is known of the switching functions before a run."""
    low, high = arrays["share_low"], arrays["share_high"]
    arrays["rigid"][:], arrays["limits"][:], arrays["stiction_place"][:] = -1, -1, -1
    arrays["rigid"][list(system.rigid)] = np.arange(len(system.rigid))
    arrays["sticks"][list(system.sticking)] = 1
    arrays["share"][:], arrays["stiction_units"][:], high[:] = np.nan, 1.0, 1.0
    for k, force, limit in system.limits:
        arrays["limits"][2 * k : 2 * k + 2] = force, limit
    system.holds(p, low, high)
    for k, slot in system.stiction:
        arrays["stiction_place"][k] = slot
        # Shares are of a force in units, from no force.
        reach = high[k] - low[k]
        low[k], high[k] = -reach, reach
    system.restitution(p, arrays["restitution"])
