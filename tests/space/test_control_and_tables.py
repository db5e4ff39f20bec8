"""States, sampled values, tables and laws in pieces in space, against equations written by hand."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation
from sympy import Piecewise

from codegen import Model, t
from runtime import load
from tests.space.machines import DOWN
from tests.space.rotations import matrix_g, rotation

MASS, MOMENTS, ARM = 2.0, np.array([0.3, 0.5, 0.4]), np.array([0.0, 0.0, -0.5])
HEIGHTS, TORQUES = (-0.6, -0.45, -0.4, -0.2, 1.0), (0.5, 0.2, -0.9, 0.6, 0.0)
PERIOD, DELAY, DRAWN = 0.05, 0.02, (0.2, -0.1, 0.3)
SPIN = (0.5, 1.0, 2.0)


def controlled() -> Model:
    model = Model("controlled", space=True, gravity=DOWN)
    at = tuple((Rotation.from_rotvec(DRAWN).as_matrix() @ ARM).tolist())
    rod = model.body("rod", MASS, tuple(MOMENTS), at=at, axes=DRAWN)
    model.spherical("O", model.ground, rod, at=(0, 0, 0))
    slow = model.state("slow", lambda y: (rod.omega_z - y) / 0.1, unit="rad/s")
    u = model.sampled(
        "u", PERIOD, -0.8 * rod.omega_x - 2 * rod.x, delay=DELAY, start=0.1, unit="N m"
    )
    law = model.table("law", HEIGHTS, TORQUES, units=("m", "N m"))
    model.torque("drive", rod, (u, law(rod.z), -0.5 * slow), frame="body")
    push = Piecewise((30 * (rod.x - 0.05), rod.x > 0.05), (0, True))
    model.force("stop", rod, (-push, 0, 0))
    model.scene(
        "run", ["gravity", "drive", "stop"],
        start={f"rod.omega_{c}": w for c, w in zip("xyz", SPIN, strict=True)},
    )  # fmt: skip
    return model


def by_hand(t: Any) -> tuple[Any, Any, Any]:
    """Rotation matrices, ω' and the state `slow` at instants, by Euler's equations about O."""
    about = np.diag(MOMENTS) + MASS * 0.25 * np.diag([1.0, 1.0, 0.0])
    law = PchipInterpolator(HEIGHTS, TORQUES)

    def rates(_: float, y: Any, u: float) -> Any:
        p, w, slow = y[:4], y[4:7], y[7]
        turned = rotation(p)
        place = turned @ ARM
        push = 30.0 * max(place[0] - 0.05, 0.0)
        pushed = np.cross(ARM, turned.T @ [-push, 0.0, -9.81 * MASS])
        torque = pushed + np.array([u, law(place[2]), -0.5 * slow])
        turning = np.linalg.solve(about, torque - np.cross(w, about @ w))
        return np.concatenate([0.5 * matrix_g(p).T @ w, turning, [(w[2] - slow) / 0.1]])

    x, y, z, w = Rotation.from_rotvec(DRAWN).as_quat()
    state, found, u, waiting = np.array([w, x, y, z, *SPIN, 0.0]), [], 0.1, 0.1
    edges = np.unique(np.round([*np.arange(0, t[-1], PERIOD), *np.arange(DELAY, t[-1], PERIOD),
                                *t], 12))  # fmt: skip
    for k, begin in enumerate(edges):
        if np.isclose(begin % PERIOD, DELAY, atol=1e-9):
            u = waiting
        if np.isclose((begin + 1e-10) % PERIOD, 0.0, atol=1e-9):
            waiting = -0.8 * state[4] - 2.0 * (rotation(state[:4]) @ ARM)[0]
        if np.isclose(t, begin, atol=1e-10).any():
            found.append(state.copy())
        if k + 1 < len(edges):
            state = solve_ivp(rates, (begin, edges[k + 1]), state, args=(u,), rtol=1e-11,
                              atol=1e-12, method="DOP853", max_step=2e-3).y[:, -1]  # fmt: skip
    history = np.array(found)
    return np.array([rotation(p) for p in history[:, :4]]), history[:, 4:7], history[:, 7]


@pytest.fixture(scope="module")
def machine(workshop: Path) -> Any:
    return load(controlled(), folder=workshop)


@pytest.fixture(scope="module")
def exact() -> Any:
    return by_hand(np.linspace(0.0, 1.2, 5))


@pytest.mark.parametrize("words", [{}, {"method": "radau5"}, {"formulation": "reduced"}], ids=str)
def test_a_controlled_rod_moves_as_by_hand(words: Any, machine: Any, exact: Any) -> None:
    result = machine.simulate(1.2, 5, rtol=1e-11, progress=False, **words)
    turned, w, slow = exact
    assert len({*np.sign(result.q("rod.x") - 0.05)}) == 2  # the stop acts, and does not
    assert_allclose(result.rotation("rod"), turned, rtol=0.0, atol=2e-9)
    found = np.column_stack([result[f"rod.omega_{c}"] for c in "xyz"])
    assert_allclose(found, w, rtol=0.0, atol=1e-8)
    assert_allclose(result.y("slow"), slow, rtol=0.0, atol=1e-8)


def test_a_run_goes_on_from_a_state_with_its_samples(machine: Any) -> None:
    t = np.linspace(0.0, 1.2, 13)
    whole = machine.simulate(1.2, t, rtol=1e-11, progress=False)
    rest = machine.simulate(
        1.2, t[5:], t_start=t[5], start=whole.state(t[5]), rtol=1e-11, progress=False
    )
    assert_allclose(rest.samples.q, whole.samples.q[5:], rtol=0.0, atol=1e-9)


def test_forces_and_torques_act_while_a_condition_holds(workshop: Path) -> None:
    model = Model("switched", space=True)
    body = model.body("b", 2.0, (0.1, 0.2, 0.25))
    model.force("f", body, (3.0, t, 0), when=t < 0.5, label="push begins / push ends")
    model.torque("n", body, (0, 0, 0.5), frame="body", when=body.omega_z < 1.0)
    model.scene("s", ["f", "n"])
    result = load(model, folder=workshop).simulate(1.0, 11, rtol=1e-10, progress=False)
    assert_allclose(result.v("b.vx")[-1], 3.0 * 0.5 / 2.0, rtol=1e-12)
    assert_allclose(result.v("b.vy")[-1], 0.5**2 / 2.0 / 2.0, rtol=1e-12)
    assert_allclose(result.v("b.omega_z"), np.minimum(2.0 * result.t, 1.0), rtol=1e-9)
    assert {event.text for event in result.events} >= {"push ends"}
