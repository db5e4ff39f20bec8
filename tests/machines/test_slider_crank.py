"""Section 8.2 of the book: every number of it, against closed forms and independent solutions."""

from math import asin, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from sympy import cos, sin

from codegen import Model, t
from runtime import Machine, Outcome, Result, load

DATA = Path(__file__).parent.parent / "data"


def scene(name: str) -> Machine:
    return load("slider_crank", name)


def residuals(run: Result) -> tuple[float, float]:
    """Largest |Φ| and |Φ_q q̇ - ν| of a run."""
    data = run.data
    return float(data["constraint_residual"].max()), float(data["velocity_residual"].max())


# -- equilibrium ---------------------------------------------------------------------------------


def test_under_gravity_the_crank_hangs_down() -> None:
    rest = scene("gravity_equilibrium").equilibrium()
    assert rest.stable
    assert abs(rest["crank.phi"] - 3 * pi / 2) < 1e-9
    assert abs(rest["slider.x"] - sqrt(3.5**2 - 4)) < 1e-9


@pytest.mark.parametrize(
    ("name", "guess", "angle"),
    [
        ("gas_equilibrium_as_printed", {}, 4.597068),
        ("gas_equilibrium", {"crank.phi": 4.0}, 3.527376),
    ],
)
def test_gas_moves_the_equilibrium(name: str, guess: dict[str, float], angle: float) -> None:
    rest = scene(name).equilibrium(guess=guess)
    assert rest.stable
    assert abs(rest["crank.phi"] - angle) < 5e-7


# -- kinematics ----------------------------------------------------------------------------------


@pytest.mark.parametrize("length", [3.5, 2.5, 2.2, 2.1])
def test_both_models_move_alike_and_as_trigonometry_says(length: float) -> None:
    instants = np.linspace(0.0, 1.0, 201)
    angle = pi / 4 + 2 * pi * instants
    x = 2 * np.cos(angle) + np.sqrt(length**2 - 4 * np.sin(angle) ** 2)
    for name in ("kinematics", "kinematics_massless_rod"):
        run = scene(name).kinematics(instants, parameters={"rod_length": length})
        assert run.outcome is Outcome.OK
        assert np.abs(run.q("slider.x") - x).max() < 1e-11
        assert max(residuals(run)) < 1e-10


def test_the_models_agree_in_accelerations() -> None:
    instants = np.linspace(0.0, 1.0, 101)
    first = scene("kinematics").kinematics(instants)
    second = scene("kinematics_massless_rod").kinematics(instants)
    scale = np.abs(first.a("slider.x")).max()
    assert np.abs(first.a("slider.x") - second.a("slider.x")).max() < 1e-11 * scale


def test_a_rod_that_is_too_short_locks() -> None:
    run = scene("kinematics").kinematics(np.linspace(0, 1, 101), parameters={"rod_length": 1.9})
    assert run.outcome is Outcome.LOCKED
    assert abs(run.t[-1] - (asin(0.95) - pi / 4) / (2 * pi)) < 1e-6
    assert "0.0744" in run.message
    assert np.isfinite(run.q("slider.x")).all()


# -- inverse dynamics ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["inverse_dynamics", "inverse_dynamics_without_gas"])
@pytest.mark.parametrize("speed", [2 * pi, 4 * pi])
def test_the_driver_pays_for_energy_and_gas(name: str, speed: float) -> None:
    machine = scene(name)
    instants = np.linspace(0.0, 2 * pi / speed, 721)
    run = machine.inverse_dynamics(instants, parameters={"drive_speed": speed})
    masses = np.zeros(len(machine.coordinates))
    machine.kernels.mass(run.samples.q[0], machine.parameter_values(), masses)
    rate = (run.samples.v * masses * run.samples.a).sum(axis=1)
    gas = run.power("gas") if "gas" in machine.effects else np.zeros_like(instants)
    driver = run.power("crank_drive")
    scale = np.abs(driver).max()
    assert np.abs(driver + gas - rate).max() < 1e-10 * scale
    torque = run.reaction("crank_drive", "torque")
    assert np.abs(torque * speed - driver).max() < 1e-10 * scale


