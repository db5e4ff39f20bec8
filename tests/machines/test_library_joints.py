"""A small machine for each joint and driver of the library, against its closed form."""

from math import pi
from pathlib import Path

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from sympy import sin

from codegen import Model, alpha, t
from runtime import Outcome, Result, load

INSTANTS = np.linspace(0.0, 2.0, 81)


def sound(run: Result) -> Result:
    """A run that ended as it should, on its constraints."""
    assert run.outcome is Outcome.OK
    assert float(run.data["constraint_residual"].max()) < 1e-10
    assert float(run.data["velocity_residual"].max()) < 1e-9
    return run


@pytest.mark.parametrize("cranked", ["sun", "carrier"])
def test_planetary_gear_turns_by_willis(tmp_path: Path, cranked: str) -> None:
    """Sun 0.2 m, planet 0.1 m, fixed ring 0.4 m: the carrier makes a third of the sun's turns.

    It turns many times, and the line of centres with it.
    """
    model = Model("planetary")
    ground = model.ground
    sun = model.body("sun", mass=3.0, inertia=0.06)
    carrier = model.body("carrier", mass=1.0, inertia=0.05)
    planet = model.body("planet", mass=0.5, inertia=0.004)
    model.revolute("A", ground.at(0, 0), sun)
    model.revolute("B", ground.at(0, 0), carrier)
    model.revolute("C", carrier.at(0.3, 0), planet)
    model.gear("inner", sun, planet, 0.2, 0.1)
    model.gear("ring", planet, ground.at(0, 0), 0.1, -0.4)
    model.torque("motor", model.bodies[cranked], 6.0)
    model.scene("run", ["motor"], start={sun.phi: 0.0, sun.omega: 0.0}, guess={planet.x: 0.3})
    run = sound(load(model, folder=tmp_path).simulate(4.0, np.linspace(0, 4, 81), rtol=1e-10))
    inertia = 0.06 + (0.05 + 0.5 * 0.3**2) / 9 + 0.004
    angle = (6.0 if cranked == "sun" else 2.0) / inertia * run.t**2 / 2
    assert angle[-1] / 3 > 2 * pi * 4
    assert_allclose(run.q("sun.phi"), angle, rtol=1e-8, atol=1e-8)
    assert_allclose(run.q("carrier.phi"), angle / 3, rtol=1e-8, atol=1e-8)
    assert_allclose(run.q("planet.phi"), -angle, rtol=1e-8, atol=1e-8)
    energy = run.energy()
    work = 6.0 * run.q(f"{cranked}.phi")
    assert_allclose(energy - energy[0], work, rtol=1e-8, atol=1e-8)
    # What turns the sun is the motor less what its teeth pass on.
    alpha = run.a("sun.phi")
    motor = 6.0 if cranked == "sun" else 0.0
    assert_allclose(motor - 0.06 * alpha, 0.2 * run.reaction("inner", "fy"), rtol=1e-8)


@pytest.mark.parametrize("held", ["sun", "ring", "carrier"])
def test_a_welded_wheel_turns_like_one_on_a_locked_bearing(tmp_path: Path, held: str) -> None:
    """Welds of a planetary gear, declared last and away from its axis, over a housing."""
    turns, place = 0.2, 0.3 * np.array([np.cos(2.0), np.sin(2.0)])
    angles = []
    for welded in (False, True):
        model = Model(f"{held}_{welded}")
        ground, wheels = model.ground, ("sun", "ring", "carrier", "planet", "housing")
        sun, ring, carrier, planet, housing = (model.body(name) for name in wheels)
        model.gear("inner", sun, planet, 0.2, 0.1)
        model.gear("outer", planet, ring, 0.1, -0.4)
        model.revolute("pin", carrier.at(*place), planet)
        for body in (sun, ring, carrier):
            if not welded or body.name != held:
                model.revolute(f"{body.name}_pin", ground.at(0, 0), body)
        model.weld("foot", housing.at(0.2, 0.0), ground.at(0.2, 0.0))
        if welded:
            x, y = 0.5 * np.cos(turns), 0.5 * np.sin(turns)
            model.weld("seam", model.bodies[held].at(0.5, 0.0), housing.at(x, y), angle=-turns)
        else:
            model.relative("seam", model.bodies[held], housing, "phi", -turns)
        cranked = sun if held != "sun" else ring
        model.driver("crank", cranked.phi, 0.5 * t)
        c, s = np.cos(turns), np.sin(turns)
        x, y = np.array([[c, -s], [s, c]]) @ place if held == "carrier" else place
        guess = {model.bodies[held].phi: turns, planet.x: x, planet.y: y}
        model.scene("run", drivers=["crank"], analysis="kinematics", guess=guess)
        run = sound(load(model, folder=tmp_path).kinematics(1.0, 3))
        angles.append([run.q(f"{name}.phi") for name in wheels])
    assert_allclose(angles[1], angles[0], atol=1e-9)
    rates = [angle[2] - angle[0] for angle in angles[1][:3]]
    assert_allclose(0.2 * (rates[0] - rates[2]), -0.4 * (rates[1] - rates[2]), atol=1e-9)


