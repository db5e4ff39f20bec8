"""The table of addresses for one run, and the arrays that it points to."""

from collections.abc import Sequence
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np

from runtime.constraints import newton_return, repartitioning
from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Integers, Vector, i8
from runtime.core.jit import addressed, addresses, is_kept
from runtime.core.kernel_abi import KERNELS
from runtime.core.kinds import Hold
from runtime.core.loop_record import RUN, ConstraintReturn
from runtime.core.system import System
from runtime.hybrid import (
    events,
    filippov_shares,
    impact,
    mode_selection,
    mode_transition,
    sliding_motion,
    step_limits,
)
from runtime.integrate import energy_balance, initialization, loop, sampling, step, step_control
from runtime.integrate.clocks import queue_length, read_clocks
from runtime.integrate.method import find_method
from runtime.integrate.second_compiler import compile_beside
from runtime.linalg.least_norm import SPARSE_FROM
from runtime.linalg.symbolic_elimination import plan_capacity
from runtime.singularity.prediction import predict_vanishing_pivot

_KEPT = 8  # safety: tables that are kept, to be copied
METHOD_SLOTS = slice(ft.TABLE.slots["stages"], ft.TABLE.slots["correct"])
"""Slots of the method's functions."""

_LOOP_SLOTS = slice(METHOD_SLOTS.stop, ft.TABLE.slots["watch"] + 1)
_OF_SWITCHES = (
    "locate", "sample_function", "select_modes", "initialize_modes", "screen_step",
    "sliding_accelerations", "return_to_surfaces", "transition", "friction_margin", "margins",
    "balance_event",
)  # fmt: skip
"""Parts of the loop that only switching functions call; they take half of compiling it."""


class Wiring(NamedTuple):
    """A function table, and the arrays by name that must live as long as it."""

    table: Integers
    arrays: Any

    @property
    def block(self) -> Integers:
        """The memory of all arrays that the table allots."""
        return self.arrays.block  # type: ignore[no-any-return]


def _parts() -> dict[str, Any]:
    """The parts of the loop by their slots: here is the body behind each `ft.X_of`."""
    return {
        "correct": newton_return.return_to_constraints,
        "trial_step": step.take_trial_step,
        "repartition": repartitioning.repartition,
        "locate": events.locate_event,
        "sample_function": events.sample_function,
        "select_modes": mode_selection.select_modes,
        "initialize_modes": mode_selection.initialize_modes,
        "first_step": step_control.first_step,
        "emit": sampling.emit,
        "screen_step": events.screen_step,
        "modified_accelerations": sliding_motion.evaluate_modified_accelerations,
        "sliding_accelerations": sliding_motion.evaluate_sliding_accelerations,
        "modified_rhs": sliding_motion.evaluate_modified_rhs,
        "impact": impact.apply_impact,
        "return_to_surfaces": impact.return_to_surfaces,
        "transition": mode_transition.make_transition,
        "friction_margin": filippov_shares.compute_friction_margin,
        "margins": sliding_motion.write_margins,
        "vanishing": predict_vanishing_pivot,
        "guard_branches": step_limits.guard_branches,
        "balance_step": energy_balance.balance_step,
        "balance_event": energy_balance.balance_event,
    }


@addressed(i8())
def _refuse() -> int:
    """What stands in the slot of an unused part; in C a call may have any arguments."""
    raise RuntimeError("a part of the loop was called that the table of this machine leaves out")


@cache
def _begin(left_out: frozenset[str], behind: tuple[Any, ...]) -> None:
    parts = [part for name, part in _parts().items() if name not in left_out]
    if not is_kept(parts[-1]):
        compile_beside([*parts, initialization.start, loop.advance, *behind])


def begin_compiling(system: System, behind: Sequence[Any] = ()) -> None:
    """Let a second process compile the loop of a machine, and what the run needs behind it."""
    _begin(_left_out(system), tuple(behind))


