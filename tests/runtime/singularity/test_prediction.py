"""When a pivot is to vanish: on a branch of the saddle, at the origin, at a known time."""

import numpy as np
import pytest

from codegen import Model
from runtime import load
from runtime.core.arrays import f8, i8, integers
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
        self.rows[Y0] = start.position, start.velocity
        self.rows[K] = start.velocity, 2.0 * start.series[2]
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
    assert slow.step(-2.0, 0.1) == fast.step(-2.0, 0.01) == np.inf
    assert slow.record["look_at"] == pytest.approx(10.0 * fast.record["look_at"], rel=0.01)
    assert slow.record["look_at"] < 1.0


@pytest.mark.parametrize("acceleration", [0.0, 1.0])
def test_a_machine_that_rests_is_looked_at_again_before_it_can_come_far(acceleration):
    """By its acceleration; where that is zero too, within a few steps, as forces may grow."""
    run = Run(speed=0.0)
    run.record["foresight"] = 0.1
    h, start = 0.1, on_branch(-2.0)
    a = acceleration * start.velocity
    run.rows[Y0], run.rows[K] = (start.position, 0.0 * a), (0.0 * a, a)
    run.rows[Y1] = start.position + 0.5 * h**2 * a, h * a
    assert predict(run.wiring.table, 0.0, h, Y1) == np.inf
    assert 0.0 < run.record["look_at"] <= 10.0 * h
    if acceleration:
        way = 0.5 * run.record["look_at"] ** 2 * np.abs(start.velocity).max()
        assert way < 1.0


@pytest.mark.parametrize("first_step", [None, 1e-6])
@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau5"])
def test_a_run_released_from_rest_counts_the_position_that_it_passes(tmp_path, method, first_step):
    m = Model("equal", gravity=(0, -9.81))
    crank, rod, block = (m.body(name, mass=1.0, inertia=0.1) for name in ("crank", "rod", "block"))
    m.revolute("A", m.ground, crank.at(-0.5, 0))
    m.revolute("B", crank.at(0.5, 0), rod.at(-0.5, 0))
    m.revolute("C", rod.at(0.5, 0), block)
    m.translational("guide", m.ground, block, axis=(1, 0))
    m.torque("motor", crank, 5.0)
    start, guess = {crank.phi: 1.0, crank.omega: 0.0}, {rod.phi: -1.0, block.x: 1.0}
    m.scene("s", ["gravity", "motor"], start=start, guess=guess)
    machine = load(m, folder=tmp_path)
    for rtol in (1e-6, 1e-10):
        run = machine.simulate(5.0, method=method, rtol=rtol, first_step=first_step)
        assert run.stats["singular_crossings"] == 1
        assert "where constraints A.y, B.y, C.y and guide.normal became dependent" in run.message
        assert run.singular[0].time == pytest.approx(3.5623329, abs=1e-4)
        parts = run.singular[0].null_directions[0]
        half = parts["crank.x"] * run.singular[0].size  # the crank hangs downwards
        assert half == pytest.approx(0.5 * parts["crank.phi"], rel=1e-6)