@pytest.mark.parametrize("jerky", [False, True])
def test_a_cam_in_pieces_of_the_angle_keeps_its_energy(tmp_path: Path, jerky: bool) -> None:
    """ω follows from the energy; where pieces meet, the acceleration bends, or jumps, and no event.

    Profile R + h s(α), rise and return over 1.4 rad each, by a cycloid or by parabolas.
    """
    b, h, back = 1.4, 0.01, 2.5

    def rise(u: sympy.Expr) -> list[tuple[sympy.Expr, float]]:
        if jerky:
            return [(2 * u**2, 0.5), (1 - 2 * (1 - u) ** 2, 1.0)]
        return [(u - sin(2 * sympy.pi * u) / (2 * sympy.pi), 1.0)]

    up, down = rise(alpha / b), rise((alpha - back) / b)
    lifts = [*((s, alpha < part * b) for s, part in up), (1, alpha < back)]
    lifts += [(1 - s, alpha < back + part * b) for s, part in down]
    radius = sympy.Piecewise(*((0.04 + h * s, c) for s, c in lifts), (0.04, True))
    model = Model("pieces", gravity=(-9.81, 0.0))
    cam = model.body("cam", mass=1.0, inertia=0.01)
    pin = model.body("pin", mass=0.3, inertia=1e-4)
    model.revolute("O", model.ground.at(0, 0), cam)
    model.translational("guide", model.ground, pin)
    model.point_follower("touch", cam.polar(radius), pin.at(0, 0))
    start = {cam.phi: 0.0, cam.omega: -20.0}
    model.scene("run", ["gravity"], start=start, guess={pin.x: 0.04})
    run = sound(load(model, folder=tmp_path).simulate(1.0, 101, rtol=1e-9))
    at = np.mod(-run.q("cam.phi"), 2 * pi)
    assert run.q("cam.phi")[-1] < -6 * pi
    assert not run.events
    lift, slope = (sympy.lambdify(alpha, e)(at) for e in (radius, radius.diff(alpha)))
    assert_allclose(run.q("pin.x"), lift, atol=1e-12)
    energy = 0.005 * 400 + 0.3 * 9.81 * 0.04
    exact = np.sqrt(2 * (energy - 0.3 * 9.81 * lift) / (0.01 + 0.3 * slope**2))
    assert_allclose(-run.v("cam.omega"), exact, rtol=1e-8)


def test_rack_swings_on_a_spring_with_its_pinion(tmp_path: Path) -> None:
    model = Model("rack")
    pinion = model.body("pinion", mass=0.05, inertia=2e-5)
    rack = model.body("rack", mass=0.1, inertia=1e-4)
    model.revolute("axle", model.ground.at(0, 0.02), pinion)
    model.rack_and_pinion("mesh", pinion, rack.at(-0.1, 0), 0.02, offset=0.1)
    model.relative("level", model.ground, rack, "phi", 0)
    model.potential("spring", 40 * rack.x**2 / 2)
    model.scene("swing", ["spring"], start={rack.x: 0.03, rack.vx: 0.0}, guess={pinion.y: 0.02})
    run = sound(load(model, folder=tmp_path).simulate(2.0, INSTANTS, rtol=1e-11))
    frequency = np.sqrt(40 / (0.1 + 2e-5 / 0.02**2))
    x = 0.03 * np.cos(frequency * run.t)
    assert_allclose(run.q("rack.x"), x, atol=1e-9)
    assert_allclose(run.q("pinion.phi"), x / 0.02, atol=5e-8)
    assert_allclose(run.reaction("mesh", "fx"), (40 - 0.1 * frequency**2) * x, atol=1e-7)
    assert_allclose(run.reaction("mesh", "torque"), 0.02 * run.reaction("mesh", "fx"), atol=1e-12)


