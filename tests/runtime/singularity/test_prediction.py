"""When a pivot is to vanish: on a branch of the saddle, at the origin, at a known time."""

import numpy as np
import pytest

from runtime.core.array_types import f8, i8, integers
from runtime.core.jit import compiled
from runtime.core.system import System
from runtime.core.workspace_rows import Y0, Y1, K
from runtime.singularity import prediction
from tests.runtime.constraints.drivers import wired
from tests.runtime.integrate.systems import PENDULUM
from tests.runtime.singularity.crossing import COLUMNS, ROWS, jacobian, mechanism
from tests.runtime.singularity.test_singular_root_search import on_branch

SYSTEM = System(
    accelerations=PENDULUM.accelerations,
    correction=PENDULUM.correction,
    jacobian=jacobian,
    jacobian_rows=ROWS,
    jacobian_columns=COLUMNS,
    coordinates=3,
    constraint_count=2,
)


@compiled(f8(integers, f8, f8, i8))
def predict(context, t, h, state):
    return prediction.predict_vanishing_pivot(context, t, h, state)


class Run:
    """The constraints of the saddle, with a motion on one of its branches through the origin."""

    def __init__(self, speed: float = 1.0) -> None:
        self.wiring, self.rows = wired(SYSTEM, mechanism().p, np.ones(3))
        self.record, self.speed = self.wiring.arrays["record"][0], speed
        self.record["rtol"], self.record["look_at"] = 1e-8, -np.inf

    def step(self, x: float, h: float, state: int = Y1, t: float = 0.0) -> float:
        """The prediction at x before a step of length h."""
        start = on_branch(x, speed=self.speed)
        self.rows[Y0] = start.q, start.v
        self.rows[K] = start.v, 2.0 * start.series[2]
        self.rows[Y1] = start.at(h)
        return predict(self.wiring.table, t, h, state)


@pytest.mark.parametrize("h", [0.15, 0.3])
def test_a_position_within_the_step_is_found_when_it_is_passed(h):
    """By six steps of the Illinois rule."""
    assert Run().step(-0.1, h) == pytest.approx(0.1, rel=5e-3)


def test_a_position_ahead_is_announced():
    """Within a few steps; linearly, as nothing is known of the motion there."""
    assert Run().step(-0.1, 0.05) == pytest.approx(0.1, rel=0.1)
    run = Run()
    assert run.step(-1.0, 0.05) == np.inf
    assert 0.0 < run.record["look_at"] < 1.0


def test_a_motion_away_from_it_announces_nothing():
    run = Run()
    assert run.step(0.2, 0.1) == np.inf
    assert run.record["look_at"] > 0.0


def test_after_a_step_that_failed_it_is_looked_for_on_the_motion_as_it_begins():
    assert Run().step(-0.05, 0.06, state=Y0) == pytest.approx(0.05, rel=0.2)
    # One that has just been passed too.
    assert Run().step(1e-4, 0.1, state=Y0) == pytest.approx(-1e-4, rel=0.2)


def test_later_looks_follow_the_plan():
    """Their answers are those of looks without one, until a pivot has changed its sign."""
    run = Run()
    plan = run.wiring.arrays["elimination_plan"]
    h, x, t = 0.1, -2.0, 0.0
    assert run.step(x, h, t=t) == np.inf
    assert plan[0] > 0
    length, looks = plan[0], 0
    while x < -0.5:
        x, t = x + h, t + h
        run.record["look_at"] = max(run.record["look_at"], t)
        plan[2] += 0
        assert run.step(x, h, t=t) == np.inf
        assert Run().step(x, h, t=t) == np.inf
        looks += plan[0] == length
    assert looks > 5
    run.record["look_at"] = np.inf
    assert run.step(-0.1, 0.2, t=t + h) == pytest.approx(0.1, rel=1e-3)
    assert plan[0] == 0


def test_speed_and_size_tell_how_long_nothing_can_happen():
    slow, fast = Run(speed=1.0), Run(speed=10.0)
    assert slow.step(-2.0, 1e-4) == fast.step(-2.0, 1e-5) == np.inf
    assert slow.record["look_at"] == pytest.approx(10.0 * fast.record["look_at"], rel=0.01)
