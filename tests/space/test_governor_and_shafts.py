"""The flyball governor beside references; shafts with a universal joint beside the closed form."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from models.space.universal_joint import universal_joint
from runtime import load
from runtime.core.outcomes import Outcome
from tests.random_mechanisms.spatial_dynamics import SpatialDense
from tests.random_mechanisms.spatial_motion import motion
from tests.space import dense_machines
from tests.space.closed_forms import universal_joint_angle, universal_joint_ratio

RATIOS = (0.5, 1.2)  # bends of shafts, rad


@pytest.fixture(scope="module")
def flyballs() -> Any:
    return load("space/flyball_governor")


def turning(speed: float) -> Any:
    """The governor at its drawing, turning as one body about z."""
    at = SpatialDense(dense_machines.flyball_governor()).at_drawing
    w = np.tile([0.0, 0.0, speed], (len(at.r), 1))
    return replace(at, v=np.cross(w, at.r), w=w)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["bdf", "radau5", "dop853"])
def test_the_flyball_governor_moves_as_its_reference(
    method: str, flyballs: Any, root: Path
) -> None:
    rows = np.genfromtxt(root / "tests/data/flyball_governor.csv", delimiter=",", names=True)
    run = flyballs.simulate(
        rows["t"][-1], rows["t"], rtol=1e-8, method=method,
        progress=False,
    )  # fmt: skip
    assert run.outcome is Outcome.OK
    assert_allclose(run.q("slider.z"), rows["s"], rtol=0.0, atol=1e-7)
    for rod in ("rod1", "rod2"):
        tilt = -np.arcsin(run.rotation(rod)[:, 2, 0])
        assert_allclose(tilt, rows["alpha"], rtol=0.0, atol=1e-6)
    assert_allclose(run.v("shaft.omega_z"), rows["omega"], rtol=0.0, atol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [3.0, 12.0])
def test_the_flyball_governor_moves_at_other_speeds_as_the_dense_equations_say(
    speed: float, flyballs: Any
) -> None:
    instants = np.linspace(0.0, 0.02, 3)
    dense = SpatialDense(dense_machines.flyball_governor())
    exact = motion(dense, turning(speed), instants.tolist(), 1e-12)
    for method in ("bdf", "radau5"):
        run = flyballs.simulate(
            instants[-1], instants, start={"shaft.omega_z": speed}, rtol=1e-8, method=method,
            progress=False,
        )  # fmt: skip
        height = [state.r[1, 2] for state in exact]
        assert_allclose(run.q("slider.z"), height, rtol=0.0, atol=1e-7)
        spin = [state.w[0, 2] for state in exact]
        assert_allclose(run.v("shaft.omega_z"), spin, rtol=0.0, atol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "rtol"), [(3.0, 1e-8), (4.5, 1e-8), (9.0, 5e-9), (12.0, 1e-8)])
def test_implicit_methods_follow_the_governor_for_ten_seconds_at_other_speeds(
    speed: float, rtol: float, flyballs: Any
) -> None:
    """Turning fast, it swings by most of its height, and errors grow as the square of time."""
    words = {"start": {"shaft.omega_z": speed}, "progress": False}
    exact = flyballs.simulate(10.0, 501, rtol=1e-12, atol=1e-13, method="dop853", **words)
    for method in ("bdf", "radau5"):
        run = flyballs.simulate(10.0, 501, rtol=rtol, method=method, **words)
        assert run.outcome is Outcome.OK
        assert run.stats["repartitions"] == 0  # the angle of the bearing is independent
        assert_allclose(run.q("slider.z"), exact.q("slider.z"), rtol=0.0, atol=1e-7)
        spin = exact.v("shaft.omega_z")
        assert_allclose(run.v("shaft.omega_z"), spin, rtol=0.0, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [9.0, 15.0])
def test_an_accuracy_target_holds_where_tolerances_do_not(speed: float, flyballs: Any) -> None:
    words = {"start": {"shaft.omega_z": speed}, "progress": False}
    exact = flyballs.simulate(10.0, 501, rtol=1e-12, atol=1e-13, method="dop853", **words)
    run = flyballs.simulate(
        10.0, 501, accuracy=1e-7, quantities=("slider.z",), method="bdf", **words
    )
    off = np.abs(run.q("slider.z") - exact.q("slider.z")).max()
    assert off < 1e-7
    assert 0.1 * off < run.accuracy.estimated < 1e-7


@pytest.mark.parametrize("bend", RATIOS)
def test_the_second_shaft_turns_at_the_ratio_of_the_universal_joint(
    bend: float, workshop: Path
) -> None:
    """ω₂/ω₁ = cos β/(1 - sin² β cos² θ) along two turns; three rows follow from others."""
    machine = load(universal_joint(bend), "driven", folder=workshop)
    run = machine.kinematics(2 * np.pi, 201, progress=False)
    assert run.outcome is Outcome.OK
    ratio = [universal_joint_ratio(2 * time, bend) for time in run.t]
    about = run.rotation("second").transpose(0, 2, 1) @ [np.cos(bend), np.sin(bend), 0.0]
    spin = np.column_stack([run.v(f"second.omega_{c}") for c in "xyz"])
    speed = np.sum(spin * about, axis=1)
    assert_allclose(run.v("first.omega_x"), 2.0, rtol=1e-12)
    assert_allclose(speed / 2.0, ratio, rtol=1e-12)
    assert_allclose(spin, speed[:, None] * about, rtol=0.0, atol=1e-11)
    assert np.ptp(ratio) > 0.2  # it is no uniform motion
    arm = run.rotation("second")[:, :, 2]  # along z at the drawing
    angle = np.array([universal_joint_angle(2 * time, bend) for time in run.t])
    along, up = np.array([np.cos(bend), np.sin(bend), 0.0]), np.array([0.0, 0.0, 1.0])
    away = np.cross(along, up)
    assert_allclose(
        arm, np.outer(np.cos(angle), up) + np.outer(np.sin(angle), away), rtol=0.0, atol=1e-11
    )


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_free_shafts_keep_the_ratio_and_their_energy(method: str, workshop: Path) -> None:
    """½ (J₁ + J₂ i²) ω₁² stays, with the ratio i of the universal joint at the angle reached."""
    bend = RATIOS[0]
    machine = load(universal_joint(bend), "free", folder=workshop)
    run = machine.simulate(3.0, 61, rtol=1e-11, method=method, progress=False)
    assert run.outcome is Outcome.OK
    A = run.rotation("first")
    angle = np.unwrap(np.arctan2(A[:, 2, 1], A[:, 1, 1]))
    ratio = np.array([universal_joint_ratio(one, bend) for one in angle])
    spin = np.column_stack([run.v(f"second.omega_{c}") for c in "xyz"])
    first = run.v("first.omega_x")
    assert_allclose(np.linalg.norm(spin, axis=1), ratio * first, rtol=1e-10)
    along = run.rotation("second")[0].T @ [np.cos(bend), np.sin(bend), 0.0]
    second = float(along @ np.diag([0.3, 0.2, 0.1]) @ along)
    energy = (0.1 + second * ratio**2) * first**2
    assert_allclose(energy, energy[0], rtol=1e-8)
    assert np.ptp(first) > 0.05 * first[0]