def test_the_torque_of_the_inverse_run_drives_the_same_motion(tmp_path: Path) -> None:
    count, speed = 256, 2 * pi
    run = scene("inverse_dynamics_without_gas").inverse_dynamics(np.arange(count) / count)
    harmonics = np.fft.rfft(run.reaction("crank_drive", "torque")) / count
    torque = harmonics[0].real
    for k in range(1, 31):
        angle = k * speed * t
        torque += 2 * harmonics[k].real * cos(angle) - 2 * harmonics[k].imag * sin(angle)
    model = Model("fed_back")
    crank = model.body("crank", mass=200.0, inertia=450.0)
    rod = model.body("rod", mass=35.0, inertia=35.0)
    slider = model.body("slider", mass=25.0, inertia=0.02)
    model.revolute("A", model.ground.at(0, 0), crank.at(0, 0))
    model.revolute("B", crank.at(2, 0), rod.at(-1.75, 0))
    model.revolute("C", rod.at(1.75, 0), slider.at(0, 0))
    model.translational("guide", model.ground, slider)
    model.torque("fed", on=crank, value=torque)
    start = {crank.phi: pi / 4, crank.omega: speed}
    model.scene("turn", ["fed"], start=start, guess={rod.x: 3.0, rod.phi: -0.4, slider.x: 4.6})
    instants = np.linspace(0.0, 1.0, 101)
    free = load(model, "turn", folder=tmp_path).simulate(1.0, instants, rtol=1e-11)
    assert np.abs(free.q("crank.phi") - (pi / 4 + speed * instants)).max() < 1e-7
    angle = pi / 4 + speed * instants
    x = 2 * np.cos(angle) + np.sqrt(3.5**2 - 4 * np.sin(angle) ** 2)
    assert np.abs(free.q("slider.x") - x).max() < 1e-7


# -- dynamics ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def reference() -> np.ndarray:
    table = np.genfromtxt(DATA / "compressor_J450.csv", delimiter=",", names=True)
    return table[table["t"] <= 0.9 + 1e-12]


@pytest.mark.parametrize(("method", "correction"), [
    ("dop853", "step"), ("dopri5", "step"), ("dop853", "stage"),
])  # fmt: skip
def test_the_compressor_follows_the_independent_solution(
    reference: np.ndarray, method: str, correction: str
) -> None:
    run = scene("compressor").simulate(
        0.9, reference["t"], method=method, rtol=1e-10, correction=correction
    )
    assert run.outcome is Outcome.OK
    assert np.abs(run.q("crank.phi") - reference["phi1"]).max() < 1e-8
    force = reference["RAx_ground_on_crank"]
    difference = np.abs(run.reaction("A", "fx") - force)
    assert (difference / np.abs(force)).max() < 1e-6
    assert max(residuals(run)) < 1e-10


@pytest.mark.parametrize(("inertia", "cycles"), [(450.0, 3.8157), (900.0, 4.3010)])
def test_cycles_per_second(inertia: float, cycles: float) -> None:
    run = scene("compressor").simulate(1.0, rtol=1e-10, parameters={"J1": inertia})
    starts = [e.time for e in run.events if e.name == "gas: slider_vx > 0" and e.direction > 0]
    assert abs(1 / (starts[-1] - starts[-2]) - cycles) < 5e-5
    assert max(residuals(run)) < 1e-10


def test_the_lightest_flywheel_stalls_and_is_held_by_the_gas() -> None:
    run = scene("compressor").simulate(
        1.0, np.linspace(0, 1, 201), rtol=1e-10, parameters={"J1": 225.0}
    )
    assert run.outcome is Outcome.OK
    stall = run.events[-1]
    assert (stall.name, stall.what) == ("gas: slider_vx > 0", "holds")
    assert abs(stall.time - 0.114906810) < 1e-9
    assert abs(run.q("crank.phi")[-1] - 5.796224666) < 1e-9
    assert np.abs(run.v("crank.phi")[run.t > stall.time]).max() < 1e-12
    assert np.abs(run.share("gas: slider_vx > 0")[23:] - 0.1643).max() < 5e-5
    assert max(residuals(run)) < 1e-10


def test_energy_changes_by_the_work_of_gas_and_motor() -> None:
    instants = np.linspace(0.0, 0.09, 20001)  # up to the opening of the valve: smooth
    run = scene("compressor").simulate(0.09, instants, rtol=1e-12)
    power = run.power("gas") + run.power("motor")
    h = instants[1] - instants[0]
    work = h / 3 * (power[0] + power[-1] + 4 * power[1:-1:2].sum() + 2 * power[2:-2:2].sum())
    energy = run.energy()
    assert abs(energy[-1] - energy[0] - work) < 1e-9 * abs(energy[0])


def test_a_massless_rod_gives_the_hand_derived_acceleration() -> None:
    machine = scene("compressor_massless_rod")
    run = machine.simulate(0.08, np.linspace(0, 0.08, 17), rtol=1e-11)
    phi, omega = run.q("crank.phi"), run.v("crank.phi")
    s, c = np.sin(phi), np.cos(phi)
    root = np.sqrt(3.5**2 - 4 * s**2)
    slope = -2 * s - 4 * s * c / root
    bend = -2 * c - 4 * (c**2 - s**2) / root - 16 * s**2 * c**2 / root**3
    x = 2 * c + root
    gas = np.where(run.samples.v[:, 3] > 1e-9, -282857 / (6 - x) + 62857, 0.0)
    torque = 41450 + (25 * 9.81 + gas) * slope - 25 * slope * bend * omega**2
    expected = torque / (450 + 25 * slope**2)
    assert np.abs(run.a("crank.phi") - expected).max() < 1e-9 * np.abs(expected).max()
