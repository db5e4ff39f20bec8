"""Simulation through the public face: motion, outputs, events, ends and refusals."""

from collections.abc import Callable

import numpy as np
import pytest

from codegen.errors import AnalysisError, InputError
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

TIGHT = {"rtol": 1e-10, "atol": 1e-10}


def test_energy_of_a_swinging_pendulum(pendulum: Machine) -> None:
    t = np.linspace(0.0, 5.0, 101)
    result = pendulum.simulate(5.0, t, **TIGHT)
    assert result.outcome is Outcome.OK
    np.testing.assert_array_equal(result.t, t)
    np.testing.assert_allclose(result.energy(), result.energy()[0], atol=1e-7)
    phi, omega = result.q("bar.phi"), result.v("bar.omega")
    height = 2.0 * 9.81 * (np.sin(0.5) - np.sin(phi))
    np.testing.assert_allclose(0.5 * 2.5 * omega**2, height, atol=1e-7)
    np.testing.assert_allclose(result.a("bar.phi"), -2.0 * 9.81 * np.cos(phi) / 2.5, atol=1e-12)


def test_bearing_carries_weight_and_centripetal_force(pendulum: Machine) -> None:
    result = pendulum.simulate(2.0, np.linspace(0.0, 2.0, 41), **TIGHT)
    np.testing.assert_allclose(result.reaction("pin", "fx"), 2.0 * result.a("bar.x"), atol=1e-11)
    np.testing.assert_allclose(
        result.reaction("pin", "fy"), 2.0 * (result.a("bar.y") + 9.81), atol=1e-11
    )


def test_residuals_stay_at_rounding(free: Machine) -> None:
    result = free.simulate(2.0, np.linspace(0.0, 2.0, 201))
    assert result.samples.residual[:, 0].max() < 1e-12
    assert result.samples.residual[:, 1].max() < 1e-10


def test_parameters_change_the_motion(pendulum: Machine) -> None:
    still = pendulum.simulate(1.0, [0.0, 1.0], parameters={"gy": 0.0})
    assert still.q("bar.phi").tolist() == [0.5, 0.5]
    assert still.parameters["gy"] == 0.0
    assert pendulum.simulate(1.0, [0.0, 1.0]).q("bar.phi")[1] < 0.0


def test_start_from_an_assembled_state(pendulum: Machine) -> None:
    start = pendulum.assemble(start={"bar.phi": -1.0, "bar.omega": 2.0}, t=1.0)
    result = pendulum.simulate(1.5, [1.0, 1.5], start=start)
    assert result.q("bar.phi")[0] == -1.0
    assert result.v("bar.omega")[0] == 2.0


def test_switching_force_makes_events(gas: Machine) -> None:
    result = gas.simulate(3.0, np.linspace(0.0, 3.0, 31), start={"crank.omega": 10.0})
    assert result.events
    event = result.events[0]
    assert event.name == "gas: slider.vx > 0"
    assert event.direction in {-1, 1}
    assert abs(event.v[6]) < 1e-6
    np.testing.assert_array_equal(event.state, np.concatenate([event.q, event.v]))
    assert result.stats["events"] == len(result.events)
    assert set(np.unique(result.samples.modes)) == {0, 1, 2}
    # The gas stops the machine, and holds it with a part of its force.
    standing = result.samples.modes[:, 0] == 2
    assert np.abs(result.v("slider.vx")[standing]).max() < 1e-12
    assert np.all((result.samples.share[standing] > 0.0) & (result.samples.share[standing] < 1.0))
    # In the end the push holds the machine against gravity.
    assert result.events[-1].what == "holds"
    still = result.t > result.events[-1].time
    assert np.abs(result.samples.v[still]).max() < 1e-12


def test_stopped_run_keeps_what_it_has(pendulum: Machine) -> None:
    result = pendulum.simulate(100.0, np.linspace(0.0, 100.0, 1001), max_steps=20)
    assert result.outcome is Outcome.MAX_STEPS
    assert result.failed
    assert 1 < len(result.t) < 1001
    assert f"Stopped at t = {result.t[-1]:.9g} s" in result.message
    assert "max_steps" in result.message
    np.testing.assert_allclose(result.energy(), result.energy()[0], atol=1e-5)


def test_driver_torque_of_the_inverse_run_appears_in_dynamics(driven: Machine) -> None:
    """A fully driven machine may be simulated; its drivers carry the motion."""
    t = np.linspace(0.0, 0.5, 11)
    inverse = driven.inverse_dynamics(t)
    dynamic = driven.simulate(0.5, t)
    np.testing.assert_allclose(dynamic.q("slider.x"), inverse.q("slider.x"), atol=1e-12)
    np.testing.assert_allclose(
        dynamic.reaction("crank_drive", "torque"),
        inverse.reaction("crank_drive", "torque"),
        rtol=1e-9,
    )


def test_masses_are_needed(make: Callable[..., Machine]) -> None:
    machine = make("slider_crank", "bare", driven=True, masses=False)
    with pytest.raises(AnalysisError, match="a simulation needs masses"):
        machine.simulate(1.0)


def test_wrong_input_of_the_integrator_is_told(pendulum: Machine) -> None:
    with pytest.raises(InputError, match="dopri7"):
        pendulum.simulate(1.0, method="dopri7")
    with pytest.raises(InputError, match="t_end"):
        pendulum.simulate(-1.0)
    with pytest.raises(AnalysisError, match="must increase"):
        pendulum.simulate(1.0, [0.5, 0.2])
