"""The table of addresses for one run, and the arrays that it points to."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from runtime.constraints import repartitioning as repartition
from runtime.constraints.newton_return import correct
from runtime.core.function_table import Slot
from runtime.core.jit import addresses
from runtime.core.signatures import Integers, Vector
from runtime.core.system import System
from runtime.hybrid import event_location as events
from runtime.hybrid import event_resolution as watch
from runtime.hybrid import impact
from runtime.hybrid import loop_branch_guard as dead_centres
from runtime.hybrid import mode_reactions as mixing
from runtime.hybrid import mode_selection as modes
from runtime.hybrid import mode_transition as transition
from runtime.hybrid import sliding_rhs as bent
from runtime.hybrid import switching_functions as surfaces
from runtime.hybrid.sliding_modes import work_size
from runtime.integrate import sampling as outputs
from runtime.integrate import step as attempt
from runtime.integrate import step_control as control
from runtime.integrate.method import find_method
from runtime.linalg.elimination_plan import plan_capacity
from runtime.singularity.detection import PIVOT_ROWS, vanishing


class Wiring(NamedTuple):
    """A table and what must live as long as it."""

    table: Integers
    arrays: dict[Slot, Any]


@cache
def _loop() -> Integers:
    """Addresses of the parts of the loop, in the order of `Slot` from CORRECT on."""
    return addresses(
        (
            correct,
            attempt.attempt,
            repartition.repartition,
            events.locate,
            events.sampled,
            modes.settle,
            modes.begin,
            control.first_step,
            outputs.emit,
            watch.watch,
            bent.bent,
            bent.bent_slope,
            impact.impact,
            impact.return_held,
            transition.transition,
            mixing.limited,
            surfaces.margins,
            vanishing,
            dead_centres.passed,
        )
    )


@cache
def function_table(name: str) -> Integers:
    """Addresses of the functions of the method `name`, in the order of `Slot` from STAGES on."""
    return addresses(find_method(name).functions)


@cache
def _kernels(system: System) -> Integers:
    """Addresses of a machine's kernels, in the order of `Slot`."""
    return addresses(getattr(system, slot.name.lower()) for slot in Slot if slot < Slot.STAGES)


def wire(system: System, name: str, p: Vector, log_rows: int) -> Wiring:
    """Lay out the table of a run of `system` with the method `name`.

    Parameters
    ----------
    p
        Parameters and derived constants.
    log_rows
        Room for changes of the partition.
    """
    n, m = system.coordinates, system.constraint_count
    table = np.zeros(len(Slot), np.int64)
    kernels, parts, loop = _kernels(system), function_table(name), _loop()
    table[: kernels.size] = kernels
    table[Slot.STAGES : Slot.STAGES + parts.size] = parts
    table[Slot.CORRECT : Slot.CORRECT + loop.size] = loop
    memory, notes = find_method(name).memory(n)
    s, contacts = system.switches, len(system.rigid)
    rigid = np.full(s, -1, np.int64)
    rigid[list(system.rigid)] = np.arange(contacts)
    limits = np.full(2 * s, -1, np.int64)
    for k, force, limit in system.limits:
        limits[2 * k], limits[2 * k + 1] = force, limit
    sought = np.full(s, -1, np.int64)
    for k, place in system.sought:
        sought[k] = place
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
        Slot.LOW: np.zeros(s),
        Slot.HIGH: np.ones(s),
        Slot.SHARE: np.full(s, np.nan),
        Slot.RIGID: rigid,
        Slot.STICKS: np.array([k in system.sticking for k in range(s)], dtype=np.int64),
        Slot.LIMITS: limits,
        Slot.SOUGHT: sought,
        Slot.UNIT: np.ones(2 * s),
        Slot.REACTION: np.zeros(3 * system.reaction_rows + m),
        Slot.RESTITUTION: np.zeros(contacts),
        Slot.PLAIN: np.zeros(2 * s, np.int64),
        Slot.WORK: np.zeros(work_size(n, m, s, contacts)),
        Slot.SETTINGS: np.zeros(2),
        Slot.WEIGHTS: np.zeros(4 * n),
        Slot.MEMORY: np.zeros(memory),
        Slot.NOTES: np.zeros(notes, np.int64),
        Slot.PIVOTS: np.zeros(PIVOT_ROWS * m + 2),
        Slot.PIVOT_COLUMNS: np.zeros(m, np.int64),
        Slot.PLAN: np.zeros(plan_capacity(m, nonzeros), np.int64),
        Slot.LOOP_ROWS: np.array(system.loop_rows, dtype=np.int64),
        Slot.NEARNESS: np.zeros(dead_centres.numbers_for(len(system.loop_rows))),
        Slot.SPREADS: np.zeros(s),
    }
    for slot, array in arrays.items():
        table[slot] = array.ctypes.data
    table[Slot.COORDINATES], table[Slot.CONSTRAINT_COUNT], table[Slot.RANK] = n, m, system.rank
    table[Slot.SWITCHES], table[Slot.NONZEROS] = system.switches, nonzeros
    system.holds(p, arrays[Slot.LOW], arrays[Slot.HIGH])
    for k, _ in system.sought:
        # Shares are of a force in units, from no force.
        reach = arrays[Slot.HIGH][k] - arrays[Slot.LOW][k]
        arrays[Slot.LOW][k], arrays[Slot.HIGH][k] = -reach, reach
    system.restitution(p, arrays[Slot.RESTITUTION])
    table[Slot.RIGID_COUNT], table[Slot.REACTION_ROWS] = contacts, system.reaction_rows
    table[Slot.LOG_ROWS], table[Slot.LOOPS] = log_rows, len(system.loop_rows)
    table[Slot.CORRECTING], table[Slot.PLAN_SIZE] = 1, plan_capacity(m, nonzeros)
    return Wiring(table, arrays)
