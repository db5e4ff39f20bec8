"""The state of a run as its problem and options say, and its changes of method."""

import numpy as np
import pytest

from runtime.core import function_table_slots as ft
from runtime.core.loop_record import ConstraintReturn
from runtime.integrate.method import find_method
from runtime.integrate.problem import Options
from runtime.integrate.run_state import RunState
from runtime.integrate.wiring import METHOD_SLOTS, function_table
from tests.runtime.integrate.stiff import SMOOTH_PENDULUM
from tests.runtime.integrate.systems import PENDULUM, pendulum_problem


def state(system=PENDULUM, **options):
    return RunState(system, pendulum_problem(0.3, 2.0, 10.0), Options(**options))


@pytest.mark.parametrize(
    ("correction", "code", "stabilized", "each_stage"),
    [
        ("step", ConstraintReturn.BY_PARTITION, 0, 0),
        ("stage", ConstraintReturn.BY_PARTITION, 0, 1),
        ("projection", ConstraintReturn.BY_PROJECTION, 0, 0),
        ("baumgarte", ConstraintReturn.NEVER, 1, 0),
        ("hybrid", ConstraintReturn.IF_DRIFTED, 1, 0),
    ],
)
def test_returns_onto_the_constraints(correction, code, stabilized, each_stage):
    run = state(correction=correction, time_scale=0.05)
    assert run.table[ft.CORRECTING] == code
    assert run.table[ft.STABILIZED] == run.table[ft.MODIFIED] == stabilized
    assert run.table[ft.EACH_STAGE] == each_stage
    # Baumgarte's terms are followed by steps of at most twice their time.
    assert run.record["h_max"] == (0.1 if stabilized else 10.0)


def test_another_method_with_nothing_to_remember():
    run = state(SMOOTH_PENDULUM, method="bdf")
    run.wiring.arrays["method_integers"][:] = 7
    run.use_method("dopri5")
    method = find_method("dopri5")
    assert run.method is method
    assert run.record["estimate_order"] == method.estimate_order
    assert run.record["exponent"] == 1.0 / method.estimate_order
    np.testing.assert_array_equal(run.table[METHOD_SLOTS], function_table("dopri5"))
    assert not run.wiring.arrays["method_integers"].any()
    assert [name for _, name in run.methods] == ["bdf"]  # which the run goes back to


def test_each_change_of_method_takes_twice_the_patience():
    run = state(SMOOTH_PENDULUM, method="auto", rtol=1e-9)
    for patience in (2, 4, 8):
        before = run.methods[-1][1]
        run.change_method()
        assert run.record["patience"] == patience
        assert run.methods[-1][1] != before
    assert len(run.methods) == 4
