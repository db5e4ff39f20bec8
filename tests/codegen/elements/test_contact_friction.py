"""Friction of cams, followers and rolling discs: closed forms, equations by hand, and balances."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from runtime import load
from tests.codegen.elements import test_cams as cams
from tests.codegen.elements.test_cams import AXIS, FACE, on_the_constraints, profile
from tests.codegen.elements.turned_body import turned_body
from tests.codegen.workbench import A, Interpreted, State

MU = 0.3
LEFT = np.array([[0.0, -1.0], [1.0, 0.0]])


def reported(machine: Interpreted, s: State, lam: np.ndarray) -> dict[tuple[str, str], float]:
    """The reactions by element and component, without those that are always 0."""
    values = machine.slots("reactions", s, lam=lam)
    told = machine.lowered.description.reactions
    return {told[k][:2]: x for k, x in values.items()}


def power_of_friction(machine: Interpreted, s: State, lam: np.ndarray) -> float:
    names = [name for name, _ in machine.lowered.description.powers]
    return machine.vector("powers", s, lam=lam)[names.index("rub")]


@pytest.mark.parametrize("creep", [1e-4, None])
@pytest.mark.parametrize("speed", [-4.0, 3.0])
@pytest.mark.parametrize("phi", [0.3, 1.2, 2.5, 4.0])
def test_torque_of_an_eccentric_cam(phi: float, speed: float, creep: float | None) -> None:
    """A disc turns off its centre under a flat face, which rubs, as the follower's guide does."""
    radius, off, mass, guided, gravity, gain = 0.05, 0.02, 2.0, 0.1, 9.81, 5.0
    model = Model("eccentric", gravity=(0, -gravity))
    cam = model.body("cam", mass=1.0, inertia=0.01)
    follower = model.body("follower", mass=mass, inertia=0.02)
    model.revolute("axle", model.ground.at(0, 0), cam)
    guide = model.translational("guide", model.ground.at(0, 0), follower, axis=(0, 1))
    touch = model.cam_flat_follower("touch", cam.circle(radius, center=(off, 0)), follower)
    model.driver("turn", cam.phi, phi + speed * t + gain * t**2)
    model.friction("rub", touch, MU, creep)
    model.friction("slide", guide, guided, creep)
    machine = Interpreted(model)
    c, s = np.cos(phi), np.sin(phi)
    lift, rise = radius + off * s, off * c * speed
    q = np.array([0, 0, phi, 0, lift, 0, np.pi / 2 - phi])
    state = State(t=0.0, q=q, v=np.array([0, 0, speed, 0, rise, 0, -speed]))
    if creep is None:
        machine.on_its_sides(state)
    assert_allclose(machine.vector("constraints", state), 0, atol=1e-15)
    a, lam = machine.solution(state)
    bend = off * (2 * gain * c - speed**2 * s)
    assert_allclose(a[4], bend, rtol=1e-10)
    pressed = mass * (gravity + bend) / (1 - guided * MU * np.sign(rise))
    torque = 0.01 * 2 * gain + pressed * off * c + MU * pressed * lift * np.sign(speed)
    found = reported(machine, state, lam)
    assert_allclose(found["turn", "torque"], torque, rtol=1e-10)
    assert_allclose(found["touch", "fy"], pressed, rtol=1e-10)
    if creep is None:
        assert_allclose(found["rub", "limit"], MU * pressed, rtol=1e-10)
    else:
        assert_allclose(found["rub", "force"], -MU * pressed * np.sign(speed), rtol=1e-10)


def contact(kind: str, s: State) -> tuple[np.ndarray, np.ndarray]:
    """The place of the contact and the unit tangent, from the definitions of `test_cams`."""
    (ri, pi, _, _), (rj, pj, _, _) = s.body(0), s.body(1)
    on_cam, tangent, *_ = profile(s.q[6])
    if kind == "point_follower":
        place = rj + A(pj) @ FACE
    elif kind == "cam_follower":
        place = rj + A(pj) @ (FACE + 0.4 * np.array([np.cos(s.q[7]), np.sin(s.q[7])]))
    else:
        return ri + A(pi) @ on_cam, A(pj) @ AXIS / np.linalg.norm(AXIS)
    return place, A(pi) @ tangent / np.linalg.norm(tangent)


