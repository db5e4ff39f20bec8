"""Wrenches of joints against Newton and Euler; axes and angles; comparisons of p with -p."""

from copy import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from codegen.errors import InputError
from runtime import load
from runtime.accuracy_target.error_norms import Scale, errors
from runtime.mechanism.spins import axes_and_angles
from tests.space.machines import DOWN, Z
from tests.space.rotations import about

MASSES = {"door": (3.0, (0.4, 0.1, 0.3)), "bob": (1.5, (0.02, 0.03, 0.04))}
COMPONENTS = ("fx", "fy", "fz", "tx", "ty", "tz")


def door() -> Model:
    """A door in two hinges, of which one would do, with a bob on a ball joint at its edge."""
    model = Model("door", space=True, gravity=DOWN)
    leaf, bob = (
        model.body(name, *MASSES[name], at=at)
        for name, at in (("door", (0.5, 0, 1)), ("bob", (1, 0.1, 0.2)))
    )
    for name, height in (("low", 0.5), ("high", 1.5)):
        model.revolute(name, model.ground, leaf, at=(0, 0, height), axis=Z)  # type: ignore[call-arg]
    model.spherical("ball", leaf, bob, at=(1, 0, 0.7))  # type: ignore[attr-defined]
    model.track("pin", leaf.at(0.5, 0, -0.3))  # type: ignore[call-arg]
    start = {"door.omega_z": 5.0, "bob.omega_x": 1.0, "bob.omega_z": -2.0}
    model.scene("swing", ["gravity"], start=start, outputs=["default", "points"])
    return model


@pytest.fixture(scope="module")
def result(workshop: Path) -> Any:
    return load(door(), folder=workshop).simulate(2.0, 81, rtol=1e-10, progress=False)


def angular_accelerations(result: Any, body: str) -> Any:
    """ω̇' = 2 G p̈ by products of quaternions: the vector of 2 p̄ p̈."""
    p, a = (
        np.column_stack([one(f"{body}.e{k}") for k in range(4)]) for one in (result.q, result.a)
    )
    (p0, e), (a0, b) = ((x[:, :1], x[:, 1:]) for x in (p, a))
    return 2.0 * (p0 * b - a0 * e - np.cross(e, b))


@pytest.mark.parametrize("body", MASSES)
def test_wrenches_move_the_body(result: Any, body: str) -> None:
    mass, moments = MASSES[body]
    joints = ("low", "high", "ball") if body == "door" else ("ball",)
    total = sum(result.wrench(joint, body) for joint in joints)
    pushed = np.column_stack([result.a(f"{body}.{c}") for c in "xyz"]) - DOWN
    assert_allclose(total[:, :3], mass * pushed, rtol=0.0, atol=1e-11 * np.abs(total).max())
    inner = sum(result.wrench(joint, body, axes=body) for joint in joints)[:, 3:]
    w = np.column_stack([result.v(f"{body}.omega_{c}") for c in "xyz"])
    torque = moments * angular_accelerations(result, body) + np.cross(w, moments * w)
    assert_allclose(inner, torque, rtol=0.0, atol=1e-11 * np.abs(total).max())


def test_points_bodies_and_axes_of_wrenches(result: Any) -> None:
    ball, low = (
        np.column_stack([result.reaction(joint, c) for c in COMPONENTS])
        for joint in ("ball", "low")
    )
    size = np.abs(low).max()
    hanging = (0.0, -0.1, 0.5)  # the ball in the frame of the bob
    for found in (
        result.wrench("ball", "bob", np.array(hanging)), result.wrench("ball", "bob", "pin"),
        -result.wrench("ball", "door", (0.5, 0, -0.3)), -result.wrench("ball", "door", "pin"),
    ):  # fmt: skip
        assert_allclose(found, ball, rtol=0.0, atol=1e-12 * size)
    assert_allclose(result.wrench("low", "door", ("-500 mm", 0, -0.5)), low, atol=1e-12 * size)
    assert_allclose(result.wrench("low", "ground", (0, 0, 0.5)), -low, atol=1e-12 * size)
    for axes in ("door", "bob"):  # which turn against each other
        turned = result.wrench("low", "door", (-0.5, 0, -0.5), axes=axes).reshape(-1, 2, 3)
        a = result.rotation(axes)
        back = np.einsum("kij,kwj->kwi", a, turned).reshape(-1, 6)
        assert_allclose(back, low, rtol=0.0, atol=1e-12 * size)


def test_refused_wrenches(result: Any) -> None:
    for arguments, text in (
        (("A7", "door"), r"no joint or driver in space 'A7'; there are: low, high, ball"),
        (("low", "bob"), "'low' acts on door, not on 'bob'"),
        (("ball", "ground"), "'ball' acts on door, bob, not on 'ground'"),
        (("low", "leaf"), "'leaf' is no body in space, which are door, bob"),
        (("low", "door", (1, 2)), r"at is \(1, 2\); it must be a place, three numbers in m, or"),
        (("low", "door", "tip"), "There is no tracked point 'tip'; there are: pin"),
        (("low", "door", (0, 0, 0), "leaf"), "'leaf' is no body in space"),
    ):
        with pytest.raises(InputError, match=text):
            result.wrench(*arguments)
    unknown = copy(result)
    unknown._mechanism = None
    with pytest.raises(InputError, match="the machine of this result is not known; load it"):
        unknown.wrench("low", "door")