def test_scotch_yoke_with_and_without_its_block(tmp_path: Path) -> None:
    """The block moves on a circle at a steady speed, which takes no torque: it is not missed."""
    model = Model("yoke")
    crank = model.body("crank", mass=2.0, inertia=0.3)
    block = model.body("block", mass=0.5, inertia=0.01)
    yoke = model.body("yoke", mass=4.0, inertia=1.0)
    model.revolute("A", model.ground.at(0, 0), crank)
    model.translational("guide", model.ground, yoke)
    model.revolute("B", crank.at(0.2, 0), block)
    model.translational("slide", yoke, block, axis=(0, 1))
    model.revolute_translational("slot", yoke, crank.at(0.2, 0), axis=(0, 1), instead_of=block)
    model.rotation_driver("motor", model.ground, crank, 0.3 + 5 * t)
    guess = {crank.phi: 0.3, yoke.x: 0.19}
    model.scene("full", drivers=["motor"], guess=guess | {block.x: 0.19, block.y: 0.06})
    model.scene("short", drivers=["motor"], without=[block], guess=guess)
    runs = [
        sound(load(model, name, folder=tmp_path).inverse_dynamics(INSTANTS))
        for name in model.scenes
    ]
    angle = 0.3 + 5 * INSTANTS
    x, a = 0.2 * np.cos(angle), -5.0 * np.cos(angle)
    for run in runs:
        assert_allclose(run.q("yoke.x"), x, atol=1e-11)
        assert_allclose(run.a("yoke.x"), a, atol=1e-9)
        assert_allclose(run.reaction("motor", "torque"), 4 * a * -0.2 * np.sin(angle), atol=1e-7)
    # The slot pushes the crank against the yoke's acceleration: +y of its axes is global -x.
    assert_allclose(runs[1].reaction("slot", "fy"), 4 * a, atol=1e-8)
    assert_allclose(runs[0].reaction("slide", "fy"), 4 * a, atol=1e-7)


def test_welded_bars_swing_as_one(tmp_path: Path) -> None:
    """Two bars of 1 m at a right angle, against one body with the inertia of both."""
    model = Model("bent", gravity=(0, -9.81))
    first, second = (model.body(n, mass=1.0, inertia=1 / 12) for n in ("first", "second"))
    both = model.body("both", mass=2.0, inertia=2 / 12 + 2 * 1.0 * (0.25**2 + 0.25**2))
    model.revolute("A", model.ground.at(0, 0), first.at(-0.5, 0))
    model.weld("seam", first.at(0.5, 0), second.at(-0.5, 0), angle=pi / 2)
    model.revolute("B", model.ground.at(0, 0), both.at(-0.75, -0.25))
    guess = {first.x: 0.5, second.x: 1.0, second.y: 0.5, second.phi: pi / 2}
    guess |= {both.x: 0.75, both.y: 0.25}
    model.scene("swing", ["gravity"], start={first.phi: 0.0, both.phi: 0.0}, guess=guess)
    run = sound(load(model, folder=tmp_path).simulate(2.0, INSTANTS, rtol=1e-11))
    assert_allclose(run.q("first.phi"), run.q("both.phi"), atol=1e-8)
    assert_allclose(run.q("second.phi"), run.q("both.phi") + pi / 2, atol=1e-8)
    # Torque about the second bar's centre turns it; the seam's force has an arm of half a bar.
    c, z = np.cos(run.q("first.phi")), np.sin(run.q("first.phi"))
    ax, ay = run.a("second.x"), run.a("second.y") + 9.81
    fx, fy = c * ax + z * ay, c * ay - z * ax
    assert_allclose(run.reaction("seam", "fx"), fx, atol=1e-8)
    assert_allclose(run.reaction("seam", "fy"), fy, atol=1e-8)
    torque = run.a("second.phi") / 12 - 0.5 * fx
    assert_allclose(run.reaction("seam", "torque"), torque, atol=1e-8)