@cache
def _loop(left_out: frozenset[str]) -> Integers:
    """Addresses in _LOOP_SLOTS; parts that are left out are neither compiled nor loaded."""
    parts = _parts()
    names = list(ft.TABLE.slots)[_LOOP_SLOTS]
    wanted = {name: parts[name] for name in names if name in parts and name not in left_out}
    return addresses(wanted.get(name, _refuse) for name in names)


@cache
def _left_out(system: System) -> frozenset[str]:
    """The parts of the loop that no run of a machine can call."""
    parts: list[str] = [] if system.switches else [*_OF_SWITCHES]
    parts += [] if system.rigid or system.one_way else ["impact"]
    parts += [] if system.constraint_count else ["vanishing"]
    parts += [] if system.loops else ["guard_branches"]
    return frozenset(parts)


@cache
def function_table(name: str) -> Integers:
    """Addresses of the functions of the method `name`, in the order of the function table."""
    method = find_method(name)
    return addresses(getattr(method, part) for part in list(ft.TABLE.slots)[METHOD_SLOTS])


@cache
def _resolved_part() -> int:
    """The address of what watches peaks, which other machines do without."""
    from runtime.hybrid.step_limits import find_resolved_part

    return int(addresses([find_resolved_part])[0])


@cache
def _sparse_parts() -> tuple[int, int]:
    """The addresses of the eliminations of large machines, which others do without."""
    from runtime.constraints.partitioning import order_by_sparse_pivots
    from runtime.singularity.prediction import find_sparse_pivots

    order, pivots = addresses([order_by_sparse_pivots, find_sparse_pivots]).tolist()
    return order, pivots


@cache
def _discrete() -> tuple[int, int]:
    """The addresses of what renews sampled values and watches conditions."""
    from runtime.integrate.sampled_values import renew_in_step, watch

    renew, watching = addresses([renew_in_step, watch]).tolist()
    return renew, watching


_kernels = cache(System.table)  # addresses of a machine's kernels, in the order of the table