@pytest.mark.parametrize("kind", cams.JOINTS)
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_follower_rubs_at_the_contact(kind: str, seed: int, way: float) -> None:
    model = cams.JOINTS[kind]()
    bodies: list[Any] = [*model.bodies.values()]
    model.force("push", bodies[1], fx=7.0, fy=-20.0)
    model.friction("rub", model.joints["touch"], MU, 1e-9)
    machine = Interpreted(model)
    s = on_the_constraints(machine, seed)
    s.v *= way
    (ri, _, vi, wi), (rj, _, vj, wj) = s.body(0), s.body(1)
    place, tangent = contact(kind, s)
    slip = tangent @ (vj + wj * LEFT @ (place - rj) - vi - wi * LEFT @ (place - ri))
    assert abs(slip) > 1e-3
    a, lam = machine.solution(s)
    push = -machine.jacobian(s).T @ lam
    assert abs(push[3:5] @ tangent) < 1e-9 * np.linalg.norm(push[3:5])  # the joint has no drag
    force = -MU * np.linalg.norm(push[3:5]) * np.sign(slip) * tangent
    by_hand = np.zeros(machine.n)
    by_hand[:3] = *-force, -(force @ LEFT @ (place - ri))
    by_hand[3:6] = *force, force @ LEFT @ (place - rj)
    rest = machine.mass(s) @ a - push - machine.vector("applied_forces", s) - by_hand
    assert_allclose(rest, 0, atol=1e-10 * np.abs(lam).max())
    found = reported(machine, s, lam)
    assert_allclose(found["rub", "force"], force @ tangent, rtol=1e-10)
    power = power_of_friction(machine, s, lam)
    assert_allclose(power, by_hand @ s.v, rtol=1e-10)
    assert power < 0


def roller(cam_first: bool, turned: float) -> tuple[np.ndarray, float]:
    """Accelerations of two discs pressed together, and the power of their friction."""
    model = Model("discs", gravity=(0, -9.81))
    below, above = (model.body(name, mass=2.0, inertia=0.1) for name in ("below", "above"))
    model.revolute("axle", model.ground.at(0, 0), below)
    model.translational("guide", model.ground.at(0, 0), above, axis=(0, 1))
    curves = (below.circle(0.5, center=(0.1, 0)), above.circle(0.25))
    first, second = curves if cam_first else curves[::-1]
    model.friction("rub", model.cam_follower("touch", first, second), MU, 1e-6)
    machine = Interpreted(model)
    phi, speed = 0.4, 2.0 * turned
    x, y = 0.1 * np.cos(phi), 0.1 * np.sin(phi)
    lean = np.arccos(-x / 0.75)  # of the line of centres, from the disc below
    height = y + 0.75 * np.sin(lean)
    lean_rate = speed * 0.1 * np.sin(phi) / (-0.75 * np.sin(lean))
    rise = speed * x + 0.75 * np.cos(lean) * lean_rate
    angles = [(lean - phi, lean_rate - speed), (lean + np.pi, lean_rate)]
    (one, one_rate), (other, other_rate) = angles if cam_first else angles[::-1]
    s = State(
        t=0.0, q=np.array([0, 0, phi, 0, height, 0, one, other]),
        v=np.array([0, 0, speed, 0, rise, 0, one_rate, other_rate]),
    )  # fmt: skip
    assert_allclose(machine.vector("constraints", s), 0, atol=1e-14)
    moved = machine.jacobian(s) @ s.v
    assert_allclose(moved, 0, atol=1e-14)
    a, lam = machine.solution(s)
    return a[:6], power_of_friction(machine, s, lam)


@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_either_curve_may_be_the_cam(turned: float) -> None:
    (one, lost), (other, lost_too) = roller(True, turned), roller(False, turned)
    assert_allclose(one, other, rtol=1e-10, atol=1e-12)
    assert_allclose(lost, lost_too, rtol=1e-10)
    assert lost < 0


@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_disc_on_a_slope_is_slowed_by_the_arm(speed: float) -> None:
    slope, radius, mass, inertia = 0.3, 0.2, 3.0, 0.07
    model = Model("roller", gravity=(9.81 * np.sin(slope), -9.81 * np.cos(slope)))
    disc = model.body("disc", mass=mass, inertia=inertia)
    roll = model.rolling_disc("roll", disc, model.ground.at(0, 0), radius=radius, axis=(1, 0))
    model.friction("rub", roll, arm="4 mm", creep=1e-4)
    machine = Interpreted(model)
    s = State(t=0.0, q=np.array([0, radius, 0]), v=np.array([speed, 0, -speed / radius]))
    a, lam = machine.solution(s)
    torque = 0.004 * mass * 9.81 * np.cos(slope) * np.sign(speed)
    slowed = 9.81 * np.sin(slope) - torque / (mass * radius)
    slowed /= 1 + inertia / (mass * radius**2)
    assert_allclose(a[0], slowed, rtol=1e-10)
    assert_allclose(a[2], -slowed / radius, rtol=1e-10)
    assert_allclose(reported(machine, s, lam)["rub", "torque"], torque, rtol=1e-10)
    assert_allclose(power_of_friction(machine, s, lam), -torque * speed / radius, rtol=1e-10)