def test_gondola_stays_upright(tmp_path: Path) -> None:
    model = Model("wheel", gravity=(0, -10))
    wheel = model.body("wheel", mass=5.0, inertia=4.0)
    gondola = model.body("gondola", mass=2.0, inertia=0.2)
    model.revolute("axle", model.ground.at(0, 3), wheel)
    model.relative("reach", wheel.at(2, 0), gondola.at(0, 0.3), "x", 0)
    model.relative("lift", wheel.at(2, 0), gondola.at(0, 0.3), "y", 0)
    model.relative("upright", model.ground, gondola, "phi", 0)
    model.rotation_driver("motor", model.ground, wheel, t)
    guess = {wheel.y: 3.0, gondola.x: 2.0, gondola.y: 2.7}
    model.scene("turn", ["gravity"], ["motor"], guess=guess)
    run = sound(load(model, folder=tmp_path).inverse_dynamics(INSTANTS))
    c, z = np.cos(run.t), np.sin(run.t)
    assert_allclose(run.q("gondola.x"), 2 * c, atol=1e-11)
    assert_allclose(run.q("gondola.y"), 2.7 + 2 * z, atol=1e-11)
    assert_allclose(run.reaction("reach", "fx"), -4 * c, atol=1e-9)
    assert_allclose(run.reaction("lift", "fy"), 20 - 4 * z, atol=1e-9)
    assert_allclose(run.reaction("motor", "torque"), 2 * 2 * 10 * c, atol=1e-9)


def test_ball_on_a_rope_is_a_pendulum(tmp_path: Path) -> None:
    """Held at its centre by a distance it turns at its own rate, unlike a bob that is pinned."""
    model = Model("rope", gravity=(0, -10))
    ball = model.body("ball", mass=2.0, inertia=0.1)
    model.distance("rope", model.ground.at(0, 0), ball, 1.5)
    start = {ball.x: 1.5, ball.y: 0.0, ball.vx: 0.0, ball.omega: 3.0}
    model.scene("swing", ["gravity"], start=start)
    run = sound(load(model, folder=tmp_path).simulate(2.0, INSTANTS, rtol=1e-11))
    assert_allclose(run.q("ball.phi"), 3 * run.t, atol=1e-9)
    speed = run.v("ball.x") ** 2 + run.v("ball.y") ** 2
    assert_allclose(speed, -20 * run.q("ball.y"), atol=1e-7)
    pull = 2 * speed / 1.5 - 20 * run.q("ball.y") / 1.5
    assert_allclose(run.reaction("rope", "fx"), -pull, atol=1e-7)


def test_cylinder_lifts_a_boom(tmp_path: Path) -> None:
    """An isosceles triangle: the cylinder's length is 2 sin(φ/2) m."""
    model = Model("boom", gravity=(0, -10))
    boom = model.body("boom", mass=6.0, inertia=2.0)
    model.revolute("A", model.ground.at(0, 0), boom.at(-2, 0))
    model.distance_driver("cylinder", model.ground.at(0, -1), boom.at(-1, 0), 1.2 + sin(t) / 4)
    model.scene("lift", ["gravity"], ["cylinder"], guess={boom.x: 1.9, boom.phi: -0.4})
    run = sound(load(model, folder=tmp_path).inverse_dynamics(INSTANTS))
    length, rate = 1.2 + np.sin(run.t) / 4, np.cos(run.t) / 4
    angle = 2 * np.arcsin(length / 2) - pi / 2
    assert_allclose(run.q("boom.phi"), angle, atol=1e-11)
    slope = 1 / np.sqrt(1 - length**2 / 4)
    alpha = slope * -np.sin(run.t) / 4 + slope**3 * length / 4 * rate**2
    torque = (2.0 + 6.0 * 2**2) * alpha + 6.0 * 10 * 2 * np.cos(angle)
    assert_allclose(run.reaction("cylinder", "force"), torque * slope, rtol=1e-9)


@pytest.mark.parametrize("guess", [{}, {"rod.x": 0.8}])
def test_cylinder_cannot_shrink_to_nothing(tmp_path: Path, guess: dict[str, float]) -> None:
    """Without a guess both ends are in one place; there a motion ends."""
    model = Model("cylinder")
    rod = model.body("rod", mass=2.0, inertia=1.0)
    model.translational("guide", model.ground, rod)
    model.distance_driver("cylinder", model.ground.at(0, 0), rod, 1 - t**2)
    model.scene("pull", drivers=["cylinder"], guess=guess)
    machine = load(model, folder=tmp_path)
    run = machine.inverse_dynamics([0.0, 0.5, 0.9])
    side = np.sign(run.q("rod.x"))
    assert_allclose(side * run.q("rod.x"), 1 - run.t**2, atol=1e-12)
    assert_allclose(run.reaction("cylinder", "force"), -4.0, atol=1e-10)
    run = machine.kinematics([0.0, 0.5, 1.5])
    assert run.outcome is Outcome.DISCONTINUOUS
    assert "Stopped before t = 1 s. In driver 'cylinder'" in run.message


