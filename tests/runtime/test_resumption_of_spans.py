"""Runs whose settings follow from their whole span go on with the bits of one that went through."""

from pathlib import Path

import numpy as np
import pytest
from sympy import Piecewise, exp, pi, sin, sqrt

from codegen import Model, t
from runtime import load, load_result
from runtime.integrate import run
from runtime.machine_facade import Machine
from runtime.results.result import Result
from tests.runtime.same_bits import same

RETURNS = ["step", "stage", "projection", "baumgarte", "hybrid"]
TAKEN_AGAIN = ", taken again from t = "


@pytest.fixture(autouse=True)
def _few_steps(often: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "_FIRST_CHUNK", 4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("spans")


@pytest.fixture(scope="module")
def motor(folder: Path) -> Machine:
    """Two rods on hinges, a current, a clock, a latch and a stop, driven by a voltage in pieces."""
    model = Model("resumed_motor", gravity=(0, -9.81))
    arm = model.body("arm", mass=1.0, inertia=0.02)
    rod = model.body("rod", mass=0.5, inertia=0.01)
    model.revolute("hinge", model.ground.at(0, 0), arm.at(-0.3, 0))
    model.revolute("elbow", arm.at(0.3, 0), rod.at(-0.2, 0))
    voltage = Piecewise(
        (12 * sqrt(t + 1), t < 0.5), (-6 * exp(-t), t < 1.37), (4 * sin(t**2), True)
    )
    current = model.state("current", lambda i: (voltage - 2 * i - 0.1 * arm.omega) / 0.05, unit="A")
    held = model.sampled("held", 0.02, -2 * arm.omega, delay=0.03, unit="N m")
    slow = model.latch("slow", when=arm.phi > 0.5, reset=arm.phi < -0.5)
    model.torque("motor", on=arm, value=current + held)
    model.torque("brake", on=rod, value=-0.02 * rod.omega, when=slow)
    model.torque("stop", on=arm, value=-80 * (arm.phi - 1), when=arm.phi > 1)
    start = {arm.phi: -pi / 4, arm.omega: 0.0, rod.phi: 0.3, rod.omega: 0.0}
    model.scene("turned", ["gravity", "motor", "brake", "stop"], start=start)
    return load(model, "turned", folder=folder)


def _same(whole: Result, rest: Result) -> None:
    same(whole, rest)
    later = [event for event in whole.events if event.time > rest.t[0]]
    assert [event.time for event in later] == [event.time for event in rest.events]
    assert whole.stats["steps"] == rest.stats["steps"]


def _parts(machine: Machine, method: str, formulation: str, correction: str, **options: float):
    """The run to 2 s in one go, and from 0.9 s on."""
    given = {"method": method, "formulation": formulation, "correction": correction, **options}
    instants = np.union1d(np.linspace(0.0, 2.0, 41), [0.9])
    whole = machine.simulate(2.0, instants, **given)
    begun = machine.simulate(0.9, instants[instants <= 0.9], **given)
    assert len(begun._motion.checkpoints.rows) > 1
    return whole, begun, begun.resume(2.0, instants[instants >= 0.9])


@pytest.mark.parametrize("correction", RETURNS)
@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau5", "bdf", "auto"])
def test_all_methods_and_returns(motor: Machine, method: str, correction: str) -> None:
    whole, _, rest = _parts(motor, method, "cartesian", correction)
    _same(whole, rest)
    assert TAKEN_AGAIN in rest.message
    _same(whole.at(rest.t), rest.at(rest.t))


@pytest.mark.parametrize("correction", ["step", "stage"])
@pytest.mark.parametrize("method", ["dop853", "radau5", "bdf"])
def test_reduced_coordinates(motor: Machine, method: str, correction: str) -> None:
    whole, _, rest = _parts(motor, method, "reduced", correction)
    _same(whole, rest)


@pytest.mark.parametrize("correction", RETURNS)
@pytest.mark.parametrize("method", ["dop853", "radau5", "bdf"])
def test_a_machine_without_functions_of_time(method: str, correction: str) -> None:
    machine = load("slider_crank", "compressor")
    whole, _, rest = _parts(machine, method, "cartesian", correction, rtol=1e-9)
    _same(whole, rest)
    stabilized = correction in ("baumgarte", "hybrid")
    assert ("Baumgarte's time, unless time_scale= is given" in rest.message) is stabilized


def test_a_time_that_is_given_needs_no_step_again() -> None:
    machine = load("slider_crank", "compressor")
    whole, begun, rest = _parts(machine, "dop853", "cartesian", "baumgarte", time_scale=0.002)
    _same(whole, rest)
    assert TAKEN_AGAIN not in rest.message
    assert rest._motion.checkpoints.rows[0] is begun._motion.checkpoints.rows[0]


def test_a_law_that_bends_in_the_first_instant(folder: Path) -> None:
    model = Model("resumed_crane", gravity=(0, -9.81))
    trolley = model.body("trolley", mass=2.0, inertia=0.1)
    load_ = model.body("load", mass=1.0, inertia=0.1)
    model.translational("rail", model.ground.at(0, 0), trolley.at(0, 0), axis=(1, 0))
    model.revolute("rope", trolley.at(0, 0), load_.at(0, 1))
    model.driver("travel", trolley.x, Piecewise((0, t <= 0), (0.7 * t, t < 1.3), (0.91, True)))
    model.scene("carried", ["gravity"], ["travel"], start={load_.phi: 0.2, load_.omega: 0.0})
    whole, begun, rest = _parts(load(model, folder=folder), "dop853", "cartesian", "step")
    assert 0.0 < begun._motion.ready.begin.t < rest._motion.ready.begin.t
    _same(whole, rest)
    assert rest._motion.ready.begin.t == whole._motion.ready.begin.t


def test_a_file_goes_on_alike(motor: Machine, tmp_path: Path) -> None:
    whole, begun, _ = _parts(motor, "dop853", "cartesian", "baumgarte")
    again = load_result(begun.save(tmp_path / "begun.nc"), motor)
    _same(whole, again.resume(2.0, whole.t[whole.t >= 0.9]))
