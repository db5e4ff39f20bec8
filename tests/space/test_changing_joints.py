"""Joints in space that come and go: closed forms, conserved quantities, and random machines."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation
from sympy import Piecewise

from codegen import Model, t
from runtime import load
from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_declaration import coordinates
from tests.random_mechanisms.spatial_dynamics import SpatialDense
from tests.random_mechanisms.spatial_impacts import (
    END,
    Changing,
    Touch,
    impact,
    random_changing,
    speeds,
)
from tests.space.machines import X
from tests.space.test_contacts import spins, velocities

SEEDS = (17, 20, 24)  # of small machines


@pytest.mark.parametrize("seed", SEEDS)
def test_random_trees_have_the_impacts_of_newton_and_euler(seed: int, workshop: Path) -> None:
    """A joint engages and a contact strikes; the motion goes on, perhaps with a joint less."""
    made = random_changing(seed, "tree")
    assert made is not None
    exact = [coordinates(state) for state in made.states]
    machine = load(made.model(f"changing_{seed}"), folder=workshop)
    names = (*machine.coordinates.names, *(row.velocity for row in machine.coordinates))
    q, v = coordinates(made.start)
    start = machine.assemble(guess=dict(zip(names, [*q.tolist(), *v.tolist()], strict=True)))
    result = machine.simulate(END, 2, start=start, rtol=1e-11, progress=False)
    (hit,) = (event for event in result.events if event.element == "touch")
    found = (hit.q, hit.v), (result.samples.q[-1], result.samples.v[-1])
    assert [c.joint for c in result.reconnections] == [*filter(None, (made.caught, made.freed))]
    assert all(c.energy_lost >= 0.0 for c in result.reconnections)
    for pair, other in zip(found, exact, strict=True):
        same = np.sign(np.sum((pair[0] * other[0]).reshape(-1, 7)[:, 3:], axis=1))  # p or -p
        turned = np.ones((len(same), 7))
        turned[:, 3:] = same[:, None]
        for one, two in zip(pair, other, strict=True):
            size = max(1.0, float(np.abs(two).max()))
            assert_allclose(one * turned.ravel(), two, rtol=0.0, atol=1e-9 * size)


def test_a_flying_body_is_caught_at_a_point_and_let_go(workshop: Path) -> None:
    """A sphere turns at a constant rate; its angular momentum about the pin stays at the catch."""
    mass, moment, caught, freed = 2.0, 0.3, 0.25, 0.5
    arm, speed, spin = np.array([0.1, -0.3, 0.2]), np.array([0.4, 1.0, -0.2]), 3.0
    turned = Rotation.from_rotvec([spin * caught, 0, 0]).as_matrix() @ arm  # ω about the x axis
    place = speed * caught + turned
    model = Model("catch", space=True)
    body = model.body("body", mass, (moment,) * 3)
    pin = model.spherical("pin", model.ground.at(*place), body.at(*arm))
    model.engage(pin, when=t > caught, until=t > freed)
    start = dict(zip(("body.vx", "body.vy", "body.vz"), speed.tolist(), strict=True))
    model.scene("fly", start=start | {"body.omega_x": spin})
    result = load(model, folder=workshop).simulate(1.0, 21, rtol=1e-11, progress=False)
    about = -turned  # from the pin to the centre
    inertia = moment * np.eye(3) + mass * (about @ about * np.eye(3) - np.outer(about, about))
    momentum = moment * np.array([spin, 0, 0]) + mass * np.cross(about, speed)
    after = np.linalg.solve(inertia, momentum)
    first, second = result.reconnections
    lost = (mass * speed @ speed + moment * spin**2 - after @ inertia @ after) / 2
    assert first.energy_lost == pytest.approx(lost, rel=1e-10)
    impulse = mass * (np.cross(after, about) - speed)
    assert_allclose([first.impulse[f"f{c}"] for c in "xyz"], impulse, rtol=1e-9)
    assert_allclose([first.impulse[f"t{c}"] for c in "xyz"], 0.0, atol=1e-12)
    assert (second.action, second.time) == ("release", pytest.approx(freed, abs=1e-12))
    held = (result.t > caught) & (result.t < freed)
    global_spin = np.einsum("kij,kj->ki", result.rotation("body"), spins(result, "body"))
    at_pin = np.column_stack([result.q(f"body.{c}") for c in "xyz"])
    at_pin += result.rotation("body") @ arm
    assert_allclose(at_pin[held], place[None].repeat(held.sum(), 0), rtol=0.0, atol=1e-11)
    assert_allclose(result.energy()[held], after @ inertia @ after / 2, rtol=1e-9)
    flies = result.t > freed
    for row in (velocities(result, "body"), global_spin):
        assert_allclose(row[flies], row[flies][:1].repeat(flies.sum(), 0), rtol=0.0, atol=1e-10)
    assert_allclose(result.energy()[flies], after @ inertia @ after / 2, rtol=1e-9)


def test_the_floor_takes_part_in_the_impact_of_a_joint(workshop: Path) -> None:
    """A body that slides on the floor is caught above; alone the joint would push it down."""
    body = parts.SpatialBody(
        "b", 2.0, ((0.3, 0.05, 0), (0.05, 0.4, 0), (0, 0, 0.2)), (0.0, 0.0, 0.3)
    )
    pin = parts.Spherical("pin", parts.GROUND, 0, (0.2, 0.05, 0.5))
    mechanism = parts.SpatialMechanism((body,), (pin,), (parts.Gravity("gravity"),))
    foot = Touch(parts.GROUND, 0, np.zeros(3), np.zeros(3), np.array([0.0, 0, 1]), 0.0, 0.5)
    made = Changing(mechanism, "pin", "", foot, SpatialDense(mechanism).at_drawing)
    dense = made.without()
    moving = replace(made.start, v=np.array([[1.0, 0.2, 0.0]]))
    gap, slope = foot.gap(dense, moving)
    alone = impact(dense, moving, [], [])
    assert gap == 0.0
    assert slope @ speeds(alone) < -0.05
    exact = impact(dense, moving, [slope], [0.5])
    result = load(made.model("catch_on_floor"), folder=workshop).simulate(
        2e-6, 3, start={"b.vx": 1.0, "b.vy": 0.2, "b.vz": 0.0}, rtol=1e-11, progress=False
    )
    (caught,) = result.reconnections
    lost = dense.energy(moving) - dense.energy(exact)
    assert caught.energy_lost == pytest.approx(lost, rel=1e-9)
    v = result.samples.v  # just behind the impact, by a straight line
    assert_allclose(2 * v[1] - v[2], coordinates(exact)[1], rtol=0.0, atol=1e-9)
    assert [event.text for event in result.events] == []


@pytest.fixture(scope="module")
def pendulum(workshop: Path) -> Any:
    """A pendulum that its own speed releases, and a body with forces that switch by its own."""
    model = Model("pendulum", space=True)
    bob = model.body("bob", 1.0, (0.1, 0.2, 0.25), at=(0, 0.5, 0))
    hinge = model.revolute("hinge", model.ground, bob, at=(0, 0, 0), axis=X)
    model.force("weight", bob, (0, 0, -9.81))
    model.release(hinge, when=bob.omega_x < -3)
    wheel = model.body("wheel", 1.0, (0.1, 0.2, 0.25), at=(5, 0, 0))
    model.torque("motor", wheel, (1.0, 0, 0), frame="body")
    model.label(wheel.omega_x > 1, "fast / slow")
    model.force("jet", wheel, (Piecewise((2.0, wheel.omega_x > 1), (0, True)), 0, 0))
    model.line_force("tow", model.ground.at(0, 0, 0), wheel, 1.0, when=wheel.omega_x < 1.5)
    model.scene("run", ["weight", "motor", "jet", "tow"])
    return load(model, folder=workshop)


def test_a_joint_is_released_and_forces_switch_by_angular_velocity(pendulum: Any) -> None:
    result = pendulum.simulate(1.0, 11, rtol=1e-11, progress=False)
    found = {event.text: event for event in result.events}
    assert {*found} == {
        "fast", "tow: omega_x of wheel passes 1.5 rad/s",
        "hinge: omega_x of bob falls below -3 rad/s",
    }  # fmt: skip
    assert found["fast"].time == pytest.approx(0.1, rel=1e-9)
    assert found["tow: omega_x of wheel passes 1.5 rad/s"].time == pytest.approx(0.15, rel=1e-9)
    speed = -np.minimum(result.t, 0.15) + 2.0 * np.clip(result.t - 0.1, 0.0, None)
    assert_allclose(result.v("wheel.vx"), speed, rtol=0.0, atol=1e-9)
    (cut,) = result.reconnections
    let_go = found["hinge: omega_x of bob falls below -3 rad/s"]
    assert cut.time == let_go.time
    assert let_go.q[2] == pytest.approx(-0.5 * (0.1 + 0.25) * 9 / (2 * 9.81 * 0.5), rel=1e-9)
    flies = result.t > cut.time
    assert_allclose(result["bob.omega_x"][flies], -3.0, rtol=1e-9)
    assert_allclose(result.reaction("hinge", "fz")[flies], 0.0, atol=0.0)


def test_a_component_of_a_reaction_may_end_a_run(pendulum: Any) -> None:
    result = pendulum.simulate(1.0, until={"shear": ("hinge.fz", ">", 4.0)}, progress=False)
    assert result.ended_by == "shear"
    assert result.t[-1] < 0.3
    assert result.reaction("hinge", "fz")[-1] == pytest.approx(4.0, rel=1e-6)


def test_bodies_that_are_welded_in_flight_keep_both_momenta(workshop: Path) -> None:
    """The joint held them by a point before; so three of its rows follow from the other joint."""
    model = Model("docking", space=True)
    moments = {"a": (0.3, 0.5, 0.4), "b": (0.2, 0.1, 0.15)}
    a = model.body("a", 2.0, moments["a"], axes=(0.4, -0.3, 0.8))
    b = model.body("b", 1.0, moments["b"], at=(0, 0.3, -0.7), axes=(0.1, 0.3, -0.8))
    model.spherical("ball", a, b, at=(0, 0, -0.5))
    lock = model.weld("lock", a, b, at=(0, 0.1, -0.5))
    model.engage(lock, when=t > 0, until=t > 0.5)
    start = {"a.omega_x": 1.0, "a.omega_z": 2.0, "b.omega_x": 0.3, "b.omega_y": -1.0}
    model.scene("dock", start=start | {"a.vx": 0.1, "a.vz": 0.0, "a.vy": 0.0})
    result = load(model, folder=workshop).simulate(1.0, 21, rtol=1e-11, progress=False)
    caught, freed = result.reconnections
    assert (caught.joint, caught.action, freed.action) == ("lock", "engage", "release")
    linear, angular = np.zeros((21, 3)), np.zeros((21, 3))
    for name, mass in (("a", 2.0), ("b", 1.0)):
        place = np.column_stack([result.q(f"{name}.{c}") for c in "xyz"])
        momentum, spin = mass * velocities(result, name), spins(result, name)
        linear += momentum
        angular += np.cross(place, momentum)
        angular += np.einsum("kij,kj->ki", result.rotation(name), np.array(moments[name]) * spin)
    assert_allclose(linear, linear[:1].repeat(21, 0), rtol=0.0, atol=1e-9)
    assert_allclose(angular, angular[:1].repeat(21, 0), rtol=0.0, atol=1e-9)
    energy = result.energy()
    assert caught.energy_lost > 0.1
    assert_allclose(energy[1:], energy[0] - caught.energy_lost, rtol=1e-10)
    turn = np.einsum("kij,kj->ki", result.rotation("a"), spins(result, "a"))
    turn -= np.einsum("kij,kj->ki", result.rotation("b"), spins(result, "b"))
    assert np.abs(turn[0]).max() > 0.5
    assert_allclose(turn[1:10], 0.0, rtol=0.0, atol=1e-9)
