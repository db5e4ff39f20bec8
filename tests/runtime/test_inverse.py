"""Inverse dynamics against a hand-derived pendulum, power balance and free-body balance."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from codegen import Model
from codegen import t as time
from codegen.errors import AnalysisError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine


def test_torque_and_bearing_force_of_a_driven_pendulum(make: Callable[..., Machine]) -> None:
    """Constant speed: torque m g l cos(phi); bearing on bar m (l w^2 inwards + g upwards)."""
    machine = make("pendulum", "swing", driven=True)
    t = np.linspace(0.0, 4.0, 81)
    result = machine.inverse_dynamics(t)
    phi = 0.5 + 2.0 * t
    m, g, l, w = 2.0, 9.81, 1.0, 2.0  # noqa: E741
    torque = m * g * l * np.cos(phi)
    np.testing.assert_allclose(result.reaction("motor", "torque"), torque, atol=1e-11)
    np.testing.assert_allclose(result.power("motor"), torque * w, atol=1e-11)
    np.testing.assert_allclose(
        result.reaction("pin", "fx"), -m * l * w**2 * np.cos(phi), atol=1e-11
    )
    np.testing.assert_allclose(
        result.reaction("pin", "fy"), m * (g - l * w**2 * np.sin(phi)), atol=1e-11
    )


def test_driver_power_is_the_rate_of_energy(driven: Machine) -> None:
    t = np.linspace(0.0, 1.0, 20001)
    result = driven.inverse_dynamics(t)
    energy, power = result.energy(), result.power("crank_drive")
    rate = (energy[2:] - energy[:-2]) / (t[2:] - t[:-2])
    np.testing.assert_allclose(rate, power[1:-1], atol=2e-3 * np.abs(power).max() * 1e-2)


def test_switched_force_acts_in_its_half_of_the_cycle(make: Callable[..., Machine]) -> None:
    machine = make("slider_crank", "driven_gas", driven=True, gas=True)
    t = np.linspace(0.0, 1.0, 101)
    result = machine.inverse_dynamics(t)
    without = machine.inverse_dynamics(t, parameters={"push": 0.0})
    extra = result.reaction("crank_drive", "torque") - without.reaction("crank_drive", "torque")
    vx = result.v("slider.x")
    expected = np.where(vx > 0.0, 50000.0 * vx / (2.0 * np.pi), 0.0)
    np.testing.assert_allclose(extra, expected, atol=1e-6)
    np.testing.assert_array_equal(result.samples.modes[:, 0], vx > 0.0)


def test_masses_are_needed(make: Callable[..., Machine]) -> None:
    machine = make("slider_crank", "bare", driven=True, masses=False)
    with pytest.raises(AnalysisError, match="inverse dynamics needs masses"):
        machine.inverse_dynamics([0.0, 1.0])


def test_freedom_is_refused(free: Machine) -> None:
    with pytest.raises(AnalysisError, match="inverse dynamics needs a machine without freedom"):
        free.inverse_dynamics([0.0])


def test_a_lock_up_ends_at_the_last_instant_with_forces(tmp_path: Path) -> None:
    """A crank of 2 m cannot turn through with a rod of 1.9 m."""
    model = Model("short_rod")
    crank, slider = (model.body(name, mass=1.0, inertia=0.1) for name in ("crank", "slider"))
    model.revolute("A", model.ground.at(0, 0), crank.at(0, 0))
    model.translational("guide", model.ground, slider, axis=(1, 0))
    model.revolute_revolute("rod", crank.at(2, 0), slider.at(0, 0), 1.9)
    model.driver("drive", crank.phi, 0.5 + 2.0 * time)
    model.scene("turn", drivers=["drive"], guess={slider.x: 3.5})
    machine = load(model, folder=tmp_path)
    result = machine.inverse_dynamics(2.0)
    assert result.outcome is Outcome.LOCKED
    assert "Locked up at t = 0.3766" in result.message
    assert "driver drive cannot go on" in result.message
    assert result.t[-1] == pytest.approx(0.376)
    for values in (result.samples.v, result.samples.a, result.samples.reaction):
        assert np.isfinite(values).all()
    assert len(machine.kinematics(2.0).t) == len(result.t) + 1
