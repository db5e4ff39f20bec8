"""The machines of Haug's chapter 12 against closed forms, energy and virtual work."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from models.studies import chapter
from models.studies.drawing import draw
from runtime import Outcome, load
from tests.models.driven_in_space import four_bar, slider_crank, torque
from tests.space.closed_forms import FlyballGovernor, SpatialSliderCrank, SwashPlate

STUDIES = [study for study in chapter.STUDIES if study.machine.startswith("space/")]
TURN = 2 * np.pi
INSTANTS = (0.07, 0.31, 0.62, 0.88)  # shares of a turn at which energies are compared


@pytest.mark.parametrize("length", [0.3, 0.24])
@pytest.mark.parametrize("moments", [(4e-4, 4e-3), (4e-3, 4e-4)])
def test_the_slider_crank_moves_in_closed_form_and_needs_the_torque_of_its_energy(
    length: float, moments: tuple[float, float]
) -> None:
    values = {"length": length, "J_along": moments[0], "J_across": moments[1]}
    machine = load("space/spatial_slider_crank", "inverse_dynamics")
    run = machine.inverse_dynamics(INSTANTS, parameters=values, progress=False)
    assert run.outcome is Outcome.OK
    form = SpatialSliderCrank(length)
    exact = [form.motion(np.pi / 2 - TURN * t, -TURN) for t in run.t]
    found = [read("slider.x") for read in (run.q, run.v, run.a)]
    assert_allclose(np.transpose(found), exact, rtol=0.0, atol=1e-11)
    bodies = slider_crank(length, -TURN, (*moments, 4e-3))
    asked = [torque(bodies, -TURN, t) for t in run.t]
    assert_allclose(run.reaction("drive", "torque"), asked, rtol=0.0, atol=1e-11)


def test_a_lock_up_names_bodies_that_turn_and_no_euler_parameters() -> None:
    run = load("space/spatial_slider_crank", "kinematics").kinematics(
        1.0, parameters={"length": 0.23}, progress=False
    )
    assert run.outcome is Outcome.LOCKED
    (locked,) = run.singular
    (free,) = locked.null_directions
    turn = 2 * np.linalg.norm([free[f"rod.e{k}"] for k in range(4)])
    told = f"could move by slider.x +1, orientation of rod {turn:.3g}, rod.x +0.5. (Vel"
    assert told in run.message


def test_without_the_rod_the_slider_alone_loads_the_crank() -> None:
    machine = load("space/spatial_slider_crank", "inverse_dynamics_without_rod")
    run = machine.inverse_dynamics(INSTANTS, progress=False)
    assert "rod.x" not in run.description.coordinates.names
    bodies = slider_crank(0.3, -TURN, (1.0, 1.0, 1.0))
    asked = [torque([bodies[0], bodies[2]], -TURN, t) for t in run.t]
    assert_allclose(run.reaction("drive", "torque"), asked, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("scene", ["free", "free_without_rod"])
@pytest.mark.parametrize("speed", [6.0, 8.0])
def test_it_runs_freely_with_its_energy(scene: str, speed: float) -> None:
    machine = load("space/spatial_slider_crank", scene)
    run = machine.simulate(2.0, 41, start={"A.rate": -speed}, rtol=1e-11, progress=False)
    assert run.outcome is Outcome.OK
    assert -run.q("A.angle")[-1] > 1.2 * TURN
    assert np.ptp(run.energy()) < 1e-8
    form = SpatialSliderCrank(0.3)
    x = [float(form.slider(np.pi / 2 + angle)) for angle in run.q("A.angle")]
    assert_allclose(run.q("slider.x"), x, rtol=0.0, atol=1e-10)


def test_a_rod_that_is_too_short_locks_the_crank() -> None:
    """The pin is farthest from the origin where it lies on the line through A."""
    length = SpatialSliderCrank(0.3).lock_up - 1e-3
    machine = load("space/spatial_slider_crank", "kinematics")
    run = machine.kinematics(1.0, 101, parameters={"length": length}, progress=False)
    assert run.outcome is Outcome.LOCKED
    angle = np.pi / 2 - TURN * run.t[-1]
    pin = np.array([0.1 + 0.08 * np.cos(angle), 0.12 + 0.08 * np.sin(angle)])
    assert np.hypot(*pin) == pytest.approx(length, abs=1e-9)


@pytest.mark.parametrize("scene", ["inverse_dynamics", "inverse_dynamics_without_link"])
def test_the_wheel_of_the_four_bar_needs_the_torque_of_its_energy(scene: str) -> None:
    run = load("space/spatial_four_bar", scene).inverse_dynamics(
        2 * np.array(INSTANTS), progress=False
    )
    assert run.outcome is Outcome.OK
    bodies = four_bar(np.pi, with_link="without" not in scene)
    height = [float(bodies[1].pose(t)[0][2]) for t in run.t]
    assert_allclose(run.q("rocker.z"), height, rtol=0.0, atol=1e-12)
    asked = [torque(bodies, np.pi, t) for t in run.t]
    assert_allclose(run.reaction("drive", "torque"), asked, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("tilt", [20, 30, 40])
def test_the_six_pistons_follow_the_swash_plate(tilt: float) -> None:
    machine = load("space/swash_plate_compressor")
    form, instants = SwashPlate(np.radians(tilt)), np.linspace(0.0, 0.1, 13)
    values = {"tilt": form.tilt}
    run = machine.kinematics(instants, parameters=values, progress=False)
    assert run.outcome is Outcome.OK
    for k in range(6):
        place = np.pi / 2 + k * np.pi / 3
        exact = [float(form.piston(20 * np.pi * t, place)) for t in instants]
        assert_allclose(run.q(f"piston_{k + 1}.z"), exact, rtol=0.0, atol=1e-12)
    assert np.ptp(run.q("piston_1.z")) == pytest.approx(form.stroke, rel=1e-12)


FORM, GRAVITY = FlyballGovernor(), 9.81


def governor_rates(t: float, y: Any, gain: float, damping: float = 30.0) -> Any:
    """θ, θ̇ and ω of the governor → their derivatives, by Lagrange's equations."""
    a, rate, speed = y
    s, c, h = np.sin(a), np.cos(a), 1e-4
    slope = FORM.slope(a)
    curve = (8 * (FORM.slope(a + h) - FORM.slope(a - h))
             - FORM.slope(a + 2 * h) + FORM.slope(a - 2 * h)) / (12 * h)  # fmt: skip
    shorter = FORM.top - FORM.height(a) - FORM.free_length
    about = 50 + 0.125 + 2 * (0.1 + FORM.arm**2 * s**2)
    more = 4 * FORM.arm**2 * s * c  # of `about`, by the angle
    swung = 2 * (FORM.arm**2 + 0.1) + slope**2
    lifted = 2 * GRAVITY * FORM.arm * s + slope * (GRAVITY - FORM.stiffness * shorter)
    force = more * speed**2 / 2 - lifted - damping * slope**2 * rate - slope * curve * rate**2
    drive = gain * shorter - 25 * np.clip(t - 1, 0, 1)
    return np.array([rate, force / swung, (drive - more * rate * speed) / about])


