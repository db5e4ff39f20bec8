"""Impacts follow Newton's law of restitution, and bouncing ends with a closed contact."""

import numpy as np
import pytest

from runtime.core.kinds import SLIDING, Direction
from runtime.core.outcomes import Outcome
from runtime.integrate.method import EXPLICIT
from tests.runtime.hybrid.systems import drop_ball


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.9, 1.0])
def test_speed_after_an_impact_is_e_times_that_before(method, restitution):
    r = drop_ball(1.0, 0.0, 2.0, restitution, 1.25, method=method)
    # It falls for 1 s and arrives at 2 m/s.
    assert r.outcome == Outcome.OK
    assert r.events.t.tolist() == pytest.approx([1.0], abs=1e-13)
    assert r.final_v[0] == pytest.approx(2.0 * restitution - (0.5 if restitution else 0.0))


@pytest.mark.parametrize("method", EXPLICIT)
def test_bouncing_ends_when_all_flights_are_over(method):
    e = 0.5
    r = drop_ball(1.0, 0.0, 2.0, e, 5.0, method=method)
    end = 1.0 + 2.0 * e / (1.0 - e)
    assert r.outcome == Outcome.OK
    assert r.events.direction[-1] == Direction.HOLDS
    assert set(r.events.direction[:-1]) == {Direction.IMPACT}
    assert r.events.t[-1] == pytest.approx(end, abs=1e-9)
    flights = np.diff(r.events.t)[:-1]
    np.testing.assert_allclose(flights, 2.0 * e ** np.arange(1, len(flights) + 1), rtol=1e-6)
    assert r.final_modes.tolist() == [SLIDING]
    assert np.abs([r.final_q[0], r.final_v[0]]).max() < 1e-13


@pytest.mark.parametrize("method", EXPLICIT)
def test_contact_opens_where_its_reaction_changes_sign(method):
    # A ball at rest on the ground, pulled upwards from the start.
    r = drop_ball(0.0, 0.0, -1.0, 0.5, 2.0, method=method)
    assert r.final_modes.tolist() == [1]
    assert r.final_q[0] == pytest.approx(2.0, abs=1e-12)
