"""Equilibrium with states and sampled values, against balances written by hand."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from sympy import Max, Min, sqrt

from codegen import Model, t
from codegen.declare.body import Body
from codegen.errors import AnalysisError
from runtime import Outcome, load
from runtime.machine_facade import Machine
from runtime.statics.rest_stability import Stability

WEIGHT = 9.81 * 0.5  # N m at the level arm of 1 kg and 0.5 m
SERVO = 6.0  # N m


def arm(name: str, control: Callable[[Model, Body], object], **words: object) -> Machine:
    """An arm under gravity, with a torque."""
    model = Model(name, gravity=(0, -9.81))
    link = model.body("link", mass=1.0, inertia=0.05)
    model.revolute("pin", model.ground.at(0, 0), link.at(-0.5, 0))
    model.torque("drive", on=link, value=control(model, link) - 4.0 * link.omega)
    model.scene("rest", ["drive", "gravity"], start={link.phi: 0.0, link.omega: 0.0}, **words)
    return load(model)


@pytest.fixture(autouse=True)
def in_a_folder(workshop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(workshop)


def test_a_motor_that_a_spring_stalls() -> None:
    """12 V over 2 ohm are 6 A, whose torque the spring and the weight balance."""

    def motor(model: Model, link: Body) -> object:
        current = model.state(
            "current", lambda i: (12 - 2 * i - 0.1 * link.omega) / 0.01, start=1.0, unit="A"
        )
        return 0.1 * current - 20.0 * link.phi

    machine = arm("stalled_motor", motor)
    rest = machine.equilibrium()
    angle = brentq(lambda x: 0.6 - 20.0 * x - WEIGHT * np.cos(x), -1.0, 1.0, xtol=1e-15)
    assert rest.outcome is Outcome.OK
    assert abs(rest["current"] - 6.0) < 1e-12
    assert abs(rest["link.phi"] - angle) < 1e-12
    assert "At rest with current = 6 A." in rest.message
    assert rest.stability is Stability.UNKNOWN
    assert rest.independent == ("link.phi",)
    stiffness = 20.0 - WEIGHT * np.sin(angle)  # with the current as it is
    assert abs(rest.stiffness_matrix[0, 0] - stiffness) < 1e-6
    assert np.abs(machine.simulate(0.5, start=rest).v("link.omega")).max() < 1e-10
    assert abs(machine.equilibrium(guess={"current": 40.0})["current"] - 6.0) < 1e-12


@pytest.mark.parametrize("gain", [0.0, 40.0])
def test_an_integral_holds_an_arm_where_it_is_told_to_be(gain: float) -> None:
    """The integral alone is no spring: its value and the angle follow from both equations."""

    def integral(model: Model, link: Body) -> object:
        error = 1.0 - link.phi
        return gain * error + 60.0 * model.state("total", rate=error)

    rest = arm(f"integral_{gain:g}", integral).equilibrium()
    assert abs(rest["link.phi"] - 1.0) < 1e-12
    assert abs(rest["total"] - WEIGHT * np.cos(1.0) / 60.0) < 1e-12
    assert rest.a("link.phi")[0] == pytest.approx(0.0, abs=1e-10)


def test_sampled_values_rest_where_samples_renew_nothing() -> None:
    """A sum with a bound and a torque with a bound, the torque from the sum of its sample."""

    def sampled(model: Model, link: Body) -> object:
        error = 1.0 - link.phi
        total = model.sampled("total", 0.01, lambda s: Max(-0.5, Min(0.5, s + 0.01 * error)))
        return model.sampled("u", 0.01, Max(-SERVO, Min(SERVO, 40.0 * error + 60.0 * total)))

    rest = arm("sampled_rest", sampled).equilibrium()
    assert abs(rest["link.phi"] - 1.0) < 1e-10
    assert abs(rest["u"] - WEIGHT * np.cos(1.0)) < 1e-10
    assert abs(rest["total"] - WEIGHT * np.cos(1.0) / 60.0) < 1e-10


def test_a_latch_keeps_its_start_value() -> None:
    def latched(model: Model, link: Body) -> object:
        model.latch("pushed", when=link.omega > 100.0)
        pushed = model.states["pushed"].symbol
        return (1.0 - pushed) * 2.0 - 20.0 * link.phi

    rest = arm("latched_rest", latched).equilibrium()
    angle = brentq(lambda x: 2.0 - 20.0 * x - WEIGHT * np.cos(x), -1.0, 1.0, xtol=1e-15)
    assert abs(rest["link.phi"] - angle) < 1e-12
    assert rest["pushed"] == 0.0


def test_a_held_machine_has_states_at_rest() -> None:
    model = Model("held_filter")
    link = model.body("link", mass=1.0, inertia=0.1)
    model.revolute("pin", model.ground.at(0, 0), link.at(0, 0))
    model.driver("hand", link.phi, 0.5 + 0 * t)
    lag = model.state("lag", lambda y: 3.0 * (link.phi - y))
    model.torque("brake", on=link, value=-lag)
    model.scene("held", ["brake"], drivers=["hand"])
    rest = load(model).equilibrium()
    assert rest.outcome is Outcome.OK
    assert abs(rest["lag"] - 0.5) < 1e-12


@pytest.mark.parametrize("level", [0.0, 1e-6, 0.5])
def test_a_tank_whose_outflow_has_a_value_on_one_side(level: float) -> None:
    """0.01 flows in, 0.1 sqrt(y) out: below y = 0 there is no root."""

    def tank(model: Model, link: Body) -> object:
        level_now = model.state("y", lambda y: 0.01 - 0.1 * sqrt(y), start=level)
        return level_now - 20.0 * link.phi

    rest = arm(f"tank_{level:g}".replace(".", "_").replace("-", "_"), tank).equilibrium()
    assert rest.outcome is Outcome.OK
    assert abs(rest["y"] - 0.01) < 1e-10


def test_slopes_without_a_value_end_the_search() -> None:
    """Of y and of -y there are roots at y = 0 alone."""

    def level(model: Model, link: Body) -> object:
        return model.state("y", lambda y: 0.5 + sqrt(y) + sqrt(-y), start=0.0) - 20.0 * link.phi

    rest = arm("lone_value", level).equilibrium()
    assert rest.outcome is Outcome.UNBALANCED
    assert rest.message.startswith("No equilibrium found:")


def test_where_no_state_rests_it_is_named() -> None:
    machine = arm("restless", lambda model, link: 6.0 * model.state("sum", rate=1 + link.phi**2))
    rest = machine.equilibrium()
    assert rest.outcome is Outcome.UNBALANCED
    assert "the rate of sum, or what a sample would change it by, is not zero" in rest.message
    with pytest.raises(AnalysisError, match=r"settling moves positions alone.*sum.*energy"):
        machine.equilibrium("settling")


def test_functions_of_a_run_are_no_equations() -> None:
    machine = arm("functions_at_rest", lambda model, _: model.sampled("torque", 0.01))
    with pytest.raises(AnalysisError, match=r"torque is computed by functions that a run brings"):
        machine.equilibrium()
