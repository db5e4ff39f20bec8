"""The function table of a run: numbers, addresses, and what is known of switching functions."""

import numpy as np
import pytest

from runtime.core import function_table_slots as ft
from runtime.integrate.method import EXPLICIT
from runtime.integrate.wiring import METHOD_SLOTS, function_table, place, wire
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
