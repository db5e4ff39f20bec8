"""The parts of the loop: the end of the next step, rejected steps, plans, and chunks."""

import numpy as np
import pytest

from runtime.core.function_table_slots import EVENT_ROWS
from runtime.core.loop_record import Plan
from runtime.core.outcomes import Outcome
from runtime.integrate.loop import WEAK_STATES, advance
from runtime.integrate.step import Signal, TrialStep
from tests.runtime.integrate.drivers import follow_plan, plan_step, swinging, try_step
from tests.runtime.integrate.systems import PENDULUM


def changed(**record):
    run = swinging(PENDULUM)
    for name, value in record.items():
        run.state.record[name] = value
    return run


@pytest.mark.parametrize(
    ("record", "end"),
    [
        ({"h": 0.1}, 0.1),
        ({"h": 9.95}, 10.0),  # no small rest
        ({"h": 0.1, "h_max": 0.05}, 0.05),
        ({"h": 0.1, "plan": Plan.APPROACHING, "turn": 0.07}, 0.07),
        ({"h": 0.1, "plan": Plan.CROSSING, "length_across": 0.3}, 0.3),
        ({"h": 0.1, "plan": Plan.MISSING, "length_across": 0.01, "turn": 0.2}, 0.06),
    ],
)
def test_the_end_of_the_next_step(record, end):
    run = changed(**record)
    assert plan_step(run.state.table) == Signal.PROCEED
    assert run.state.record["end"] == pytest.approx(end, rel=1e-15)


@pytest.mark.parametrize(
    ("record", "code"),
    [
        ({"t": 10.0}, Outcome.OK),
        ({"steps": 100_000_000}, Outcome.MAX_STEPS),
        ({"h": 0.0}, Outcome.STEP_TOO_SMALL),
        ({"h": 0.0, "reason": TrialStep.NEWTON_FAILED}, Outcome.NEWTON_FAILED),
        ({"h": 0.0, "reason": TrialStep.NOT_FINITE}, Outcome.NOT_FINITE),
        ({"logged_events": 65}, Signal.GOING),
    ],
)
def test_no_further_step(record, code):
    run = changed(**record)
    assert run.state.table[EVENT_ROWS] == 64
    assert plan_step(run.state.table) == code


def test_a_step_with_too_large_an_error_is_shortened_by_it():
    run = changed(length=0.3, end=0.3, rtol=1e-12, quiet=np.inf)
    record = run.state.record
    assert try_step(run.state.table) == Signal.RETRY
    assert record["reason"] == TrialStep.TOO_LARGE
    ratio = max(record["shrink"], record["safety"] / record["error"] ** record["exponent"])
    assert record["h"] == pytest.approx(0.3 * ratio)
    assert record["rejected"] == 1


@pytest.mark.parametrize(
    ("record", "code"),
    [
        ({}, Signal.PROCEED),
        ({"plan": Plan.CROSSING}, Signal.LOOK),
        ({"plan": Plan.APPROACHING, "turn": 1.0}, Signal.PROCEED),
        ({"plan": Plan.APPROACHING, "turn": 0.0}, Signal.LOOK),
        ({"announced": 1}, Signal.LOOK),
        ({"lent": 1, "lent_until": 0.0}, Signal.LOOK),
        ({"lent": 1, "lent_until": 1.0}, Signal.PROCEED),
        ({"due": 1}, Signal.CHANGE),
        ({"weak": WEAK_STATES, "weak_row": 1}, Signal.LOOK),
        ({"weak": WEAK_STATES, "weak_row": 3}, Outcome.SINGULAR),
    ],
)
def test_what_follows_an_accepted_step(record, code):
    assert follow_plan(changed(**record).state.table) == code


def test_a_run_leaves_a_position_and_is_free_again():
    run = changed(plan=Plan.LEAVING, quiet=0.0)
    assert follow_plan(run.state.table) == Signal.PROCEED
    assert run.state.record["plan"] == Plan.FREE


def test_a_chunk_has_so_many_trial_steps():
    run = swinging(PENDULUM)
    for count in (1, 3):
        assert advance(run.state.table, count) == Signal.GOING
    record = run.state.record
    assert record["steps"] + record["rejected"] == 4
    assert advance(run.state.table, 60) == Signal.GOING
