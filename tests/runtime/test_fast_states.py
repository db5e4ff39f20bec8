"""Fast states of first order: between the ends of steps they are as right as there."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from runtime import load
from tests.runtime.test_states import exact, motor


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize("method", ["dop853", "auto"])
@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_samples_of_a_motor(workshop: Path, method: str, formulation: str, rtol: float) -> None:
    """Its current follows in 5 ms, its speed in 0.3 s: steps are as long as the current permits."""
    machine = load(motor("motor_states"), "spin", folder=workshop)
    given = {"method": method, "formulation": formulation, "rtol": rtol}
    r = machine.simulate(1.0, 1001, **given)
    got = np.column_stack([r.y("current"), r.v("rotor.omega")])
    assert_allclose(got, exact(r.t), atol=2 * rtol)
    steps = machine.simulate(1.0, "steps", **given).t
    if method == "dop853":  # its edge of stability lies at 6
        assert 5.0 < np.diff(steps).max() * 197.46 < 5.6


def test_states_that_swing_have_steps_of_their_frequency(workshop: Path) -> None:
    """Rates of 1 and of ω² = 1e4 in turns: neither is the frequency."""
    model = Model("swinging_states")
    mass = model.particle("mass", 1.0)
    x, y = model.state("x", start=1.0), model.state("y")
    model.state_equation(x, y)
    model.state_equation(y, -1e4 * x)
    model.force("act", mass, fx=x)
    model.scene("runs", ["act"], start={mass.x: 0.0, mass.y: 0.0, mass.vx: 0.0, mass.vy: 0.0})
    r = load(model, folder=workshop).simulate(1.0, 101, rtol=1e-8)
    assert_allclose(r.y("x"), np.cos(100 * r.t), atol=1e-5)
    assert r.stats["steps"] < 250  # 0.5 rad each, by their error; 1800 by a rate of 1e4


def test_chains_of_integrators_have_no_fast_state(workshop: Path) -> None:
    """x' = 1e6 y and y' = 0.1 v: a large factor, and no rate at which anything decays."""
    model = Model("chain_of_integrators")
    mass = model.particle("mass", 1.0)
    x, y = model.state("x"), model.state("y")
    model.state_equation(x, 1e6 * y)
    model.state_equation(y, 0.1 * mass.vx)
    model.force("act", mass, fx=1.0, fy=x)
    model.scene("runs", ["act"], start={mass.x: 0.0, mass.y: 0.0, mass.vx: 1.0, mass.vy: 0.0})
    r = load(model, folder=workshop).simulate(0.05, 11)
    assert_allclose(r.y("x"), 1e5 * (r.t**2 / 2 + r.t**3 / 6), rtol=1e-6, atol=1e-6)
    assert r.stats["steps"] < 50