def test_arm_carries_its_tip_where_it_is_told(tmp_path: Path) -> None:
    """Two links of 1 m; point drivers hold the tip on a circle, which the closed form inverts."""
    model = Model("arm")
    upper, fore = (model.body(n, mass=1.0, inertia=0.1) for n in ("upper", "fore"))
    model.revolute("shoulder", model.ground.at(0, 0), upper.at(-0.5, 0))
    model.revolute("elbow", upper.at(0.5, 0), fore.at(-0.5, 0))
    model.point_driver("ahead", fore.at(0.5, 0), "x", 1.2 + 0.3 * sin(t + pi / 2))
    model.point_driver("up", fore.at(0.5, 0), "y", 0.3 * sin(t))
    guess = {upper.x: 0.4, upper.y: -0.3, upper.phi: -0.7, fore.x: 1.1, fore.phi: 0.7}
    model.scene("reach", drivers=["ahead", "up"], guess=guess)
    run = sound(load(model, folder=tmp_path).inverse_dynamics(INSTANTS))
    x, y = 1.2 + 0.3 * np.cos(run.t), 0.3 * np.sin(run.t)
    opening = np.arccos(np.hypot(x, y) / 2)
    assert_allclose(run.q("upper.phi"), np.arctan2(y, x) - opening, atol=1e-11)
    assert_allclose(run.q("fore.phi"), np.arctan2(y, x) + opening, atol=1e-11)
    for name, row, speed in (("ahead", "fx", -y), ("up", "fy", 0.3 * np.cos(run.t))):
        assert_allclose(run.power(name), run.reaction(name, row) * speed, atol=1e-12)


def test_slider_is_driven_along_a_guide_that_turns(tmp_path: Path) -> None:
    """Centrifugal force on a bead that passes the axle: m (s̈ - s ω²) along, 2 m ṡ ω across."""
    model = Model("bead")
    arm = model.body("arm", mass=1.0, inertia=0.5)
    bead = model.body("bead", mass=2.0, inertia=0.01)
    model.revolute("axle", model.ground.at(0, 0), arm)
    model.translational("guide", arm, bead)
    model.rotation_driver("motor", model.ground, arm, 3 * t)
    model.translation_driver("stroke", arm, bead, 0.4 * sin(2 * t))
    model.scene("turn", drivers=["motor", "stroke"])
    run = sound(load(model, folder=tmp_path).inverse_dynamics(INSTANTS))
    s, rate = 0.4 * np.sin(2 * run.t), 0.8 * np.cos(2 * run.t)
    assert_allclose(run.reaction("stroke", "force"), 2 * (-4 * s - 9 * s), atol=1e-10)
    assert_allclose(run.reaction("guide", "fy"), 2 * 2 * rate * 3, atol=1e-10)
    assert_allclose(run.reaction("motor", "torque"), 2 * 2 * rate * 3 * s, atol=1e-10)


@pytest.mark.parametrize("mean", [0.0, 2.9])
def test_a_roller_may_swing_beside_a_notch_that_it_does_not_fit(
    tmp_path: Path, mean: float
) -> None:
    model = Model("swung")
    cam, rod = (model.body(name, mass=1.0, inertia=1.0) for name in ("cam", "rod"))
    model.revolute("shaft", model.ground.at(0, 0), cam.at(0, 0))
    model.translational("guide", model.ground.at(0, 0), rod.at(0, 0), axis=(0, 1))
    notched = 0.05 - 0.02 * sympy.exp(60 * (sympy.cos(alpha - 1.5 * sympy.pi) - 1))
    model.cam_follower("lift", cam.polar(notched), rod.circle(0.015))
    model.driver("drive", cam.phi, mean + 0.5 * sin(6 * t))
    model.scene("turn", drivers=["drive"], guess={rod.y: 0.065})
    run = load(model, folder=tmp_path).kinematics(1.0, 31)
    if mean == 0.0:
        assert_allclose(sound(run).q("rod.y"), 0.065, atol=1e-9)
    else:
        assert run.outcome is Outcome.CONTRADICTED
        assert "'lift' on body 'cam': the roller of the radius 0.015 m, where" in run.message
