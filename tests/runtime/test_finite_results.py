"""A force that is no number ends a result before it, by name, whichever analysis asks for it."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Piecewise, log, pi, sin, sqrt

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

FIRST = 0.5 + np.arcsin(0.6) / (2 * np.pi)  # s, where the flap closes


def valve_of(workshop: Path, scene: str) -> Machine:
    """A flow through a flap that is meant for openings > 0, and a mass that is held or swings."""
    model = Model("valve")
    flap, mass = model.body("flap", mass=1.0, inertia=1e-3), model.particle("mass", mass=1.0)
    model.revolute("hinge", model.ground, flap)
    model.torque("flow", on=flap, value=-4 * sqrt(flap.phi))
    model.driver("motor", flap.phi, 0.3 + 0.5 * sin(2 * pi * t))
    model.absolute("rail", mass, "y", 0.0)
    model.force("spring", mass, fx=-mass.x)
    model.driver("hold", mass.x, 0.1 + 0 * t)
    model.scene("led", ["flow"], ["motor", "hold"])
    model.scene("free", ["flow", "spring"], ["motor"], start={mass.x: 0.1, mass.vx: 0.0})
    return load(model, scene, folder=workshop)


@pytest.fixture(scope="module")
def valve(workshop: Path) -> Machine:
    return valve_of(workshop, "led")


@pytest.mark.parametrize("analysis", ["inverse_dynamics", "simulate"])
def test_results_end_before_what_is_no_number(valve: Machine, analysis: str) -> None:
    r = getattr(valve, analysis)(1.0, 9)
    assert r.outcome is Outcome.NOT_FINITE
    assert_allclose(r.t, np.arange(5) / 8)
    assert_allclose(r.reaction("motor", "torque"), 4 * np.sqrt(r.q("flap.phi")), atol=0.03)
    assert f"no results beyond t = {FIRST:.9g} s; the last row is that of t = 0.5 s" in r.message
    assert f"The force of 'flow' along flap.phi is not finite at t = {FIRST:.9g} s" in r.message


def test_kinematics_asks_for_no_force(valve: Machine) -> None:
    r = valve.kinematics(1.0, 9)
    assert r.outcome is Outcome.OK
    assert_allclose(r.a("flap.phi"), -0.5 * (2 * np.pi) ** 2 * np.sin(2 * np.pi * r.t), atol=1e-9)
    assert "From t = 0.625 s on some forces, reactions or energies are not numbers" in r.message


def test_a_first_instant_that_is_no_number(valve: Machine) -> None:
    r = valve.inverse_dynamics([0.7, 0.9])
    assert r.outcome is Outcome.NOT_FINITE
    assert r.message.startswith("There are no results from the first instant on, t = 0.7 s.")


def test_runs_whose_motion_needs_no_such_force(workshop: Path) -> None:
    """The mass swings on; members of an ensemble fail as single runs do."""
    machine = valve_of(workshop, "free")
    instants = np.linspace(0.0, 1.0, 9)
    for settings in {}, {"method": "bdf"}, {"accuracy": 1e-5}:
        r = machine.simulate(1.0, instants, **settings)
        assert (r.outcome, len(r.t)) == (Outcome.NOT_FINITE, 5)
        assert f"'flow' along flap.phi is not finite at t = {FIRST:.9g} s" in r.message
    starts = {"mass.x": np.array([0.1, 0.2])}
    members = machine.ensemble(1.0, instants, starts=starts, progress=False)
    assert members.outcome.values.tolist() == ["NOT_FINITE"] * 2
    assert np.isnan(members.power.values[:, 5:]).all()
    assert np.isfinite(members.power.values[:, :5]).all()


def test_a_potential_that_is_no_number_while_its_force_is(workshop: Path) -> None:
    """V = -5 log x, with the force 5/x also where x < 0."""
    model = Model("well")
    slide = model.particle("slide", mass=2.0)
    model.absolute("rail", slide, "y", 0.0)
    model.potential("well", -5 * log(slide.x))
    model.driver("feed", slide.x, 0.5 - 0.5 * t**2)
    model.scene("run", ["well"], drivers=["feed"])
    machine, instants = load(model, "run", folder=workshop), [0.0, 0.5, 1.2, 1.5]
    for r in machine.inverse_dynamics(instants), machine.simulate(1.5, instants):
        assert (r.outcome, r.t.tolist()) == (Outcome.NOT_FINITE, [0.0, 0.5])
        assert "The potential of 'well' is not finite at t = 1 s" in r.message
        assert_allclose(r.energy("potential"), -5 * np.log(r.q("slide.x")))
    moved = machine.kinematics(instants)
    assert moved.outcome is Outcome.OK
    assert "From t = 1.2 s on some forces, reactions or energies" in moved.message


@pytest.mark.parametrize("kind", ["table", "root", "step"])
def test_kinematics_asks_for_no_law_of_a_force(kind: str, workshop: Path) -> None:
    """Neither its end nor its jump is one of the motion; inverse dynamics names them."""
    model = Model(f"logged_{kind}")
    slide = model.particle("slide", mass=2.0)
    model.absolute("rail", slide, "y", 0.0)
    table = model.table("gas", [0, 0.5, 1.0], [0, 20.0, 10.0])
    force = {"table": table(t), "root": sqrt(1 - t), "step": Piecewise((1, t < 1), (2, True))}
    model.force("push", slide, fx=force[kind])
    model.driver("feed", slide.x, t**2)
    model.scene("run", ["push"], drivers=["feed"])
    machine = load(model, "run", folder=workshop)
    for instants in [0.0, 0.7, 1.3], [1.5, 1.8]:
        r = machine.kinematics(instants)
        assert (r.outcome, r.t.tolist(), r.events) == (Outcome.OK, instants, ())
        assert_allclose(r.a("slide.x"), 2.0)
        assert_allclose(r.at(1.2).q("slide.x"), 1.44)
    forces = machine.inverse_dynamics([1.5, 1.8])
    ends = {"table": Outcome.OUT_OF_RANGE, "root": Outcome.DISCONTINUOUS, "step": Outcome.OK}
    assert forces.outcome is ends[kind]
    assert ("No instant that was asked for is reached" in forces.message) == (kind != "step")