def wire(system: System, name: str, p: Vector, log_rows: int) -> Wiring:
    """The table of a run, with room for `log_rows` changes of the partition."""
    arrays = _lay_out(system, name, p.tobytes(), log_rows).copied()
    place(arrays.table, arrays, "parameters", p)
    place(arrays.table, arrays, "record", np.zeros(RUN.itemsize // 8, np.int64).view(RUN))
    return Wiring(arrays.table, arrays)


@lru_cache(_KEPT)
def _lay_out(system: System, name: str, parameters: bytes, log_rows: int) -> Any:
    """The arrays of runs with these parameters before their start, which each of them copies."""
    p = np.array(memoryview(parameters).cast("d"))
    n, m, s = system.coordinates, system.constraint_count, system.switches
    nonzeros, sparse = len(system.jacobian_rows), n >= SPARSE_FROM and m > 0
    table = np.zeros(ft.TABLE.size, np.int64)
    table[: len(KERNELS)] = _kernels(system)
    table[METHOD_SLOTS] = function_table(name)
    table[_LOOP_SLOTS] = _loop(_left_out(system))
    floats, integers = find_method(name).memory(n)
    numbers = {
        ft.COORDINATES: n,
        ft.CONSTRAINT_COUNT: m,
        ft.SWITCHES: s,
        ft.RANK: system.rank,
        ft.NONZEROS: nonzeros,
        ft.PARAMETER_COUNT: p.size,
        ft.RIGID_COUNT: len(system.rigid),
        ft.REACTION_ROWS: system.reaction_rows,
        ft.POWER_ROWS: system.power_rows,
        ft.POWER_OF_MULTIPLIERS: int(system.powers_of_multipliers),
        ft.LOOPS: system.loops,
        ft.SUPERPOSES: int(system.superposes),
        ft.LINEAR_REACTIONS: int(system.linear_reactions),
        ft.PLAN_SIZE: 1 if sparse else plan_capacity(m, nonzeros),
        ft.SPARSE: int(sparse),
        ft.DENSE_ROWS: 0 if sparse else m,
        ft.WORKSPACE_SIZE: 2 * n * ws.ROWS,
        ft.SWITCHING_SIZE: s * ws.SWITCH_ROWS,
        ft.METHOD_FLOATS_SIZE: floats,
        ft.METHOD_INTEGERS_SIZE: integers,
        ft.PEAKS: len(system.peaks),
        ft.STATES: len(system.states),
        ft.SAMPLED: len(system.sampled),
        ft.WATCHED: len(system.watches),
        ft.CONTROLLERS: len(system.controllers),
        ft.LOG_ROWS: log_rows,
        ft.CORRECTING: ConstraintReturn.BY_PARTITION,
    }
    slots = ft.TABLE.slots
    if sparse:
        numbers[slots["order_sparsely"]], numbers[slots["find_pivots_sparsely"]] = _sparse_parts()
    if system.peaks:
        numbers[slots["resolved_part"]] = _resolved_part()
    if system.sampled or system.watches:
        clocks = read_clocks(system, p)
        renew, watch = _discrete()
        numbers |= {ft.QUEUE: queue_length(clocks), slots["renew"]: renew, slots["watch"]: watch}
    table[list(numbers)] = list(numbers.values())
    arrays = ft.TABLE.allot(table)
    for indices in ("jacobian_rows", "jacobian_columns"):
        place(table, arrays, indices, np.ascontiguousarray(getattr(system, indices), np.int64))
    arrays["row_order"][:], arrays["column_order"][:] = np.arange(m), np.arange(n)
    arrays["recent_events"][:] = -np.inf
    for k, (kind, exponent) in enumerate(system.peaks):
        arrays["peak_kinds"][k], arrays["peak_exponents"][k] = kind, exponent
    if s:
        _describe_switches(system, p, arrays)
    if system.sampled:
        arrays["sampled_columns"][:], arrays["sample_clocks"][:] = system.sampled, clocks.ravel()
        arrays["sample_triggers"][:] = system.triggers
    arrays["state_columns"][:], arrays["ends_run"][:] = system.states, system.watches
    arrays["state_direction"][:] = 1.0
    return arrays


def place(table: Integers, arrays: dict[str, Any], name: str, array: Any) -> None:
    """Put an array that was made elsewhere into a table."""
    arrays[name] = array
    table[ft.TABLE.slots[name]] = array.ctypes.data


def _describe_switches(system: System, p: Vector, arrays: dict[str, Any]) -> None:
    """Fill in what is known of the switching functions before a run."""
    low, high = arrays["share_low"], arrays["share_high"]
    arrays["rigid"][:], arrays["limits"][:], arrays["stiction_place"][:] = -1, -1, -1
    arrays["share_place"][:] = -1
    arrays["rigid"][list(system.rigid)] = np.arange(len(system.rigid))
    arrays["sticks"][list(system.sticking)] = Hold.FRICTION
    arrays["sticks"][list(system.one_way)] = Hold.ONE_WAY
    arrays["boundary"][: len(system.boundaries)] = system.boundaries
    arrays["table_part"][: len(system.table_parts)] = system.table_parts
    arrays["share"][:], arrays["stiction_units"][:], high[:] = np.nan, 1.0, 1.0
    for k, force, limit in system.limits:
        arrays["limits"][2 * k : 2 * k + 2] = force, limit
    system.holds(p, low, high)
    for k, slot in system.shares:
        arrays["share_place"][k] = slot
    for k, slot in system.stiction:
        arrays["stiction_place"][k] = slot
        # Shares are of a force in units, from no force.
        reach = high[k] - low[k]
        low[k], high[k] = -reach, reach
    system.restitution(p, arrays["restitution_coefficients"])
