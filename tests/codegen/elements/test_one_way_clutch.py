"""A one-way clutch: its torque by hand, and motions in closed form."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from sympy import Piecewise, sin

from codegen import Body, Model, t
from runtime import Outcome, Result, load
from tests.codegen.elements.test_library_forces import balanced, pair
from tests.codegen.workbench import Interpreted

J_I, J_J = 0.5, 0.3


def shafts(name: str) -> tuple[Model, Body, Body]:
    """Two bodies on bearings of their own."""
    model = Model(name)
    one, two = (model.body(n, mass=1.0, inertia=size) for n, size in (("one", J_I), ("two", J_J)))
    model.revolute("A", model.ground.at(0, 0), one)
    model.revolute("B", model.ground.at(1, 0), two)
    return model, one, two


def simulated(model: Model, folder: Path, t_end: float) -> Result:
    instants = np.linspace(0, t_end, 121)
    run = load(model, folder=folder).simulate(t_end, instants, rtol=1e-11, atol=1e-12)
    assert run.outcome is Outcome.OK, run.message
    return run


def start(one: Body, two: Body, first: float, second: float) -> dict[object, float]:
    return {one.phi: 0.0, two.phi: 0.0, one.omega: first, two.omega: second}


@pytest.mark.parametrize("speed", [-1.0, 1.0])
def test_clutch_by_hand(speed: float) -> None:
    model, first, second = pair()
    model.one_way_clutch("clutch", first, second, 7.0)
    machine = Interpreted(model)
    s = machine.state(1)
    s.v[5] = s.v[2] + speed
    modes = [int(g > 0) for g in machine.vector("switching", s)]
    torque = 7.0 if speed < 0 else 0.0
    found = machine.vector("applied_forces", s, modes=modes)
    assert_allclose(found, [0, 0, -torque, 0, 0, torque], atol=0)
    balanced(machine, s, modes=modes)


def test_driven_body_overruns_and_is_caught_again(tmp_path: Path) -> None:
    """2 N m for 1 s, back for 1 s, and on: locked, overrunning, locked from t = 3 s on."""
    model, one, two = shafts("freewheel")
    model.one_way_clutch("clutch", one, two, 50.0)
    model.torque("motor", one, Piecewise((2.0, t < 1), (-2.0, t < 2), (2.0, True)))
    model.scene("run", ["clutch", "motor"], start=start(one, two, 0.0, 0.0))
    run = simulated(model, tmp_path, 4.0)
    together, alone = 2.0 / (J_I + J_J), 2.0 / J_I
    caught = 3.0  # the driver falls for a second and rises as long: it has lost nothing
    driven = np.where(run.t < 1, together * run.t, together)
    driven = np.where(run.t > caught, together * (1 + run.t - caught), driven)
    fallen = np.where(run.t < 2, run.t - 1, 3 - run.t)
    driver = np.where((run.t > 1) & (run.t < caught), together - alone * fallen, driven)
    assert_allclose(run.v("two.phi"), driven, atol=1e-8)
    assert_allclose(run.v("one.phi"), driver, atol=1e-8)


def test_clutch_slips_at_its_capacity(tmp_path: Path) -> None:
    """It engages a speed of 3 rad/s in t_1, and slips again where the motor asks for too much."""
    model, one, two = shafts("slip")
    model.one_way_clutch("clutch", one, two, 1.5)
    model.torque("motor", one, Piecewise((0.0, t < 1), (6.0, True)))
    model.scene("run", ["clutch", "motor"], start=start(one, two, 3.0, 0.0), outputs="all")
    run = simulated(model, tmp_path, 2.0)
    engaged = 3.0 / (1.5 / J_I + 1.5 / J_J)
    assert 0.3 < engaged < 0.9
    common = J_I * 3.0 / (J_I + J_J)
    first = np.where(run.t < engaged, 3.0 - 1.5 / J_I * run.t, common)
    second = np.where(run.t < engaged, 1.5 / J_J * run.t, common)
    later = np.maximum(run.t - 1, 0.0)
    assert 6.0 * J_J / (J_I + J_J) > 1.5
    assert_allclose(run.v("one.phi"), first + (6.0 - 1.5) / J_I * later, atol=1e-8)
    assert_allclose(run.v("two.phi"), second + 1.5 / J_J * later, atol=1e-8)
    torque = np.where((run.t < engaged) | (run.t > 1), 1.5, 0.0)  # on the driven shaft
    beside = np.abs(run.t - 1) > 1e-9
    assert_allclose(run.torque("clutch")[beside], torque[beside], atol=1e-8)


def test_a_driver_that_swings_loses_the_wheel_and_catches_it(tmp_path: Path) -> None:
    """The driver has ω = cos t, and the wheel a load of 0.2 N m.

    The wheel follows until the driver slows down faster than the load alone would, sin t = 0.2/J_j,
    and falls by 0.2/J_j a second until the driver has its speed again.
    """
    model, one, two = shafts("rectifier")
    model.one_way_clutch("clutch", one, two, 50.0)
    model.driver("swing", one.phi, sin(t))
    model.torque("load", two, -0.2)
    model.scene("run", ["clutch", "load"], ["swing"], start={two.phi: 0.0, two.omega: 1.0})
    run = simulated(model, tmp_path, 4.0)
    fall = 0.2 / J_J
    left = np.arcsin(fall)
    caught = brentq(lambda time: np.cos(left) - fall * (time - left) - np.cos(time), 2, 4)
    away = (run.t > left) & (run.t < caught)
    expected = np.where(away, np.cos(left) - fall * (run.t - left), np.cos(run.t))
    assert away.sum() > 30
    assert (~away[run.t > left]).sum() > 5
    assert_allclose(run.v("two.phi"), expected, atol=1e-8)
