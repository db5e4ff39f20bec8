"""Motion programs in machines: drivers, cams and forces against closed forms."""

from math import pi
from pathlib import Path

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from codegen import Model, flat_faced_cam, motion_program, roller_cam, t
from runtime import load

G, SPEED = 9.81, 20.0
MASS, BASE, ROLLER, OFFSET, LIFT = 0.7, 0.03, 0.01, 0.004, 0.012
LAW = "modified sine"
MOVES = [(100, 12, LAW), (40, 12), (120, 0, LAW), (100, 0)]


def ram(name: str, gravity: float = G) -> tuple[Model, object]:
    model = Model(name, gravity=(0, -gravity))
    body = model.body("ram", mass=2.0, inertia=0.1)
    model.translational("guide", model.ground.at(0, 0), body.at(0, 0), axis=(0, 1))
    return model, body


def cycloid(x: np.ndarray) -> list[np.ndarray]:
    """s, s' and s''."""
    turn = 2 * pi * x
    return [x - np.sin(turn) / (2 * pi), 1 - np.cos(turn), 2 * pi * np.sin(turn)]


def test_driver_to_and_fro(workshop: Path) -> None:
    """Between 0.1 and 0.4 m in 0.4 s, a dwell of 0.1 s, and back in 0.5 s."""
    model, body = ram("to_and_fro")
    stroke = motion_program(
        [(0.4, 0.4, "cycloid"), (0.1, 0.4), (0.5, 0.1, "cycloid")], start=0.1, units=("s", "m")
    )
    model.driver("drive", body.y, stroke(t))
    model.scene("run", ["gravity"], drivers=["drive"])
    machine = load(model, folder=workshop)
    at = np.linspace(0.003, 3.997, 101)
    x = at % 1.0
    up, down = cycloid(np.clip(x / 0.4, 0, 1)), cycloid(np.clip((x - 0.5) / 0.5, 0, 1))
    due = [0.3 * (a / 0.4**k - b / 0.5**k) for k, (a, b) in enumerate(zip(up, down, strict=True))]
    motion = machine.kinematics(at)
    assert_allclose(motion.q("ram.y"), 0.1 + due[0], rtol=0, atol=1e-14)
    assert_allclose(motion.v("ram.y"), due[1], rtol=0, atol=1e-12)
    assert_allclose(motion.a("ram.y"), due[2], rtol=0, atol=1e-11)
    forces = machine.inverse_dynamics(at)
    assert_allclose(forces.reaction("drive", "fy"), 2.0 * (G + due[2]), rtol=1e-12)
    run = machine.simulate(4.0)
    assert run.outcome.name == "OK"
    assert not run.events  # accelerations are continuous
    steps = machine.simulate(4.0, "steps").t
    assert max(np.abs(steps - meeting).min() for meeting in (0.4, 0.5, 1.0, 1.4, 3.5)) < 1e-11


@pytest.mark.parametrize(
    ("law", "jumps"), [("harmonic", 6), ("3-4-5", 0), ("modified trapezoid", 0)]
)
def test_events_are_where_accelerations_jump(workshop: Path, law: str, jumps: int) -> None:
    model, body = ram(f"jumps_{law.replace('-', '').replace(' ', '_')}")
    stroke = motion_program([(0.4, 0.1, law), (0.1, 0.1), (0.5, 0, law)], units=("s", "m"))
    model.driver("drive", body.y, stroke(t))
    model.scene("run", ["gravity"], drivers=["drive"])
    run = load(model, folder=workshop).simulate(2.0)
    due = [0.4, 0.5, 1.0, 1.4, 1.5, 2.0][:jumps]
    assert_allclose([event.time for event in run.events], due, rtol=0, atol=1e-13)


def test_steep_accelerations_are_no_jumps(workshop: Path) -> None:
    """In a long run instants are told apart within 1e-13 s, in which a fast one changes by 1e-8."""
    model, body = ram("fast_ram")
    stroke = motion_program(
        [(0.04, 0.1, LAW), (0.01, 0.1), (0.05, 0, "harmonic")], units=("s", "m")
    )
    model.driver("drive", body.y, stroke(t))
    model.scene("run", ["gravity"], drivers=["drive"])
    run = load(model, folder=workshop).simulate(20.0, 3)
    due = np.arange(1, 201) * 0.1
    assert_allclose([event.time for event in run.events], np.sort([*due - 0.05, *due]), atol=1e-9)


def cam_machine(kind: str, way: int) -> tuple[Model, object]:
    model = Model(f"{kind}_cam_{'right' if way < 0 else 'left'}", gravity=(0, -G))
    cam = model.body("cam", mass=2.0, inertia=0.001)
    follower = model.body("follower", mass=MASS, inertia=0.01)
    model.revolute("shaft", model.ground.at(0, 0), cam.at(0, 0))
    model.translational("guide", model.ground.at(0, 0), follower.at(0, 0), axis=(0, 1))
    lift, right = motion_program(MOVES, units=("deg", "mm")), way < 0
    if kind == "flat":
        profile = flat_faced_cam(cam, lift, BASE, clockwise=right)
        model.cam_flat_follower("touch", profile, follower.at(0, 0))
    else:
        profile = roller_cam(cam, lift, BASE, ROLLER, offset=OFFSET, clockwise=right)
        if kind == "pitch":
            model.point_follower("touch", profile.pitch, follower.at(OFFSET, 0))
        else:
            roller = follower.circle(ROLLER, center=(OFFSET, 0))
            model.cam_follower("touch", profile, roller)
    model.driver("drive", cam.phi, way * SPEED * t)
    model.scene("run", ["gravity"], drivers=["drive"], guess={follower.y: 0.04})
    return model, profile