def test_an_angle_is_counted_through_turns(result: Any) -> None:
    axis, angle = result.axis_angle("door")
    assert_allclose(axis, np.outer(np.ones(len(angle)), [0, 0, axis[0, 2]]), atol=1e-12)
    pin = result.point("pin")
    assert_allclose(angle * axis[0, 2], np.unwrap(np.arctan2(pin[:, 1], pin[:, 0])), atol=1e-9)
    assert np.ptp(angle) > np.pi
    axis, angle = result.axis_angle("bob")
    turned = [about(*one) for one in zip(axis, angle, strict=True)]
    assert_allclose(turned, result.rotation("bob"), rtol=0.0, atol=1e-12)
    assert (np.sum(axis[1:] * axis[:-1], axis=1) >= 0.0).all()
    with pytest.raises(InputError, match=r"'door' turns by about .* rad between t = 0 and 2 s"):
        result.at([0.0, 2.0]).axis_angle("door")


def test_signs_of_euler_parameters_and_whole_turns_do_not_matter() -> None:
    rng = np.random.default_rng(3)
    u = np.array([2.0, -1.0, 2.0]) / 3.0
    for first, last in ((0.0, 20.0), (0.0, -20.0), (3.0, -9.0), (-2.0, 2.0)):
        exact = np.append(np.linspace(first, last, 41), [2 * np.pi * round(last / (2 * np.pi))])
        p = np.column_stack([np.cos(exact / 2), np.outer(np.sin(exact / 2), u)])
        p *= rng.choice([-1.0, 1.0], (len(p), 1))
        axes, angles = axes_and_angles(p)
        sense = np.sign(axes[0] @ u)
        assert_allclose(axes, np.tile(sense * u, (len(p), 1)), rtol=0.0, atol=1e-7)
        assert_allclose(angles, sense * exact, rtol=0.0, atol=1e-12)
        assert 0.0 <= angles[0] <= np.pi
    axes, angles = axes_and_angles(np.array([[1.0, 0, 0, 0], [-1.0, 0, 0, 0]]))
    assert np.array_equal(axes, [[0, 0, 1]] * 2)
    assert np.array_equal(angles, [0, 0])
    assert axes_and_angles(np.zeros((0, 4)))[0].shape == (0, 3)


def test_tables_have_rotations_and_plots_no_euler_parameters(result: Any) -> None:
    a = result.rotation("bob")
    assert_allclose(result["bob.Axz"], a[:, 0, 2], rtol=0.0, atol=0.0)
    rotation = result.data["rotation"].sel(body="bob")
    assert_allclose(rotation.sel(global_axis="z", body_axis="x"), a[:, 2, 0], atol=0.0)
    assert {"door.Axx", "bob.Azz", "bob.omega_y"} <= {*result.to_pandas().columns}
    pytest.importorskip("matplotlib")
    drawn = [line.get_label() for axis in result.plot().axes for line in axis.get_lines()]
    places, spins = ([f"{b}.{one}{c}" for b in MASSES for c in "xyz"] for one in ("", "omega_"))
    assert drawn == places + spins
    drawn = [line.get_label() for axis in result.plot("pin").axes for line in axis.get_lines()]
    assert drawn == ["pin.x", "pin.y", "pin.z"]


def test_kinetic_energy_is_that_of_omega(result: Any) -> None:
    expected = np.zeros(len(result.t))
    for body, (mass, moments) in MASSES.items():
        v = np.column_stack([result.v(f"{body}.v{c}") for c in "xyz"])
        w = np.column_stack([result.v(f"{body}.omega_{c}") for c in "xyz"])
        expected += 0.5 * mass * np.sum(v**2, axis=1) + 0.5 * w**2 @ np.array(moments)
    assert_allclose(result.energy("kinetic"), expected, rtol=1e-12)
    assert np.ptp(result.energy()) < 1e-8 * expected.max()
    fallen = sum(mass * 9.81 * result.q(f"{body}.z") for body, (mass, _) in MASSES.items())
    assert_allclose(result.energy("potential"), fallen, rtol=1e-12)


def test_comparisons_take_p_and_its_opposite_for_one() -> None:
    rng = np.random.default_rng(5)
    names = [*(f"bob.e{k}" for k in range(4)), *(f"bob.e{k}dot" for k in range(4))]
    names += ["a(bob.e1)", "bob.x", "cam.e0", "cam.e2"]
    by = [Scale(name, "1", "positions", 1.0) for name in names]
    reference = rng.normal(size=(7, len(names)))
    values = reference + 1e-6
    near = errors(values, reference, by).worst
    assert near < 1.1e-6
    signs = np.ones_like(values)
    signs[::2, :9] = signs[3:, 10:] = -1.0
    assert errors(signs * values, reference, by).worst == near
    signs[1, 9] = -1.0
    assert errors(signs * values, reference, by).worst > 0.1
    half = np.where([name == "bob.e2" for name in names], -values, values)  # not all of its p
    assert errors(half, reference, by).worst > 0.1


def test_a_gear_of_counted_angles_has_no_wrench(workshop: Path) -> None:
    model = Model("meshed", space=True)
    wheels = [model.body(f"w{k}", 1.0, (0.1, 0.1, 0.1), at=(k, 0, 0)) for k in (0, 1)]
    axles = [
        model.revolute(f"A{k}", model.ground, wheel, at=(k, 0, 0), axis=(0, 0, 1))
        for k, wheel in enumerate(wheels)
    ]
    model.gear("mesh", *axles, -2.0)
    model.torque("turn", wheels[0], (0, 0, 1.0))
    model.scene("run", ["turn"])
    run = load(model, folder=workshop).simulate(1.0, 2, progress=False)
    assert run.reaction("mesh", "torque")[0] == pytest.approx(-0.4)
    for on in ("ground", "w0"):
        with pytest.raises(InputError, match="'mesh' acts on coordinates of joints"):
            run.wrench("mesh", on)
    assert run.wrench("A0", "ground").shape == (2, 6)
