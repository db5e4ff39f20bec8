"""A run that stops near a dead centre names its loop."""

from types import SimpleNamespace

import numpy as np
import pytest

from runtime.core.outcomes import Outcome
from runtime.hybrid.loop_branch_guard import find_dead_centre

STATE, P = np.zeros((2, 1)), np.zeros(0)
RECORD = np.ones(11)  # largest ρ² of both loops: 1


def stopped(squares, outcome=Outcome.STEP_TOO_SMALL, rows=(7, 8)):
    def dead_centres(t, q, v, p, out):
        out[::2] = squares

    system = SimpleNamespace(loop_rows=rows, dead_centres=dead_centres)
    return find_dead_centre(system, 0.0, STATE, P, RECORD, outcome)


def test_the_loop_near_its_dead_centre_is_named():
    assert stopped([0.5, 1e-6]) == 8
    assert stopped([1e-6, 0.5]) == 7
    assert stopped([0.0, np.nan]) == 7


def test_a_loop_that_is_not_a_number_counts_as_near():
    assert stopped([0.5, np.nan]) == 8


def test_no_loop_is_named_away_from_dead_centres():
    assert stopped([0.5, 0.5]) is None


@pytest.mark.parametrize("outcome", [Outcome.OK, Outcome.MAX_STEPS, Outcome.ZENO])
def test_no_loop_is_named_where_a_run_ends_otherwise(outcome):
    assert stopped([0.0, 0.0], outcome) is None
