"""The function table of a run: numbers, addresses, and what is known of switching functions."""

from dataclasses import replace

import pytest

from runtime.core import function_table_slots as ft
from runtime.core.arrays import f8
from runtime.core.jit import ADDRESSES, addresses, compiled
from runtime.integrate.wiring import METHOD_SLOTS, _refuse, wire
from tests.runtime.integrate.systems import PENDULUM, PENDULUM_P, relay


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
