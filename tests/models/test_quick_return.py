"""Section 8.3 of the book: the shaper against closed forms and an independent solution."""

import runpy
from math import asin, atan2, cos, hypot, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
import sympy
from scipy.optimize import brentq

from codegen import t
from models.studies.drawing import draw
from models.studies.quick_return import CUT_ENDS, TORQUES, cycles_per_second, extremes, study, table
from models.studies.quick_return_figures import figures
from runtime import Machine, Outcome, Result, load

DATA = Path(__file__).parent.parent / "data"
MODEL = Path(__file__).parents[2] / "models" / "quick_return.py"
SPEED = 2 * pi


def scene(name: str) -> Machine:
    return load("quick_return", name)


def slider_at(phi: float) -> float:
    """x6 for an angle of the crank: the rocker points at the pin, the rod closes on y = 4."""
    pin = 1.5 * cos(phi), 2 + 1.5 * sin(phi)
    arm = 4 / hypot(*pin)
    return arm * pin[0] - sqrt(1.9**2 - (4 - arm * pin[1]) ** 2)


def crank_at(x: float, near: float) -> float:
    """The angle of the crank at which x6 = x, within a twentieth of a radian of `near`."""
    angle: float = brentq(lambda phi: slider_at(phi) - x, near - 0.05, near + 0.05, xtol=1e-15)
    return angle


CUT_END = crank_at(-4.0, 2.9955)
CUT_BEGIN = crank_at(1.2, 5.93)


# -- equilibrium ---------------------------------------------------------------------------------


def test_under_gravity_it_rests_where_no_torque_is_left() -> None:
    rest = scene("gravity_equilibrium").equilibrium()
    assert rest.stable
    assert abs(rest["crank.phi"] + 0.86917910629446) < 1e-8
    assert abs(rest["slider.x"] - slider_at(rest["crank.phi"])) < 1e-10
    assert abs(rest["rocker.phi"] - atan2(rest["block.y"], rest["block.x"])) < 1e-10


# -- kinematics ----------------------------------------------------------------------------------


def test_both_models_move_alike_and_as_trigonometry_says() -> None:
    instants = np.linspace(0.0, 1.0, 361)
    x = np.array([slider_at(0.44 + SPEED * time) for time in instants])
    runs = [scene(name).kinematics(instants) for name in ("kinematics", "kinematics_composite")]
    for run in runs:
        assert run.outcome is Outcome.OK
        assert np.abs(run.q("slider.x") - x).max() < 1e-11
        assert float(run.data["constraint_residual"].max()) < 1e-11
    first, second = runs
    for name in first.description.coordinates.names:
        if name in second.description.coordinates.names:
            for read in (Result.v, Result.a):
                scale = max(1.0, np.abs(read(first, name)).max())
                assert np.abs(read(first, name) - read(second, name)).max() < 1e-11 * scale


def test_model_2_has_the_joints_of_model_2() -> None:
    machine = scene("kinematics_composite")
    assert machine.description.bodies == ("rocker", "crank", "slider")
    assert (len(machine.coordinates), len(machine.constraints)) == (9, 9)
    assert {"P", "slot", "C", "D"} <= set(machine.description.left_out.names)


# -- inverse dynamics ----------------------------------------------------------------------------


@pytest.mark.parametrize("mass", [25.0, 50.0, 100.0])
def test_extremes_of_the_driving_torque(mass: float) -> None:
    torque = study().inertial[mass].reaction("crank_drive", "torque")
    for ours, exact in zip(extremes(torque), TORQUES[mass], strict=True):
        assert abs(ours - exact) < 1e-8 * abs(exact)


