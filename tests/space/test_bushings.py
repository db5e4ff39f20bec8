"""Bushings in space by closed forms, dense equations, and what is wrong with their numbers."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from codegen import Model, t
from codegen.driver import build
from codegen.errors import ModelError
from runtime import load
from tests.codegen.workbench import Interpreted, State
from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_dynamics import SpatialDense
from tests.random_mechanisms.spatial_generator import RandomSpatialMechanism
from tests.random_mechanisms.spatial_loops import rows
from tests.random_mechanisms.spatial_statics import MET, Statics
from tests.space.dense_machines import principal

RANDOM = np.random.default_rng(5)


def coupled(size: float) -> Any:
    """A symmetric positive matrix with all its entries."""
    root = size * RANDOM.normal(size=(6, 6))
    return tuple(map(tuple, (root @ root.T).tolist()))


@pytest.fixture(scope="module")
def free_pair() -> tuple[Statics, SpatialDense]:
    """Two free bodies, oblique at the drawing, on a bushing each."""
    turns = Rotation.random(3, random_state=6).as_matrix()
    bodies = (
        parts.SpatialBody("a", 1.5, principal(0.3, 0.2, 0.25), (0.3, 0.1, 0.2), rows(turns[0])),
        parts.SpatialBody("b", 0.7, principal(0.1, 0.2, 0.15), (0.9, 0.5, 0.1), rows(turns[1])),
    )
    preload = tuple(RANDOM.normal(size=6).tolist())
    at, axes = (0.6, 0.4, 0.0), rows(turns[2])
    effects = (
        parts.Bushing("s", 0, 1, at, axes, coupled(2.0), coupled(0.3), preload),
        parts.Bushing("g", parts.GROUND, 0, at, axes, coupled(2.0), coupled(0.3), preload),
    )
    mechanism = parts.SpatialMechanism(bodies, (), effects)
    dense = SpatialDense(mechanism)
    machine = RandomSpatialMechanism(
        0, "bushings", "free", (), mechanism, dense.at_drawing, 12, 0, 0.1
    )
    return Statics(machine), dense


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 0.5, 2.0, 3.1])
def test_forces_and_torques_at_all_angles_are_those_of_rotation_vectors(
    free_pair: tuple[Statics, SpatialDense], angle: float
) -> None:
    """By the tangent of the rotation vector, which the library does not have."""
    statics, dense = free_pair
    state, axes = dense.at_drawing, Rotation.random(2, random_state=7).apply([1.0, 0.0, 0.0])
    turned = Rotation.from_rotvec(angle * axes[0]).as_matrix() @ state.R
    turned[1] = Rotation.from_rotvec(angle * axes[1]).as_matrix() @ state.R[1]
    r, v, w = 0.3 * RANDOM.normal(size=(3, 2, 3))
    place = replace(state, r=state.r + r * (angle > 0), R=turned, v=v, w=w)
    assert statics.difference(place, 0.0) < MET


STIFFNESS, ABOUT, MASS = 8.0, 0.05, 2.0


@pytest.fixture(scope="module")
def swinging(workshop: Path) -> Any:
    """A body on a bushing whose axes are its own, oblique in the ground."""
    model: Any = Model("swinging", space=True)
    c = model.parameter("c", 0.0, "N m s/rad")
    body = model.body("body", MASS, (0.02, 0.03, ABOUT), at=(1, 2, 3), axes=(0.3, -0.5, 0.7))
    stiffness = (50.0, 200.0, 800.0, 3.0, 5.0, STIFFNESS)
    model.bushing(
        "rubber", model.ground, body, stiffness, (0, 0, 0, 0, 0, c), at=(1, 2, 3),
        axes=(0.3, -0.5, 0.7),
    )  # fmt: skip
    whole = ["deflection(rubber)", "rate(rubber)", "force(rubber)", "torque(rubber)", "energy"]
    model.scene("swing", ["rubber"], outputs=whole)
    return load(model, folder=workshop)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_a_body_turns_to_and_fro_through_nearly_half_a_turn(
    swinging: Any, method: str, damping: float
) -> None:
    """About a principal axis the torque is k χ: a harmonic motion with an amplitude of 160°."""
    frame = Rotation.from_rotvec([0.3, -0.5, 0.7])
    begin = np.radians(160.0)
    p = (frame * Rotation.from_rotvec([0, 0, begin])).as_quat()[[3, 0, 1, 2]]
    start = {f"body.e{k}": float(-e) for k, e in enumerate(p)}  # -p is the same attitude
    start |= {"body.vx": 0.0, "body.omega_z": 0.0}
    result = swinging.simulate(
        2.0, 81, parameters={"c": damping}, start=start, method=method, rtol=1e-10, progress=False
    )
    decay = damping / (2 * ABOUT)
    w = np.sqrt(STIFFNESS / ABOUT - decay**2)
    swing = np.exp(-decay * result.t)
    swing *= begin * (np.cos(w * result.t) + decay / w * np.sin(w * result.t))
    assert_allclose(result["rubber.deflection.rz"], swing, rtol=0.0, atol=1e-7)
    exact = -STIFFNESS * swing - damping * result["rubber.rate.rz"]
    assert_allclose(result["rubber.tz"], exact, rtol=0.0, atol=1e-6)
    assert_allclose(result["rubber.rate.rz"], result["body.omega_z"], rtol=0.0, atol=1e-7)
    if not damping:
        assert_allclose(result.energy(), STIFFNESS * begin**2 / 2, rtol=1e-8)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_body_swings_back_from_half_a_turn(workshop: Path, method: str, side: float) -> None:
    """There the rotation vector has two directions; the Euler parameters say which one counts."""
    model: Any = Model("half_turn", space=True)
    body = model.body("body", MASS, (0.02, 0.03, ABOUT))
    model.bushing("rubber", model.ground, body, (1, 1, 1, 3.0, 5.0, STIFFNESS))
    model.scene("swing", ["rubber"], outputs=["deflection(rubber)", "torque(rubber)", "energy"])
    machine = load(model, folder=workshop)
    p = {f"body.e{k}": e for k, e in enumerate((0.0, 0.0, 0.0, side))}
    result = machine.simulate(
        1.0, 41, start=p | {"body.omega_z": 0.0}, method=method, rtol=1e-10, progress=False
    )
    assert result.outcome.name == "OK"
    swing = side * np.pi * np.cos(np.sqrt(STIFFNESS / ABOUT) * result.t)
    assert_allclose(result["rubber.deflection.rz"], swing, rtol=0.0, atol=1e-7)
    assert_allclose(result["rubber.tz"], -STIFFNESS * swing, rtol=0.0, atol=1e-6)
    assert_allclose(result.energy(), STIFFNESS * np.pi**2 / 2, rtol=1e-8)


def test_a_run_may_end_before_half_a_turn(swinging: Any) -> None:
    """Beyond it the deflection has the opposite sign; no event says so."""
    fast = {"start": {"body.omega_z": 60.0, "body.vx": 0.0}, "progress": False}
    deflection = swinging.simulate(0.1, 101, **fast)["rubber.deflection.rz"]
    assert np.abs(np.diff(deflection)).max() > 6.0
    until = {"half turn": ("rubber.deflection.rz", ">", 3.1)}
    ended = swinging.simulate(0.1, 101, until=until, **fast)
    assert ended.ended_by == "half turn"
    assert ended["rubber.deflection.rz"][-1] == pytest.approx(3.1, abs=1e-6)


def test_a_body_that_tumbles_on_a_bushing_keeps_its_energy(swinging: Any) -> None:
    """About a changing axis, by large angles; along the axes it swings with √(k/m)."""
    start = {"body.vx": 0.3, "body.omega_x": 9.0, "body.omega_y": -9.0, "body.omega_z": 4.0}
    result = swinging.simulate(3.0, 61, start=start, rtol=1e-11, progress=False)
    assert_allclose(result.energy(), result.energy()[0], rtol=1e-9)
    angle = np.linalg.norm([result[f"rubber.deflection.r{c}"] for c in "xyz"], axis=0)
    assert 1.0 < angle.max() < np.pi
    inner = Rotation.from_rotvec([0.3, -0.5, 0.7]).as_matrix().T @ [0.3, 0, 0]
    for c, k, v in zip("xyz", (50.0, 200.0, 800.0), inner, strict=True):
        w = np.sqrt(k / MASS)
        exact = v / w * np.sin(w * result.t)
        assert_allclose(result[f"rubber.deflection.{c}"], exact, rtol=0.0, atol=1e-9)
        assert_allclose(result[f"rubber.f{c}"], -k * exact, rtol=0.0, atol=1e-7)


def test_springs_that_vary_exert_what_constant_ones_would() -> None:
    def forces(stiffness: Any, preload: Any) -> Any:
        model: Any = Model("varying", space=True)
        a, b = (model.body(n, 1.0, (1, 1, 1), at=(0.2, k, 0)) for k, n in enumerate("ab"))
        model.bushing("s", a, b, stiffness, preload=preload, at=(0, 0, 0), axes=(0.1, 0.2, 0.3))
        model.scene("run", ["s"])
        machine = Interpreted(model)
        random = np.random.default_rng(2)
        q, v = random.normal(size=(2, 14))
        for first in (3, 10):
            q[first : first + 4] /= np.linalg.norm(q[first : first + 4])
        return machine.vector("applied_forces", State(t=0.5, q=q, v=v))

    stiffness, preload = np.array(coupled(2.0)), np.arange(1.0, 7.0)
    varying = forces((2 * t * stiffness).tolist(), [2 * t * x for x in preload])
    assert_allclose(varying, forces(stiffness, preload), rtol=1e-12)


def pair() -> Any:
    model: Any = Model("pair", space=True)
    for k, name in enumerate("ab"):
        model.body(name, 1.0, (1, 1, 1), at=(k, 0, 0))
    return model


SKEW = np.eye(6) + np.diag([1.0] * 5, 1)
MISTAKES: dict[str, tuple[Callable[[Any, Any, Any], Any], str]] = {
    "three numbers": (
        lambda m, a, b: m.bushing("B", a, b, (1, 2, 3), at=(0, 0, 0)),
        ("stiffness of bushing 'B' is (1, 2, 3); give six numbers, along x, y, z and about them, "
        "or a symmetric matrix, 6 x 6."),
    ),
    "one number": (
        lambda m, a, b: m.bushing("B", a, b, 5.0, at=(0, 0, 0)),
        "stiffness of bushing 'B' is 5.0; give six numbers, along x, y, z and about them, or a",
    ),
    "skew": (
        lambda m, a, b: m.bushing("B", a, b, (1,) * 6, SKEW, at=(0, 0, 0)),
        "damping of bushing 'B' is not symmetric; give a symmetric matrix, as (K + K.T) / 2.",
    ),
    "negative": (
        lambda m, a, b: m.bushing("B", a, b, (1, 1, 1, 1, -2, 1), at=(0, 0, 0)),
        ("bushing in space 'B': the stiffness along ry is -2 N m/rad; give a number that is not "
        "negative."),
    ),
    "indefinite": (
        lambda m, a, b: m.bushing("B", a, b, np.eye(6) + 2.0 * (np.ones((6, 6)) - np.eye(6))),
        ("stiffness of bushing 'B' has the eigenvalue -1, in SI units; with a negative one it "
        "drives the bodies. Check the signs and sizes of its entries that couple."),
    ),
    "unit": (
        lambda m, a, b: m.bushing("B", a, b, ("5 N/mm", 1, 1, "3 N/mm", 1, 1), at=(0, 0, 0)),
        "stiffness of bushing 'B': 3 newton / millimeter has the dimension",
    ),
    "nothing": (
        lambda m, a, b: m.bushing("B", a, b, at=(0, 0, 0)),
        "bushing in space 'B': stiffness and damping are all 0; give at least one.",
    ),
    "itself": (
        lambda m, a, b: m.bushing("B", a, a, (1,) * 6, at=(0, 0, 0)),
        "bushing in space 'B' is between body 'a' and itself; give two.",
    ),
    "damping that varies": (
        lambda m, a, b: m.bushing("B", a, b, damping=(t * np.array(coupled(1.0))).tolist()),
        ("bushing in space 'B': its damping varies and couples displacements; give a matrix of "
        "numbers and parameters, or six expressions."),
    ),
    "axes": (
        lambda m, a, b: m.bushing("B", a, b, (1,) * 6, at=(0, 0, 0), axes=(1, 2)),
        "bushing 'B': axes is (1, 2); give two axes that are not parallel, a rotation vector",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", MISTAKES)
def test_mistakes_are_told(case: str, tmp_path: Path) -> None:
    mistake, text = MISTAKES[case]
    model = pair()
    mistake(model, *model.bodies.values())
    model.scene("s", [*model.effects])
    with pytest.raises(ModelError) as refusal:
        build(model, out=tmp_path, compile=False)
    assert text in str(refusal.value)
