"""Events are in order of time and inside the run, and each is where the motion has it."""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

G = 9.81


@pytest.fixture(scope="module")
def shaken(request: pytest.FixtureRequest) -> Machine:
    """The ball on the floor that shakes, built beside pytest's cache."""
    folder: Path = request.config.cache.mkdir("hard")
    return load(Path(__file__).with_name("floor_that_throws.py"), "shaken", folder=folder)


def first_landing(speed: float) -> float:
    """The first instant at which a ball thrown up from the floor meets it again, s."""

    def gap(t: float) -> float:
        return float(speed * t - 0.5 * G * t * t - 0.1 * np.sin(20 * t))

    times = np.linspace(1e-3, 3.0, 30_001)
    below = np.flatnonzero([gap(t) < 0.0 for t in times])[0]
    return float(brentq(gap, times[below - 1], times[below], xtol=1e-15))


@pytest.mark.parametrize("e", [0.0, 0.05, 0.5])
@pytest.mark.parametrize("speed", [2.3, 3.0, 3.1, 4.7])
def test_events_are_in_order_and_inside_the_run(shaken: Machine, speed: float, e: float) -> None:
    run = shaken.simulate(2.5, rtol=1e-10, start={"ball.vy": speed}, parameters={"e": e})
    assert run.outcome is Outcome.OK
    times = np.array([event.time for event in run.events])
    assert (np.diff(times) >= 0.0).all()
    assert times[0] >= 0.0
    assert times[-1] <= run.t[-1]
    assert times[0] == pytest.approx(first_landing(speed), abs=1e-9)
    # Each event's time is that of its state: on the floor.
    on_floor = [0.1 * np.sin(20 * event.time) - event.q[1] for event in run.events]
    np.testing.assert_allclose(on_floor, 0.0, atol=1e-9)


def test_end_of_bouncing_is_inside_a_run_that_ends_before_it(shaken: Machine) -> None:
    """A run that ends just after the last visible impact knows no event after its end."""
    whole = shaken.simulate(1.0, start={"ball.vy": 3.0})
    landing = whole.events[0].time
    for later in (1e-12, 1e-9, 1e-6):
        run = shaken.simulate(landing + later, start={"ball.vy": 3.0})
        assert all(event.time <= run.t[-1] for event in run.events)