@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_line_that_moves_under_a_disc_on_an_axle(speed: float) -> None:
    """A table is pressed against the disc from below; the line turns as little as the ground."""
    radius, arm, pressed, push = 0.2, 0.004, 50.0, 7.0
    model = Model("table")
    table = model.body("table", mass=2.0, inertia=1.0)
    disc = model.body("disc", mass=3.0, inertia=0.07)
    model.revolute("axle", model.ground.at(0, 0), disc)
    model.relative("level", model.ground, table, "phi", 0.0)
    roll = model.rolling_disc("roll", disc, table.at(0, 0), radius=radius, axis=(1, 0))
    model.friction("rub", roll, arm=arm, creep=1e-4)
    model.force("press", table, fx=push, fy=pressed)
    machine = Interpreted(model)
    q = np.array([0, -radius, 0, 0, 0, 0])
    s = State(t=0.0, q=q, v=np.array([speed, 0, 0, 0, 0, speed / radius]))
    a, lam = machine.solution(s)
    torque = -arm * pressed * np.sign(speed)
    assert_allclose(a[0], (push + torque / radius) / (2.0 + 0.07 / radius**2), rtol=1e-10)
    found = reported(machine, s, lam)
    assert_allclose(found["rub", "torque"], torque, rtol=1e-10)
    assert_allclose(found["level", "torque"], torque, rtol=1e-10)  # its couple on the table
    assert_allclose(power_of_friction(machine, s, lam), torque * speed / radius, rtol=1e-10)


def test_disc_comes_to_rest_and_stays(tmp_path: Path) -> None:
    slope, arm, radius = 0.01, 0.004, 0.2
    model = Model("stops", gravity=(9.81 * np.sin(slope), -9.81 * np.cos(slope)))
    disc = model.body("disc", mass=3.0, inertia=0.06)
    roll = model.rolling_disc("roll", disc, model.ground, radius=radius)
    model.friction("rub", roll, arm=arm, static=0.005)
    model.scene("run", ["gravity", "rub"], start={disc.vx: 0.1, disc.x: 0.0})
    run = load(model, folder=tmp_path).simulate(4.0, 401, rtol=1e-10, atol=1e-12)
    slowing = 9.81 * (np.cos(slope) * arm / radius - np.sin(slope)) / 1.5
    assert_allclose(run.events[0].time, 0.1 / slowing, rtol=1e-10)
    moving = run.t < 0.1 / slowing
    assert_allclose(run.v("disc.x")[moving], (0.1 - slowing * run.t)[moving], atol=1e-10)
    assert_allclose(run.v("disc.x")[~moving], 0, atol=1e-12)
    held = -3.0 * 9.81 * np.sin(slope) * radius
    assert_allclose(np.abs(run.reaction("rub", "torque")[-1]), np.abs(held), rtol=1e-9)


def bead(build: Callable[[Model, Any], Any], gravity: float, **friction: Any) -> Model:
    model = Model("bead", gravity=(0, -gravity))
    bead = model.particle("bead", mass=0.5)
    model.friction("rub", build(model, bead), MU, **friction)
    model.scene(
        "slide", ["gravity", "rub"], start={bead.x: 0.6, bead.vy: -1.2 if gravity else 1.5},
        guess={bead.y: -0.8},
    )  # fmt: skip
    return model


def ring(model: Model, bead: Any) -> Any:
    return model.point_follower("wire", model.ground.circle(1.0), bead.at(0, 0))


def test_bead_on_a_ring_loses_speed_with_the_angle(tmp_path: Path) -> None:
    """N = m v²/R alone: v = v₀/(1 + μ v₀ t/R)."""
    machine = load(bead(ring, 0.0), folder=tmp_path)
    run = machine.simulate(3.0, 61, rtol=1e-11, atol=1e-13)
    speed = np.hypot(run.v("bead.x"), run.v("bead.y"))
    assert_allclose(speed, speed[0] / (1 + MU * speed[0] * run.t), rtol=1e-9)


