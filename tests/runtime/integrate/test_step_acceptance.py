"""Acceptance: the step's end becomes a start, modes change, and endless events end a run."""

import numpy as np
import pytest

from runtime.core.outcomes import Outcome, Site
from runtime.core.workspace_rows import Y0, Y1
from runtime.hybrid.mode_consistency import CONSISTENT
from runtime.integrate.step import Signal
from tests.runtime.integrate.drivers import (
    accept_step,
    end_at_event,
    judge_events,
    started,
    stay,
    tried,
)
from tests.runtime.integrate.systems import relay, relay_problem

FALL = np.sqrt(2.0 / 9.81)
FLOOR = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def falling(height=1.0, **options):
    system, p = relay(FLOOR, constant=-9.81)
    return started(system, relay_problem(p, height, 0.0), **options)


def accepted(h, **options):
    run = falling(**options)
    tried(run, h)
    end_at_event(run.state.table)
    assert accept_step(run.state.table) == Signal.PROCEED
    return run


def test_the_end_becomes_the_next_start():
    run = accepted(0.2)
    record, rows = run.state.record, run.state.rows
    assert record["t"] == 0.2
    assert (record["steps"], record["samples"], record["changed"]) == (1, 1, 0)
    np.testing.assert_array_equal(rows[Y0], rows[Y1])
    assert rows[Y0, 0, 0] == pytest.approx(1.0 - 0.5 * 9.81 * 0.04)
    assert judge_events(run.state.table) == Signal.PROCEED


def test_an_event_changes_the_mode_and_starts_the_method_anew():
    run = accepted(0.5)
    record = run.state.record
    assert record["t"] == pytest.approx(FALL)
    assert run.state.modes.tolist() == [0]
    assert (record["changed"], record["events"]) == (1, 1)
    record["remembered"] = 0.5
    assert judge_events(run.state.table) == Signal.PROCEED
    assert record["remembered"] == 0.0


@pytest.mark.parametrize(
    ("changes", "outcome", "index", "site"),
    [
        ({"blamed": 0}, Outcome.INCONSISTENT, 0, Site.EVENT_MODES),
        (
            {"blamed": 0, "shrinking": 7, "event_span": np.inf},
            *(Outcome.ZENO, 0, Site.CROWDED_MODES),
        ),
        ({"events": 11}, Outcome.ZENO, 3, Site.MOST_EVENTS),
        ({"shrinking": 29, "event_span": 1.0, "duration": 1e12}, Outcome.ZENO, 3, Site.CROWDED),
    ],
)
def test_events_without_end_or_modes_end_the_run(changes, outcome, index, site):
    run = accepted(0.5, max_events=10)
    run.recording.wiring.arrays["recent_events"][:] = FALL
    given = {"blamed": CONSISTENT, "crossing": 3, "flight": np.inf, "event_span": 0.0, **changes}
    for name, value in given.items():
        run.state.record[name] = value
    assert judge_events(run.state.table) == outcome
    assert run.state.record["index"] == index
    assert run.state.record["site"] == site


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
