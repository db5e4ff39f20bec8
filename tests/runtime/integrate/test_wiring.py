"""The function table of a run: numbers, addresses, and what is known of switching functions."""

from dataclasses import replace

import numpy as np
import pytest

from runtime.core import function_table_slots as ft
from runtime.core.arrays import f8
from runtime.core.jit import ADDRESSES, addresses, compiled
from runtime.integrate.method import EXPLICIT
from runtime.integrate.wiring import METHOD_SLOTS, _refuse, function_table, place, wire
from tests.runtime.integrate.systems import PENDULUM, PENDULUM_P, relay


def test_numbers_and_arrays_of_a_pendulum():
    table, arrays = wire(PENDULUM, "dopri5", PENDULUM_P, 8)
    assert table[[ft.COORDINATES, ft.CONSTRAINT_COUNT, ft.SWITCHES]].tolist() == [3, 2, 0]
    assert table[[ft.RANK, ft.NONZEROS, ft.PARAMETER_COUNT, ft.LOG_ROWS]].tolist() == [2, 4, 4, 8]
    assert arrays["dense_jacobian"].shape == (2, 3)
    assert arrays["column_order"].tolist() == [0, 1, 2]
    for name in ("parameters", "jacobian_rows", "workspace"):
        assert table[ft.TABLE.slots[name]] == arrays[name].ctypes.data
    assert table[ft.RECORD] == arrays["record"].ctypes.data


@pytest.mark.parametrize("name", EXPLICIT)
def test_methods_differ_in_their_own_slots_alone(name):
    table = wire(PENDULUM, name, PENDULUM_P, 8).table
    other = wire(PENDULUM, "dop853", PENDULUM_P, 8).table
    np.testing.assert_array_equal(table[METHOD_SLOTS], function_table(name))
    functions = slice(0, ft.TABLE.slots["guard_branches"] + 1)
    differ = np.flatnonzero(table[functions] != other[functions])
    method = [k for k in differ if k >= METHOD_SLOTS.start]
    assert all(METHOD_SLOTS.start <= k < METHOD_SLOTS.stop for k in method)
    assert bool(method) == (name != "dop853")
    assert np.all(table[METHOD_SLOTS.start : functions.stop] != 0)


def slots_in_use(system, p):
    """Names of the slots of the loop that have a part of their own in the table of a run."""
    table = wire(system, "dopri5", p, 1).table
    names = list(ft.TABLE.slots)[METHOD_SLOTS.stop : ft.TABLE.slots["watch"] + 1]
    left_out = addresses([_refuse])[0]
    return {name for name in names if table[ft.TABLE.slots[name]] != left_out}


OF_ALL = {
    "correct", "trial_step", "repartition", "first_step", "emit", "modified_accelerations",
    "modified_rhs", "balance_step",
}  # fmt: skip
OF_SWITCHES = {
    "locate", "sample_function", "select_modes", "initialize_modes", "screen_step",
    "sliding_accelerations", "return_to_surfaces", "transition", "friction_margin", "margins",
    "balance_event",
}  # fmt: skip


def test_a_table_has_the_parts_that_the_machine_can_call():
    assert slots_in_use(PENDULUM, PENDULUM_P) == OF_ALL | {"vanishing"}
    assert slots_in_use(replace(PENDULUM, loops=1), PENDULUM_P) == OF_ALL | {
        "vanishing", "guard_branches",
    }  # fmt: skip
    system, p = relay((0.0,) * 7, (0.0,) * 7)
    assert slots_in_use(system, p) == OF_ALL | OF_SWITCHES
    rigid = replace(system, rigid=(0,))
    assert slots_in_use(rigid, p) == OF_ALL | OF_SWITCHES | {"impact"}
    assert slots_in_use(replace(system, one_way=(1,)), p) == OF_ALL | OF_SWITCHES | {"impact"}


def test_a_call_of_a_part_that_was_left_out_is_an_error():
    @compiled(f8(ADDRESSES))
    def strike(context):
        return ft.impact_of(context)(context, 1, 2.0, 3)

    with pytest.raises(RuntimeError, match="that the table of this machine leaves out"):
        strike(wire(PENDULUM, "dopri5", PENDULUM_P, 1).table)


def test_shares_and_events_before_a_run():
    system, p = relay((0.0,) * 7, (0.0,) * 7)
    arrays = wire(system, "dopri5", p, 1).arrays
    assert arrays["rigid"].tolist() == [-1, -1]
    assert (arrays["share_low"].tolist(), arrays["share_high"].tolist()) == ([0, 0], [1, 1])
    assert np.isnan(arrays["share"]).all()
    assert np.all(arrays["recent_events"] == -np.inf)


def test_an_array_made_elsewhere_is_put_into_the_table():
    wiring, array = wire(PENDULUM, "dopri5", PENDULUM_P, 8), np.zeros(3)
    place(*wiring, "sample_times", array)
    assert wiring.arrays["sample_times"] is array
    assert wiring.table[ft.TABLE.slots["sample_times"]] == array.ctypes.data