def governed(gain: float, seconds: float, damping: float = 30.0) -> Any:
    """A run of the governor."""
    values = {"gain": gain, "damping": damping}
    machine = load("space/governor")
    return machine.simulate(seconds, 101, rtol=1e-10, parameters=values, progress=False)


@pytest.mark.parametrize("gain", [7500.0, 17500.0])
def test_the_governor_runs_as_lagrange_says(gain: float) -> None:
    run = governed(gain, 10.0)
    y = np.array([FORM.angle(0.05), 0.0, 11.0174])
    exact = [y]
    for k in range(10):  # the load bends at 1 s and at 2 s
        span = (float(k), k + 1.0)
        solved = solve_ivp(governor_rates, span, y, "DOP853", args=(gain,), rtol=1e-11, atol=1e-13)
        y = solved.y[:, -1]
        exact.append(y)
    angle, _, speed = np.transpose(exact)
    height = [FORM.height(a) for a in angle]
    assert_allclose(run.q("collar.y")[::10], height, rtol=0.0, atol=1e-8)
    assert_allclose(run.v("spindle.omega_y")[::10], speed, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("gain", [7500.0, 12500.0, 17500.0])
def test_the_governor_settles_where_virtual_work_says(gain: float) -> None:
    """With a damper of 300 N s/m, which changes nothing of where it settles."""
    run = governed(gain, 40.0, 300.0)
    height, speed = FORM.steady(gain)
    assert run.q("collar.y")[-1] == pytest.approx(height, abs=1e-6)
    assert run.v("spindle.omega_y")[-1] == pytest.approx(speed, abs=1e-4)


@pytest.mark.parametrize(("gain", "grows"), [(7500.0, False), (12500.0, True), (17500.0, True)])
def test_the_oscillation_of_the_governor_grows_where_its_eigenvalues_say(
    gain: float, grows: bool
) -> None:
    """With the second gain, too: so slowly that ten seconds do not show it."""
    height, speed = FORM.steady(gain)
    steady = np.array([FORM.angle(height), 0.0, speed])
    sides = [
        [governor_rates(9.0, steady + s * 1e-6 * one, gain) for s in (-1, 1)] for one in np.eye(3)
    ]
    matrix = np.transpose([(b - a) / 2e-6 for a, b in sides])
    assert bool(np.linalg.eigvals(matrix).real.max() > 0) is grows
    run = governed(gain, 30.0)
    early, late = (np.ptp(run.v("spindle.omega_y")[k : k + 14]) for k in (40, 85))
    assert bool(late > early) is grows


@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.name)
def test_ours_is_the_exact_value_and_what_differs_from_the_book_says_why(
    study: chapter.Study, tmp_path: Path
) -> None:
    for row in study.table():
        assert abs(row.ours - row.exact) < 1e-8 * max(1.0, abs(row.exact)), row
        if row.book is not None:
            last = len(f"{row.book:g}".partition(".")[2])
            if abs(row.exact - row.book) > 0.6 * 10.0**-last:
                assert row.reason, row
    drawn = [path.stem for path in draw(study.figures(), tmp_path) if path.suffix == ".png"]
    section = study.title.rpartition(" ")[2].replace(".", "_")
    assert len(drawn) > 1
    assert all(name.startswith(f"figure_{section}_") for name in drawn)
