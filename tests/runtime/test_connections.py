"""Joints that are released or engage in one run: closed forms, momentum, energy, kinematics."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Not, cos, pi, sin

from codegen import Model, build, t
from codegen.errors import AnalysisError, ModelError
from runtime import load, load_result
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

G = 9.81
METHODS = ("dop853", "dopri5", "radau5", "bdf")


@pytest.fixture(scope="module")
def cut(workshop: Path) -> Machine:
    """A pendulum of 1 m that is cut loose at 0.5 rad."""
    model = Model("pendulum_cut", gravity=(0, -G))
    bob = model.body("bob", mass=1.0, inertia=0.1)
    hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.release(hinge, when=bob.phi > 0.5)
    model.scene("swing", ["gravity"], start={bob.phi: -pi / 2, bob.omega: 7.0})
    return load(model, folder=workshop)


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize("method", METHODS)
def test_a_pendulum_that_is_cut_flies_on(cut: Machine, method: str, formulation: str) -> None:
    r = cut.simulate(1.5, method=method, formulation=formulation, rtol=1e-11)
    assert r.outcome is Outcome.OK
    (change,) = r.reconnections
    assert (change.joint, change.action, change.impulse) == ("hinge", "release", {})
    omega = np.sqrt(49 - 2 * G * (np.sin(0.5) + 1) / 1.1)
    behind = r.t > change.time
    time = r.t[behind] - change.time
    x = np.cos(0.5) - omega * np.sin(0.5) * time
    y = np.sin(0.5) + omega * np.cos(0.5) * time - G * time**2 / 2
    got = np.array([r.q(f"bob.{name}")[behind] for name in ("x", "y", "phi")])
    assert_allclose(got, [x, y, 0.5 + omega * time], atol=1e-8 if method == "bdf" else 1e-9)
    energy = r.energy("kinetic") + r.energy("potential")
    assert np.ptp(energy) < 2e-8
    assert not r.reaction("hinge", "fx")[behind].any()


def test_the_motion_has_both_sides_of_the_release(cut: Machine, tmp_path: Path) -> None:
    r = cut.simulate(1.5, [0.1, 1.0], rtol=1e-10)
    assert_allclose(r.t, [0.1, 1.0])
    at = r.reconnections[0].time
    near = r.at([at - 1e-6, at + 1e-6])
    assert_allclose(np.diff(near.v("bob.vy")), -G * 1e-6 + near.a("bob.vy")[0] * 1e-6, atol=1e-4)
    assert abs(np.diff(near.reaction("hinge", "fx"))[0]) > 1
    assert_allclose(r.at([0.1, 1.0]).q("bob.x"), r.q("bob.x"), rtol=1e-14)
    r.save(tmp_path / "cut.nc")
    back = load_result(tmp_path / "cut.nc", cut)
    assert back.reconnections == r.reconnections
    assert_allclose(back.at(0.7).q("bob.y"), r.at(0.7).q("bob.y"), rtol=1e-14)


@pytest.mark.parametrize("method", METHODS)
def test_two_masses_that_latch(workshop: Path, method: str) -> None:
    model = Model("masses_latch")
    a, b = (model.body(name, mass=m, inertia=0.1) for name, m in (("a", 2.0), ("b", 1.0)))
    for body in (a, b):
        model.translational(f"rail_{body.name}", model.ground.at(0, 0), body.at(0, 0), (1, 0))
    latch = model.constraint("latch", b.x - a.x - 0.2)
    model.engage(latch, when=b.x - a.x < 0.2)
    model.spring("tie", model.ground.at(0, 0), b.at(0, 0), stiffness=50.0, free_length=1.0)
    model.scene("runs", ["tie"], start={a.x: 0.0, a.vx: 3.0, b.x: 1.0, b.vx: 0.0})
    r = load(model, folder=workshop).simulate(1.0, [0.2, 0.6], method=method, rtol=1e-11)
    (change,) = r.reconnections
    assert_allclose(change.time, 0.8 / 3, atol=1e-10)
    assert_allclose(change.energy_lost, 3.0, atol=1e-9)
    assert_allclose([abs(x) for x in change.impulse.values()], [2.0], atol=1e-9)
    w = np.sqrt(50 / 3)
    assert_allclose(r.q("b.x")[1], 1 + 2 / w * np.sin(w * (0.6 - 0.8 / 3)), atol=1e-9)
    assert_allclose(r.q("b.x")[1] - r.q("a.x")[1], 0.2, atol=1e-9)


def test_a_geneva_drive_follows_its_kinematics(workshop: Path) -> None:
    """A pin on a crank of radius 1 enters a slot of the wheel at a right angle, four to a turn."""
    model = Model("geneva")
    omega, distance = 2.0, np.sqrt(2.0)
    crank = model.body("crank", mass=1.0, inertia=1.0)
    wheel = model.body("wheel", mass=1.0, inertia=0.5)
    model.revolute("a", model.ground.at(0, 0), crank.at(0, 0))
    model.revolute("b", model.ground.at(distance, 0), wheel.at(0, 0))
    model.driver("motor", crank.phi, -pi / 2 + omega * t)
    pin_x, pin_y = cos(crank.phi) - distance, sin(crank.phi)
    slot = model.constraint("slot", pin_x * sin(wheel.phi) - pin_y * cos(wheel.phi))
    inside = cos(crank.phi) > np.sqrt(0.5)
    model.engage(slot, when=inside, until=Not(inside))
    model.scene("turns", drivers=["motor"], start={wheel.phi: -0.75 * pi, wheel.omega: 0.0})
    times = np.linspace(0.05, 1.5, 59)
    r = load(model, folder=workshop).simulate(1.5, times, rtol=1e-11)
    assert [one.action for one in r.reconnections] == ["engage", "release"]
    assert_allclose([one.time for one in r.reconnections], [np.pi / 8, 3 * np.pi / 8], atol=1e-9)
    angle = np.clip(-np.pi / 2 + omega * times, -np.pi / 4, np.pi / 4)
    expected = np.arctan2(np.sin(angle), np.cos(angle) - distance)
    turned = np.unwrap(np.where(expected < 0, expected + 2 * np.pi, expected))
    got = r.q("wheel.phi") - r.q("wheel.phi")[0]
    assert_allclose(np.abs(got), np.abs(turned - turned[0]), atol=1e-9)


def test_a_joint_that_is_open_does_not_engage(workshop: Path) -> None:
    model = Model("open_latch", gravity=(0, -G))
    body = model.body("body", mass=1.0, inertia=0.1)
    pin = model.revolute("pin", model.ground.at(0, 0), body.at(0, 0))
    model.engage(pin, when=body.y < 0)
    model.scene("falls", ["gravity"], start={
        body.x: 0.3, body.y: 1.0, body.phi: 0.0, body.vx: 0.0, body.vy: 0.0, body.omega: 0.0
    })  # fmt: skip
    r = load(model, folder=workshop).simulate(2.0)
    assert r.outcome is Outcome.INCONSISTENT
    assert "Joint 'pin' is to engage" in r.message
    assert "pin.x by 0.3" in r.message


def test_scenes_of_joints_that_come_and_go() -> None:
    model = Model("several_joints")
    body = model.body("body", mass=1.0, inertia=0.1)
    first = model.revolute("first", model.ground.at(0, 0), body.at(0, 0))
    second = model.revolute("second", model.ground.at(1, 0), body.at(1, 0))
    model.release(first, when=body.phi > 1)
    model.engage(second, when=body.phi > 2)
    model.scene("runs")
    names = ["runs", "runs_without_first", "runs_with_second", "runs_without_first_with_second"]
    assert sorted(model.scenes) == sorted(names)


@pytest.mark.parametrize("analysis", ["kinematics", "inverse_dynamics"])
def test_prescribed_motions_refuse_joints_that_come_and_go(workshop: Path, analysis: str) -> None:
    model = Model("driven_and_cut", gravity=(0, -G))
    arm, cargo = model.body("arm", 1.0, 0.1), model.body("load", 1.0, 0.1)
    model.revolute("pin", model.ground, arm.at(-0.5, 0))
    model.release(model.weld("hold", arm.at(0.5, 0), cargo.at(-0.5, 0)), when=t > 0.5)
    model.driver("turn", arm.phi, t)
    model.scene("run", ["gravity"], ["turn"], guess={arm.x: 0.5, cargo.x: 1.5})
    machine = load(model, folder=workshop)
    with pytest.raises(AnalysisError, match=r"cannot release or engage hold; simulate\."):
        getattr(machine, analysis)(1.0, 11)


def test_wrong_joints_that_come_and_go() -> None:
    model = Model("wrong_joints")
    body = model.body("body", mass=1.0, inertia=0.1)
    pin = model.revolute("pin", model.ground.at(0, 0), body.at(0, 0))
    model.release("pni", when=body.phi > 1)
    model.release(model.driver("motor", body.phi, t), when=body.phi > 1)
    model.release(pin, when=None)
    model.engage(pin, when=body.phi > 1)
    model.scene("runs")
    with pytest.raises(ModelError) as caught:
        build(model, compile=False)
    text = str(caught.value)
    for part in (
        "there is no joint 'pni'",
        "no joint 'motor'; it is the name of a driver",
        "when=None is no condition",
        "comes and goes already",
    ):
        assert part in text, part


@pytest.fixture(scope="module")
def towed(workshop: Path) -> Machine:
    """A mass on a damped spring with a second one behind it, which a coupling lets go."""
    model = Model("towed_release")
    a, b = (model.particle(name, 1.0) for name in ("a", "b"))
    for mass in (a, b):
        model.absolute(f"rail_{mass.name}", mass, "y", 0.0)
    coupling = model.constraint("coupling", b.x - a.x + 1)
    model.release(coupling, when=a.x > 0.5)
    model.spring("tie", model.ground.at(3, 0), a, stiffness=9.0, free_length=1.0, damping=0.2)
    model.force("drag", b, fx=-0.3 * b.vx)
    count = model.sampled("count", when=a.vx > 0.01, value=lambda n: n + 1)
    clock = model.sampled("clock", 0.1, t, delay=0.25, unit="s")
    model.scene(
        "runs", ["tie", "drag", count, clock], start={a.x: 0.0, a.vx: 0.0},
        outputs=["energy", "powers", "works", "reaction(coupling)"],
    )  # fmt: skip
    return load(model, folder=workshop)


@pytest.mark.parametrize("times", [[0.2, 1.0, 2.0], [0.2], None, "steps"])
def test_works_clocks_and_counts_go_on_past_a_release(towed: Machine, times: object) -> None:
    r = towed.simulate(2.0, times, rtol=1e-11)
    (change,) = r.reconnections
    assert 0.2 < change.time < 1.0
    end = r.at(2.0)
    work = sum(series[-1] for series in end.works.values())
    assert_allclose(work, end.energy("kinetic")[-1], atol=1e-9)
    assert_allclose(end.y("count")[-1], 1)
    assert_allclose(end.y("clock")[-1], 1.7)
    assert_allclose(r.at([0.3, 0.36, 0.46]).y("clock"), [0.0, 0.1, 0.2], atol=1e-15)
    if isinstance(times, list):
        assert_allclose(r.t, times)


def test_a_machine_that_its_latch_alone_holds(workshop: Path) -> None:
    model = Model("held_by_latch", gravity=(0, -G))
    bob = model.body("bob", mass=1.0, inertia=0.1)
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    catch = model.absolute("catch", bob, "phi", 0.0)
    model.release(catch, when=t > 0.5)
    model.scene("hangs", ["gravity"])
    r = load(model, folder=workshop).simulate(1.0, [0.25, 1.0], rtol=1e-10)
    assert_allclose(r.q("bob.phi")[0], 0.0, atol=1e-14)
    assert r.q("bob.phi")[1] < -0.5
    assert_allclose(abs(r.at(0.3).reaction("catch", "torque")), G, rtol=1e-9)


def test_two_joints_that_are_released_at_once(workshop: Path) -> None:
    model = Model("released_at_once", gravity=(0, -G))
    bob = model.body("bob", mass=1.0, inertia=0.1)
    for name, x in (("left", -1), ("right", 1)):
        joint = model.distance(name, model.ground.at(x, 0), bob.at(x / 2, 0), 1.0)
        model.release(joint, when=t > 0.2)
    model.scene("falls", ["gravity"], guess={bob.y: -0.87})
    r = load(model, folder=workshop).simulate(0.5, [0.5], rtol=1e-10)
    assert sorted(one.joint for one in r.reconnections) == ["left", "right"]
    assert_allclose([one.time for one in r.reconnections], 0.2, atol=1e-12)
    assert_allclose(r.v("bob.vy")[0] - r.at(0.2).v("bob.vy")[0], -G * 0.3, rtol=1e-9)


def test_a_joint_is_declared_before_its_scenes() -> None:
    model = Model("late_release")
    body = model.body("body", mass=1.0, inertia=0.1)
    pin = model.revolute("pin", model.ground.at(0, 0), body.at(0, 0))
    model.scene("runs")
    model.release(pin, when=body.phi > 1)
    with pytest.raises(ModelError, match="declare it before scene 'runs'"):
        build(model, compile=False)


def test_impacts_of_masses_far_apart(workshop: Path) -> None:
    model = Model("light_latch")
    a, b = (model.particle(name, m) for name, m in (("a", 1e-13), ("b", 2e-13)))
    for mass in (a, b):
        model.absolute(f"rail_{mass.name}", mass, "y", 0.0)
    heavy = model.particle("heavy", 1e3)
    model.absolute("rail_heavy", heavy, "y", 0.0)
    latch = model.constraint("latch", b.x - a.x)
    model.engage(latch, when=b.x - a.x < 0)
    model.scene("runs", start={a.x: 0, a.vx: 3, b.x: 1, b.vx: 0, heavy.x: 0, heavy.vx: 1})
    r = load(model, folder=workshop).simulate(1.0, [1.0])
    assert_allclose([r.v(f"{n}.vx")[0] for n in ("a", "b", "heavy")], [1, 1, 1], rtol=1e-12)