def test_bead_sticks_where_the_ring_is_flat_enough(tmp_path: Path) -> None:
    machine = load(bead(ring, 9.81), folder=tmp_path)
    run = machine.simulate(6.0, 6001, rtol=1e-10, atol=1e-12)
    x, y = run.q("bead.x"), run.q("bead.y")
    assert np.abs(run.v("bead.x")[-1]) < 1e-12
    assert abs(x[-1] / y[-1]) <= MU
    drag = -0.5 * 9.81 * x[-1]
    assert_allclose(np.abs(run.reaction("rub", "force")[-1]), np.abs(drag), rtol=1e-8)
    assert_allclose(run.reaction("rub", "normal")[-1], -0.5 * 9.81 * y[-1], rtol=1e-8)
    power = run.data["power"].sel(source="rub").to_numpy()
    assert power.max() <= 1e-12
    total = run.data["energy"].sel(part="total").to_numpy()
    lost = np.trapezoid(power, run.t)
    assert_allclose(total[-1] - total[0], lost, rtol=1e-5)


def test_eccentric_cam_locks_itself(tmp_path: Path) -> None:
    """The follower's weight turns the cam back only where e cos φ > μ (R + e sin φ)."""
    phi, radius, off = 0.3, 0.05, 0.02
    model = Model("locking", gravity=(0, -9.81))
    mu = model.parameter("mu", 0.4)
    cam = model.body("cam", mass=1.0, inertia=0.01)
    follower = model.body("follower", mass=2.0, inertia=0.02)
    model.revolute("axle", model.ground.at(0, 0), cam)
    model.translational("guide", model.ground.at(0, 0), follower, axis=(0, 1))
    touch = model.cam_flat_follower("touch", cam.circle(radius, center=(off, 0)), follower)
    model.friction("rub", touch, mu)
    model.scene(
        "rest", ["gravity", "rub"], start={cam.phi: phi, cam.omega: 0.0}, guess={follower.y: 0.05}
    )
    machine = load(model, folder=tmp_path)
    arm, height = off * np.cos(phi), radius + off * np.sin(phi)
    held = machine.simulate(0.2, 11)
    assert_allclose(held.q("cam.phi"), phi, atol=1e-12)
    assert_allclose(held.reaction("rub", "normal"), 2 * 9.81, rtol=1e-10)
    assert_allclose(held.reaction("rub", "force"), 2 * 9.81 * arm / height, rtol=1e-10)
    slides = machine.simulate(0.2, 11, parameters={"mu": 0.3}, rtol=1e-10)
    assert arm / height > 0.3
    assert slides.q("cam.phi")[-1] < phi - 1e-3
    assert_allclose(
        slides.reaction("rub", "force"), 0.3 * slides.reaction("touch", "fy"), rtol=1e-9
    )


@pytest.mark.parametrize("omega", [1.5, -1.5])
def test_body_that_counts_no_angle_rubs_as_one_that_does(omega: float) -> None:
    """A bar whose tip follows a ring, oriented by an angle or by the numbers of `TurnedBody`."""
    found = []
    phi, at = 0.7, 2.1
    for turned in (False, True):
        model = Model("bar", gravity=(0, -9.81))
        bar: Any = turned_body(model, "bar", 2.0, 0.3, (0, 0)) if turned else None
        bar = bar or model.body("bar", mass=2.0, inertia=0.3)
        ring = model.point_follower("ring", model.ground.circle(1.0), bar.at(0.4, 0))
        model.friction("rub", ring, MU, 1e-6)
        machine = Interpreted(model)
        arm = 0.4 * np.array([np.cos(phi), np.sin(phi)])
        tip, tip_rate = (
            np.array([np.cos(at), np.sin(at)]),
            0.9 * np.array([-np.sin(at), np.cos(at)]),
        )
        r, v = tip - arm, tip_rate - omega * LEFT @ arm
        half, half_rate = phi / 2, omega / 2
        angles, rates = [phi], [omega]
        if turned:
            angles = [np.cos(half), np.sin(half)]
            rates = [-half_rate * np.sin(half), half_rate * np.cos(half)]
        s = State(t=0.0, q=np.array([*r, *angles, at]), v=np.array([*v, *rates, 0.9]))
        assert_allclose(machine.vector("constraints", s), 0, atol=1e-14)
        a, lam = machine.solution(s)
        found.append([*a[:2], a[-1], reported(machine, s, lam)["rub", "force"]])
    assert_allclose(found[1], found[0], rtol=1e-10)