def modified_sine(x: np.ndarray) -> list[np.ndarray]:
    """s, s' and s'' from rest to rest, by hand."""
    inner = (x >= 1 / 8) & (x < 7 / 8)
    size, w = np.where(inner, 9 / 4, 1 / 4), np.where(inner, 4 * pi / 3, 4 * pi)
    turn = w * x + np.where(inner, pi / 3, 0)
    begin = np.select([x < 1 / 8, inner], [0.0, 2.0], 4.0)
    parts = [begin + pi * x - size * np.sin(turn), pi - size * w * np.cos(turn)]
    parts.append(size * w**2 * np.sin(turn))
    return [part / (4 + pi) for part in parts]


def lift_by_hand(angle: np.ndarray) -> list[np.ndarray]:
    rise, high, fall = np.radians([100.0, 40.0, 120.0])
    x = angle % (2 * pi)
    up = modified_sine(np.clip(x / rise, 0, 1))
    down = modified_sine(np.clip((x - rise - high) / fall, 0, 1))
    parts = zip(up, down, strict=True)
    return [LIFT * (a / rise**k - b / fall**k) for k, (a, b) in enumerate(parts)]


@pytest.mark.parametrize(
    ("kind", "way"), [("roller", 1), ("roller", -1), ("pitch", 1), ("flat", 1)]
)
def test_cam_pushes_as_its_program_says(workshop: Path, kind: str, way: int) -> None:
    """Motion, contact, pressure angle and force of cams with a modified sine."""
    model, profile = cam_machine(kind, way)
    machine = load(model, folder=workshop)
    at = np.linspace(0.001, 0.62, 63)
    angle = SPEED * at
    s, v, a = lift_by_hand(angle)
    run = machine.inverse_dynamics(at)
    low = BASE if kind == "flat" else np.sqrt((BASE + ROLLER) ** 2 - OFFSET**2)
    assert_allclose(run.q("follower.y"), low + s, rtol=1e-10)
    assert_allclose(run.v("follower.y"), SPEED * v, rtol=1e-10, atol=1e-12)
    assert_allclose(run.a("follower.y"), SPEED**2 * a, rtol=1e-10, atol=1e-10)
    assert_allclose(run.q("touch.alpha"), angle, rtol=1e-10)
    pressure = np.zeros_like(at)
    if kind != "flat":
        height, slope = low + s, v - way * OFFSET
        pressure = np.arctan(way * slope / height)
        bend = height**2 + 2 * slope**2 + way * OFFSET * slope - height * a
        radius = (height**2 + slope**2) ** 1.5 / bend - ROLLER
        assert_allclose(profile.radius_of_curvature(angle), radius, rtol=1e-10)
    assert_allclose(profile.pressure_angle(angle), pressure, rtol=1e-10, atol=1e-15)
    force = MASS * (G + SPEED**2 * a) / np.cos(pressure)
    assert_allclose(way * run.reaction("touch", "fy"), force, rtol=1e-10, atol=1e-10)
    simulated = machine.simulate(0.62)
    assert not simulated.events
    s, _, a = lift_by_hand(SPEED * simulated.t)
    assert_allclose(simulated.q("follower.y"), low + s, rtol=1e-10)
    assert_allclose(simulated.a("follower.y"), SPEED**2 * a, rtol=1e-10, atol=1e-9)


