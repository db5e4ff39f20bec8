"""A step that ends where a falling body meets g = 0."""

import numpy as np
import pytest

from runtime.core.outcomes import Outcome
from runtime.core.workspace_rows import G0, G1, R0, R1, Y0, Y1, K
from runtime.integrate.step import Signal
from tests.runtime.integrate.drivers import copy_end, end_at_event, started, stay, tried
from tests.runtime.integrate.systems import relay, relay_problem

FALL = np.sqrt(2.0 / 9.81)
FLOOR = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def falling(height=1.0, **options):
    system, p = relay(FLOOR, constant=-9.81)
    return started(system, relay_problem(p, height, 0.0), **options)


@pytest.mark.parametrize("method", ["dop853", "tsit5"])
def test_a_step_ends_at_the_event_in_it(method):
    run = falling(method=method)
    assert tried(run, 0.5) == 0
    assert end_at_event(run.state.table) == Signal.PROCEED
    record = run.state.record
    assert record["crossing"] == 0
    assert record["length"] == pytest.approx(FALL, abs=1e-14)
    assert record["end"] == record["length"]
    assert abs(run.state.rows[Y1, 0, 0]) < 1e-14
    assert record["retakes"] >= 1


def test_a_step_without_an_event_is_left_as_it_is():
    run = falling()
    tried(run, 0.4)
    assert end_at_event(run.state.table) == Signal.PROCEED
    assert run.state.record["crossing"] == -1
    assert run.state.record["length"] == 0.4
    assert run.state.record["retakes"] == 0


def test_events_without_time_between_them_come_to_an_end():
    run = falling()
    record = run.state.record
    tried(run, 0.1)
    record["crossing"] = 0
    for _ in range(10):
        assert stay(run.state.table) == Signal.PROCEED
    assert (record["length"], record["end"]) == (0.0, record["t"])
    np.testing.assert_array_equal(run.state.rows[Y1], run.state.rows[Y0])
    record["index"] = -1
    assert stay(run.state.table) == Outcome.ZENO
    assert record["index"] == 0


def test_one_end_is_copied_to_the_other():
    run = falling()
    tried(run, 0.1)
    end_at_event(run.state.table)
    rows, switches, last = run.state.rows, run.state.switch_rows, int(run.state.record["last"])
    state, rate = rows[Y1].copy(), rows[K + last].copy()
    g, dg = switches[G1].copy(), switches[R1].copy()
    assert state[0, 0] != rows[Y0, 0, 0]
    copy_end(run.state.table, 1, 0)
    for copied, value in (
        (rows[Y0], state),
        (rows[K], rate),
        (switches[G0], g),
        (switches[R0], dg),
    ):
        np.testing.assert_array_equal(copied, value)
    rows[Y0] = 7.0
    copy_end(run.state.table, 0, 1)
    assert np.all(rows[Y1] == 7.0)