def test_the_driver_pays_for_energy_and_cut() -> None:
    run = study().driven[50.0]
    machine = scene("inverse_dynamics")
    masses = np.zeros(len(machine.coordinates))
    machine.kernels.mass(run.samples.q[0], machine.parameter_values(), masses)
    kinetic = (run.samples.v * masses * run.samples.a).sum(axis=1)
    lifted = 9.81 * (run.samples.v * masses)[:, 1::3].sum(axis=1)
    power = run.power("crank_drive") + run.power("cut")
    assert np.abs(power - kinetic - lifted).max() < 1e-10 * np.abs(power).max()
    inside = (run.v("slider.x") < 0) & (np.abs(run.q("slider.x") + 1.4) < 2.6)
    expected = np.where(inside, 200e3 * run.v("slider.x"), 0.0)
    assert np.abs(run.power("cut") - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.slow
def test_the_torque_of_the_inverse_run_drives_the_same_motion(tmp_path: Path) -> None:
    """Project 8.5, with the cut: the torque is fed as a function of time and jumps with it."""
    count, harmonics = 1024, 100
    begin = (CUT_BEGIN - CUT_END) / SPEED
    instants = np.arange(count) / count
    run, idle = (
        scene("inverse_dynamics").inverse_dynamics(
            instants, parameters={"drive_start": CUT_END, "cutting_force": force}
        )
        for force in (200e3, 0.0)
    )
    smooth = np.fft.rfft(idle.reaction("crank_drive", "torque")) / count
    jump = np.fft.rfft(-200e3 * run.v("slider.x") / SPEED) / count  # while the tool cuts
    cut = sympy.Piecewise((0, t < begin), (_series(jump, harmonics), True))
    fed = _series(smooth, harmonics) + cut
    torque = run.reaction("crank_drive", "torque")
    # At t = 0, on the edge of the cut, the inverse run may take either side.
    difference = sympy.lambdify(t, fed, "numpy")(instants)[1:] - torque[1:]
    assert np.abs(difference).max() < 1e-8 * torque.max()

    declared = runpy.run_path(str(MODEL))
    model, crank, slider = (declared[name] for name in ("model", "crank", "slider"))
    model.torque("fed", on=crank, value=fed)
    model.scene("turn", ["gravity", "cut", "fed"], outputs=[],
                start={slider.x: -4.0, crank.omega: SPEED}, guess=declared["running"])  # fmt: skip
    instants = np.linspace(0.0, 1.0, 201)
    free = load(model, "turn", folder=tmp_path).simulate(1.0, instants, rtol=1e-11)
    angle = CUT_END + SPEED * instants
    x = np.array([slider_at(phi) for phi in angle])
    assert np.abs(free.q("crank.phi") - angle).max() < 1e-7
    assert np.abs(free.q("slider.x") - x).max() < 1e-7


def _series(coefficients: np.ndarray, harmonics: int) -> sympy.Expr:
    terms = [coefficients[0].real]
    for k in range(1, harmonics + 1):
        angle = k * SPEED * t
        terms.append(2 * coefficients[k].real * sympy.cos(angle))
        terms.append(-2 * coefficients[k].imag * sympy.sin(angle))
    return sympy.Add(*terms)


# -- dynamics ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("method", "correction"), [
    ("dop853", "step"), ("dopri5", "step"), ("dop853", "stage"),
])  # fmt: skip
def test_the_shaper_follows_the_independent_solution(method: str, correction: str) -> None:
    reference = np.genfromtxt(DATA / "quick_return_J2000.csv", delimiter=",", names=True)
    run = scene("shaper").simulate(
        2.0, reference["t"], method=method, rtol=1e-10, correction=correction
    )
    assert run.outcome is Outcome.OK
    assert np.abs(run.q("crank.phi") - reference["phi3"]).max() < 1e-7
    assert np.abs(run.q("slider.x") - reference["x6"]).max() < 1e-7
    # At t = 0, on the edge of the cut, the reference reports the force of the side left behind.
    for component in ("x", "y"):
        force = reference[f"R3{component}_ground_on_crank"][1:]
        difference = np.abs(run.reaction("B", f"f{component}")[1:] - force)
        assert difference.max() < 1e-6 * np.abs(force).max()
    assert float(run.data["constraint_residual"].max()) < 1e-10
    assert float(run.data["velocity_residual"].max()) < 1e-10


@pytest.mark.parametrize(("inertia", "cycles", "exact"), [
    (1000.0, 2.217, 2.21656644), (2000.0, 1.837, 1.83657380), (4000.0, 1.518, 1.51804718),
])  # fmt: skip
def test_cycles_per_second(inertia: float, cycles: float, exact: float) -> None:
    ours = cycles_per_second(study().running[inertia])
    assert f"{ours:.3f}" == f"{cycles:.3f}"
    assert abs(ours - exact) < 1e-8


def test_every_switch_of_the_cut_is_located() -> None:
    """Eight a turn: the slider turns four times, and passes each edge of the cut twice."""
    swing = pi - asin(4 / 5.9)  # rocker and rod in line: the slider is farthest left
    middle, half = 2 * sin(swing), sqrt(1.5**2 - 4 * cos(swing) ** 2)
    pins = [(s * cos(swing), s * sin(swing) - 2) for s in (middle - half, middle + half)]
    turns = [atan2(y, x) for x, y in pins]
    turns += [pi + asin(0.75), -asin(0.75)]  # crank and rocker at right angles: the rocker turns
    edges = [(-4.0, 2.9955), (-4.0, 4.467), (1.2, 5.115), (1.2, 5.934)]
    turns += [crank_at(x, near) for x, near in edges]
    run = study().running[2000.0]
    last = float(run.q("crank.phi")[-1])
    expected = sorted(a + 2 * pi * k for a in turns for k in range(5))
    expected = [a for a in expected if CUT_END + 1e-6 < a < last]
    crank = run.description.coordinates.index("crank.phi")
    found = [float(event.q[crank]) for event in run.events]
    assert len(found) == len(expected) == 31
    assert np.abs(np.array(found) - expected).max() < 1e-7
    assert sum(e.name == CUT_ENDS and e.direction < 0 for e in run.events) == 3


# -- the study -----------------------------------------------------------------------------------


def test_ours_is_the_exact_value_to_its_printed_digits() -> None:
    for row in table():
        assert abs(row.ours - row.exact) < 1e-8 * max(1.0, abs(row.exact)), row


def test_a_row_that_differs_from_the_book_says_why() -> None:
    for row in table():
        if row.book is not None:
            last = len(f"{row.book:g}".partition(".")[2])
            if abs(row.exact - row.book) > 0.6 * 10.0**-last:
                assert row.reason, row


def test_every_figure_is_written(tmp_path: Path) -> None:
    names = [path.stem for path in draw(figures(), tmp_path) if path.suffix == ".png"]
    assert names == [f"figure_8_3_{k}" for k in (2, 3, 4, 5)]
    assert "J₃ = 4000 kg m²" in (tmp_path / "figure_8_3_4.svg").read_text()
