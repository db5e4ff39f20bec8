"""Starts by angular velocity, and series, tables and states of machines in space."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from codegen.errors import AssemblyError, InputError
from runtime import load
from tests.space.machines import DOWN, X, slider_crank
from tests.space.rotations import matrix_g, rotation


def swinging() -> Model:
    model = Model("swinging", space=True, gravity=DOWN)
    rod = model.body("rod", 2.0, (0.3, 0.5, 0.3), at=(0.1, 0.05, -0.5), axes=(0.2, -0.1, 0.3))
    model.spherical("O", model.ground.at(0, 0, 0), rod.at(0, 0, 0.5))
    model.track("foot", rod.at(0.1, 0, -0.5))
    start = {"rod.omega_x": 0.3, "rod.omega_z": 2.0}
    lifted = model.series("O.fz") + 2.0 * model.series("foot.az")
    asked = {"lifted": (lifted, "N"), "spin": sum(w**2 for w in rod.omega)}
    outputs = ["default", "points", "accelerations", "work(drag)", asked]
    model.torque("drag", rod, tuple(-0.1 * w for w in rod.omega), frame="body")
    model.scene("swing", effects=["gravity", "drag"], start=start, outputs=outputs)
    return model


@pytest.fixture(scope="module")
def machine(workshop: Path) -> Any:
    return load(swinging(), folder=workshop)


def test_a_start_may_give_some_components_of_omega(machine: Any) -> None:
    begin = machine.assemble()
    assert begin["rod.omega_x"] == pytest.approx(0.3, abs=1e-14)
    assert begin["rod.omega_z"] == pytest.approx(2.0, abs=1e-14)
    p, rates = begin.q[3:7], begin.v[3:7]
    assert_allclose(p @ p, 1.0, rtol=0.0, atol=1e-15)
    assert_allclose(p @ rates, 0.0, rtol=0.0, atol=1e-15)
    w = 2 * matrix_g(p) @ rates
    speed = rotation(p) @ np.cross(w, [0, 0, -0.5])  # of the centre, about the fixed point
    assert_allclose(begin.v[:3], speed, rtol=0.0, atol=1e-14)


def test_a_run_may_start_by_other_components(machine: Any) -> None:
    result = machine.simulate(0.1, 3, start={"rod.omega_z": "10 rpm"}, progress=False)
    assert result.v("rod.omega_z")[0] == pytest.approx(np.pi / 3, rel=1e-14)
    assert result.v("rod.omega_x")[0] == pytest.approx(0.3, rel=1e-12)
    assert "start sets rod.omega_z = 1.0472 rad/s" in result.message


def test_an_ensemble_starts_as_single_runs_do(machine: Any) -> None:
    values = np.array([0.3, 0.4])
    many = machine.ensemble(0.5, 6, starts={"rod.omega_x": values}, progress=False)
    for k, value in enumerate(values):
        alone = machine.simulate(0.5, 6, start={"rod.omega_x": value}, progress=False)
        assert np.array_equal(many["q"].values[k], alone.samples.q)
        assert_allclose(many["spin"].values[k, 0, 0], value, rtol=1e-14)


def test_a_start_that_a_joint_does_not_allow_is_refused(workshop: Path) -> None:
    crank = load(slider_crank(False), folder=workshop)
    with pytest.raises(AssemblyError) as refusal:
        crank.assemble(start={"crank.omega_y": 1.0})
    text = str(refusal.value)
    assert "slider_crank_2/run: angular velocities contradict the joints" in text
    assert "crank.omega_y = 1 rad/s, where" in text


def test_names_of_starts(machine: Any) -> None:
    with pytest.raises(AssemblyError, match=r"guess names rod\.omega_x, an angular velocity"):
        machine.assemble(guess={"rod.omega_x": 1.0})
    with pytest.raises(AssemblyError, match=r"no coordinate or velocity 'rod\.omega_w'"):
        machine.assemble(start={"rod.omega_w": 1.0})


def test_series_and_tables(machine: Any) -> None:
    result = machine.simulate(1.0, 11, rtol=1e-10, progress=False)
    w = np.column_stack([result[f"rod.omega_{c}"] for c in "xyz"])
    turned = result.rotation("rod")
    assert_allclose(turned @ turned.transpose(0, 2, 1), [np.eye(3)] * 11, rtol=0.0, atol=1e-13)
    place = np.column_stack([result.q(f"rod.{c}") for c in "xyz"])
    foot = place + turned @ [0.1, 0.0, -0.5]
    assert_allclose(result.point("foot"), foot, rtol=0.0, atol=1e-14)
    speed = [result.v(f"rod.v{c}") for c in "xyz"]
    moved = np.array(speed).T + np.einsum("kij,kj->ki", turned, np.cross(w, [0.1, 0.0, -0.5]))
    found = np.column_stack([result.point("foot", f"v{c}") for c in "xyz"])
    assert_allclose(found, moved, rtol=0.0, atol=1e-12)
    turning = np.column_stack([result.a(f"rod.e{k}") for k in range(4)])
    p = np.column_stack([result.q(f"rod.e{k}") for k in range(4)])
    alpha = [2 * matrix_g(one) @ two for one, two in zip(p, turning, strict=True)]
    arm = np.array([0.1, 0.0, -0.5])
    bent = np.cross(alpha, arm) + np.cross(w, np.cross(w, arm))  # in body axes
    pushed = np.column_stack([result.a(f"rod.{c}") for c in "xyz"])
    pushed += np.einsum("kij,kj->ki", turned, bent)
    found = np.column_stack([result.point("foot", f"a{c}") for c in "xyz"])
    assert_allclose(found, pushed, rtol=0.0, atol=1e-11)
    assert_allclose(result["lifted"], result.reaction("O", "fz") + 2 * pushed[:, 2], atol=1e-10)
    assert_allclose(result["spin"], np.sum(w**2, axis=1), rtol=1e-13)
    data = result.data
    assert data["point_acceleration"].shape == (11, 1, 3)
    assert data["spin"].sel(spin_component="rod.omega_z").attrs["units"] == "rad/s"
    assert data["point"].shape == (11, 1, 3)
    assert {"rod.omega_x", "foot.z", "O.tz"} <= {*result.to_pandas().columns}
    assert result.state(0.5)["rod.omega_x"] == pytest.approx(w[5, 0], rel=1e-12)
    lost = result.work("drag") - (result.energy() - result.energy()[0])
    assert_allclose(lost, 0.0, rtol=0.0, atol=1e-8)
    assert_allclose(result.power("drag"), -0.1 * np.sum(w**2, axis=1), rtol=1e-12)
    with pytest.raises(InputError, match="'crank' is no body in space, which are rod"):
        result.rotation("crank")


def test_reduced_coordinates_and_implicit_methods_agree(machine: Any) -> None:
    plain = machine.simulate(1.0, 11, rtol=1e-10, progress=False)
    for words in ({"formulation": "reduced"}, {"method": "radau5"}, {"method": "bdf"}):
        other = machine.simulate(1.0, 11, rtol=1e-10, progress=False, **words)
        assert_allclose(other.samples.q, plain.samples.q, rtol=0.0, atol=1e-7)


def test_a_driven_slider_crank_in_kinematics_and_inverse_dynamics(workshop: Path) -> None:
    """With its slider driven: closed forms of the distance, and the balance of power."""
    from codegen import t

    model = slider_crank(False)
    slider = model.bodies["slider"]
    model.driver("push", slider.x, 0.23 + 0.01 * t)  # type: ignore[attr-defined]
    model.scene("driven", effects=["gravity"], drivers=["push"])
    machine = load(model, "driven", folder=workshop)
    moved = machine.kinematics(1.0, 11, progress=False)
    turned = moved.rotation("crank") @ [0, 0.08, 0] + [0, 0.1, 0.12]
    gap = np.linalg.norm(turned - np.outer(moved.q("slider.x"), X), axis=1)
    assert_allclose(gap, 0.3, rtol=0.0, atol=1e-12)
    forces = machine.inverse_dynamics(1.0, 11, progress=False)
    rate = forces.power("push")
    exact = np.gradient(forces.energy(), forces.t, edge_order=2)
    assert_allclose(rate[1:-1], exact[1:-1], rtol=0.0, atol=2e-3 * np.abs(rate).max())


def start_error(machine: Any, **start: float) -> str:
    with pytest.raises(AssemblyError) as refusal:
        machine.assemble(start={f"rod.{name}": value for name, value in start.items()})
    return str(refusal.value)


def test_a_velocity_that_a_hinge_forbids_is_refused(workshop: Path) -> None:
    """The coefficient of the rate that would have to bring it is rounding."""
    model = Model("forbidden", space=True)
    attitude = (0.3, -0.2, 0.5)
    rod = model.body("rod", 1.0, (0.1, 0.2, 0.25), at=(0.5, 0, 0), axes=attitude)
    model.revolute("R", model.ground, rod, at=(0, 0, 0), axis=(1, 1, 1))
    model.scene("s")
    machine = load(model, folder=workshop)
    text = start_error(machine, vx=1.0)
    assert "the fixed start velocities contradict the joints. Start says rod.vx = 1 m/s" in text
    assert "joint R misses by 1 m/s" in text
    assert "draw" not in text
    omega = np.array(machine.assemble(start={"rod.vz": 1.0}).v[3:7])
    assert np.linalg.norm(2 * omega) == pytest.approx(2 * np.sqrt(3))  # v_z = -0.5 ω / √3


def test_start_values_that_cannot_be_are_named(machine: Any) -> None:
    text = start_error(machine, e0=0.8, e1=0.8)
    assert "the Euler parameters e0 to e3 of 'rod' must have the length 1" in text
    assert text.endswith("those that the start fixes have 1.13137.")
    assert "fixes have 0.5." in start_error(machine, e0=0.5, e1=0.0, e2=0.0, e3=0.0)
    text = start_error(machine, omega_x=float("nan"))
    assert "Start value rod.omega_x is nan; it must be a finite number." in text


def test_a_spin_that_is_not_met_is_named_alone(workshop: Path) -> None:
    model = Model("spun", space=True)
    rod = model.body("rod", 1.0, (0.1, 0.2, 0.25), at=(0.5, 0, 0))
    model.spherical("S", model.ground, rod, at=(0, 0, 0))
    model.scene("s")
    text = start_error(load(model, folder=workshop), omega_x=1.0, omega_z=2.0, vy=0.0)
    assert "rod.omega_z = 2 rad/s, where" in text
    assert "omega_x" not in text
    assert "fixed are rod.vy = 0 m/s" in text


def pair(*outputs: str) -> Model:
    """Two bodies in a row by hinges that are not parallel."""
    model = Model(f"pair_{len(outputs)}", space=True, gravity=DOWN)
    first = model.body("b", 1.0, (0.1, 0.2, 0.25), at=(0.5, 0, 0), axes=(0.2, 0.1, -0.3))
    second = model.body("c", 1.0, (0.1, 0.2, 0.25), at=(1, 0.5, 0), axes=(0.4, 0, 0))
    model.revolute("A", model.ground, first, at=(0, 0, 0), axis=(1, 1, 1))
    model.revolute("B", first, second, at=(1, 0, 0), axis=(0, 1, 2))
    model.scene("s", ["gravity"], outputs=["default", *outputs])
    return model


@pytest.mark.parametrize(
    ("start", "guess"),
    [
        ({"b.vz": 1.0}, {}),
        ({}, {"c.vx": 0.3, "c.vy": -2.0}),
        ({"c.omega_z": 2.0}, {"b.vz": 0.5}),
        ({}, {"b.e1": 0.2, "b.vz": 1.0}),
    ],
)
def test_a_start_does_not_depend_on_what_joints_count(
    start: dict[str, float], guess: dict[str, float], workshop: Path
) -> None:
    """Rates and angles that nobody gives follow from the bodies, and pull none of them."""
    plain, counting = (load(pair(*names), folder=workshop) for names in ((), ("A.angle", "B.rate")))
    q, v = (getattr(plain.assemble(start=start, guess=guess), x) for x in "qv")
    found = counting.assemble(start=start, guess=guess)
    near = 1e-5 if "b.e1" in guess else 1e-9  # which ends a minimisation
    assert_allclose(found.q[:14], q, rtol=0.0, atol=near)
    assert_allclose(found.v[:14], v, rtol=0.0, atol=near)
    axis = rotation(found.q[3:7]) @ (2.0 * matrix_g(found.q[3:7]) @ found.v[3:7])
    assert found["A.rate"] == pytest.approx(axis.sum() / np.sqrt(3), abs=1e-9)
    assert np.abs(v).max() > 0.1


def test_an_angle_that_nobody_gives_is_within_half_a_turn(workshop: Path) -> None:
    model = Model("turned_hinges", space=True)
    first = model.body("b", 1.0, (0.1, 0.2, 0.25), at=(0.5, 0, 0))
    second = model.body("c", 1.0, (0.1, 0.2, 0.25), at=(1.5, 0, 0))
    model.revolute("A", model.ground, first, at=(0, 0, 0), axis=(0, 0, 1))
    model.cylindrical("B", first, second, at=(1, 0, 0), axis=(0, 0, 1))
    model.scene("s", outputs=["default", "A.angle", "B.angle", "B.slide"])
    machine, angles = load(model, folder=workshop), (-3.1, -2.0, 0.3, 2.7, 3.1)
    half = 0.5 * np.array([[a, a + b] for a in angles for b in (-3.0, 0.0, 2.9)])
    starts = {
        "b.e0": np.cos(half[:, 0]), "b.e3": np.sin(half[:, 0]),
        "c.e0": np.cos(half[:, 1]), "c.e3": np.sin(half[:, 1]),
    }  # fmt: skip
    many = machine.ensemble(0.1, 2, starts=starts, progress=False)
    for k, (a, b) in enumerate(half):
        begin = machine.assemble(start={name: float(x[k]) for name, x in starts.items()})
        exact = [2 * a, 2 * (b - a), 0.0]
        assert_allclose(begin.q[14:], exact, rtol=0.0, atol=1e-9)
        assert_allclose(many["q"].values[k, 0, 14:], exact, rtol=0.0, atol=1e-9)


def test_words_of_a_start(workshop: Path) -> None:
    """Numbers without a unit, rounding, and bodies that turn since an angle is set."""
    machine = load(pair("A.angle", "B.rate"), folder=workshop)
    with pytest.raises(AssemblyError, match=r"Start says b\.e0 = 1, b\.e1 = 0, A\.angle = 1 rad;"):
        machine.assemble(start={"A.angle": 1.0, "b.e0": 1.0, "b.e1": 0.0})
    begin, drawn = machine.assemble(start={"A.angle": 2.0}), machine.assemble()
    assert abs(begin.q[3:7] @ drawn.q[3:7]) < np.cos(0.25 * np.pi)  # by more than a right angle
    assert "turns by more" not in begin.note
    text = repr(machine.assemble(start={"b.e1": 0.3}))
    assert "b.e1 = 0.3, " in text
    assert "b.e0 moved from" in text
    assert "A.angle moved" not in text
    run = machine.simulate(0.1, 2, guess={"b.e1": 0.3}, start={"A.angle": 0.0}, progress=False)
    assert "guess b.e1 = 0.3 became 0.099" in run.message
    assert " 1:" not in run.message