def test_program_of_an_angle_in_a_constraint_and_a_torque(workshop: Path) -> None:
    """A flywheel whose cam lifts a mass against its load, for over a turn; pieces by themselves."""
    model = Model("flywheel_cam", gravity=(0, -G))
    wheel = model.body("wheel", mass=2.0, inertia=0.01)
    mass = model.body("load", mass=0.5, inertia=0.01)
    model.revolute("shaft", model.ground.at(0, 0), wheel.at(0, 0))
    model.translational("guide", model.ground.at(0, 0), mass.at(0, 0), axis=(0, 1))
    h = model.parameter("h", 0.02, unit="m")
    lift = motion_program([(100, h, LAW), (40, h), (120, 0, LAW), (100, 0)], units=("deg", "m"))
    brake = motion_program([(180, 0.2, "cycloid"), (180, 0, "cycloid")], units=("deg", "N m"))
    model.constraint("cam", mass.y - lift(wheel.phi))
    model.torque("brake", on=wheel, value=-brake(3 * wheel.phi))
    model.scene("run", ["gravity", "brake"], start={wheel.phi: 0.1, wheel.omega: 30.0})

    def motion(_: float, y: np.ndarray) -> list[float]:
        _, v, a = (0.02 / LIFT * part for part in lift_by_hand(y[:1]))
        x = (y[:1] % (2 * pi / 3)) / (pi / 3)
        torque = 0.2 * (cycloid(x)[0] if x < 1 else 1 - cycloid(x - 1)[0])
        moment = -torque - 0.5 * v * (a * y[1] ** 2 + G)
        return [y[1], (moment / (0.01 + 0.5 * v**2))[0]]

    due = solve_ivp(motion, (0, 0.4), [0.1, 30.0], rtol=1e-12, atol=1e-12, max_step=2e-4).y[:, -1]
    machine = load(model, folder=workshop)
    for formulation in ("cartesian", "reduced"):
        run = machine.simulate(0.4, formulation=formulation, rtol=1e-11)
        assert run.outcome.name == "OK"
        assert not run.events
        assert run.q("wheel.phi")[-1] == pytest.approx(due[0], rel=2e-9)
        assert run.v("wheel.omega")[-1] == pytest.approx(due[1], rel=2e-9)
    assert due[0] > 2 * pi
    steps = np.degrees(machine.simulate(0.4, "steps").q("wheel.phi"))
    for meeting in (12.5, 60, 87.5, 100, 120, 155, 245, 372.5):
        assert np.abs(steps - meeting).min() < 1e-9


def test_s_curve_and_trapezoid_in_one_drive(workshop: Path) -> None:
    """Jerk at its limit, and events where the acceleration of the trapezoid jumps."""
    model, body = ram("limited", gravity=0.0)
    limits = (0.5, 2.0, 40.0)
    law = motion_program(
        [(0.2, 0), (None, 0.3, "S-curve"), (0.1, 0.3), (None, 0.1, "trapezoidal")],
        units=("s", "m"), limits=limits, periodic=False,
    )  # fmt: skip
    model.driver("drive", body.y, law(t))
    model.scene("run", drivers=["drive"])
    machine = load(model, folder=workshop)
    end = 0.2 + (0.3 / 0.5 + 0.25 + 0.05) + 0.1 + (0.2 / 0.5 + 0.25)
    assert law.length == pytest.approx(end, rel=1e-13)
    for begin in (0.2, 0.45, 0.8, 1.05):  # ramps of the acceleration, 2 / 40 s each
        ramp = machine.kinematics(begin + np.array([0.001, 0.049])).a("ram.y")
        assert abs(np.diff(ramp)[0] / 0.048) == pytest.approx(40.0, rel=1e-9)
    middle = machine.kinematics([0.35, 0.65, 2.5])
    assert_allclose(middle.v("ram.y"), [0.2 + 0.05, 0.5, 0.0], atol=1e-12)
    assert middle.q("ram.y")[-1] == pytest.approx(0.1, rel=1e-13)
    run = machine.simulate(2.5)
    assert_allclose([e.time for e in run.events], [1.2, 1.45, 1.6, 1.85], rtol=0, atol=1e-12)


def test_force_over_a_time_that_a_parameter_scales(workshop: Path) -> None:
    """Momentum and way of a mass under a force of one cycle."""
    model = Model("pulse")
    mass = model.particle("mass", mass=2.0)
    model.constraint("level", mass.y)
    T = model.parameter("T", 0.5, unit="s", sign="positive")
    pulse = motion_program([(0.5, 10, "4-5-6-7"), (0.5, 0, "4-5-6-7")], units=("s", "N"))
    model.force("push", on=mass, fx=pulse(t / T))
    model.scene("run", ["push"])
    machine = load(model, folder=workshop)
    for period in (0.5, 0.8):
        run = machine.simulate(4 * period, parameters={"T": period}, rtol=1e-10)
        assert not run.events
        assert run.v("mass.vx")[-1] == pytest.approx(4 * 10 * 0.5 * period / 2.0, rel=1e-10)


def test_law_of_a_distance_and_texts(workshop: Path) -> None:
    """A law is looked at for t = 0, and stands in texts and formulas by a short name."""
    model = Model("cylinder", gravity=(0, -G))
    boom = model.body("boom", mass=2.0, inertia=0.01)
    model.revolute("foot", model.ground.at(0, 0), boom.at(-0.5, 0))
    law = motion_program([(1.0, 0.2, LAW), (0.5, 0.2), (1.0, 0, "cycloid")], units=("s", "m"))
    model.distance_driver("cylinder", model.ground.at(0, 0.6), boom.at(0.2, 0), 0.6 + law(t))
    model.scene("run", ["gravity"], drivers=["cylinder"])
    run = load(model, folder=workshop).kinematics([0.0, 1.2, 2.6])
    x, y, phi = (run.q(f"boom.{letter}") for letter in ("x", "y", "phi"))
    length = np.hypot(x + 0.2 * np.cos(phi), y + 0.2 * np.sin(phi) - 0.6)
    assert_allclose(length, 0.6 + law.values([0.0, 1.2, 0.1]), rtol=1e-12)
    assert len(str(model.equations("run").Phi)) < 1000
    assert sympy.latex(law(t))
