"""The library's slider-crank through the runtime's door: the book's section 8.2."""

import numpy as np
import pytest

from runtime import load


@pytest.mark.parametrize("method", ["energy", "settling"])
@pytest.mark.parametrize(
    ("scene", "crank", "slider"),
    [
        ("gravity_equilibrium", 1.5 * np.pi, 2.8722813232690143),
        ("gas_equilibrium", 3.527376, 1.565126),
        ("gas_equilibrium_as_printed", 4.597068, 2.651354),
    ],
)
def test_rest_positions(method: str, scene: str, crank: float, slider: float) -> None:
    rest = load("slider_crank", scene).equilibrium(method)
    tolerance = 1e-12 if scene == "gravity_equilibrium" else 5e-7
    assert rest["crank.phi"] == pytest.approx(crank, abs=tolerance)
    assert rest["slider.x"] == pytest.approx(slider, abs=tolerance)
    assert rest.stable


@pytest.mark.parametrize("rod", [3.5, 2.5, 2.2, 2.1])
def test_both_models_move_alike(rod: float) -> None:
    t = np.linspace(0.0, 1.0, 101)
    whole, massless = (
        load("slider_crank", scene).kinematics(t, parameters={"rod_length": rod})
        for scene in ("kinematics", "kinematics_massless_rod")
    )
    phi = np.pi / 4 + 2.0 * np.pi * t
    expected = 2.0 * np.cos(phi) + np.sqrt(rod**2 - 4.0 * np.sin(phi) ** 2)
    np.testing.assert_allclose(whole.q("slider.x"), expected, atol=1e-13)
    np.testing.assert_allclose(massless.q("slider.x"), expected, atol=1e-13)


def test_torque_of_the_drive_at_constant_speed() -> None:
    """Virtual work: the torque is the rate of energy over the speed; the crank adds nothing."""
    machine = load("slider_crank", "inverse_dynamics_without_gas")
    t = np.linspace(0.0, 1.0, 101)
    result = machine.inverse_dynamics(t)
    speeds = np.array([result.v(f"rod.{name}") for name in ("x", "y", "phi")])
    pushes = np.array([result.a(f"rod.{name}") for name in ("x", "y", "phi")])
    power = 35.0 * (speeds * pushes).sum(axis=0) + 25.0 * result.v("slider.x") * result.a(
        "slider.x"
    )
    np.testing.assert_allclose(
        result.reaction("crank_drive", "torque"), power / (2.0 * np.pi), atol=1e-8
    )


@pytest.mark.parametrize(("inertia", "cycles"), [(450.0, 3.8157), (900.0, 4.3010)])
def test_cycles_of_the_compressor(inertia: float, cycles: float) -> None:
    machine = load("slider_crank", "compressor")
    t = np.linspace(0.0, 3.0, 30001)
    result = machine.simulate(3.0, t, rtol=1e-10, parameters={"J1": inertia})
    turns = (result.q("crank.phi") - np.pi) / (2.0 * np.pi)
    assert result.outcome.name == "OK"
    whole = np.interp(np.arange(5.0, 11.0), turns, t)
    assert 1.0 / np.diff(whole).mean() == pytest.approx(cycles, abs=2e-3)


def test_light_flywheel_stalls() -> None:
    machine = load("slider_crank", "compressor")
    result = machine.simulate(1.0, np.linspace(0.0, 1.0, 101), rtol=1e-11, parameters={"J1": 225.0})
    assert result.events[-1].name == "gas: slider_vx > 0"
    assert result.events[-1].time == pytest.approx(0.114906810, abs=1e-9)
    assert result.q("crank.phi")[-1] == pytest.approx(5.796224666, abs=1e-9)
    assert result.q("slider.x")[-1] == pytest.approx(5.140072465, abs=1e-9)
    assert np.abs(result.v("slider.x")[12:]).max() < 1e-12
