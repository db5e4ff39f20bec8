"""The robot arm against Lagrange's equations of three absolute angles, written by hand."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from runtime import Outcome, Result, load
from runtime.dynamics.controllers import Sample

G = 9.81
LINKS = ("upper", "fore", "hand")
JOINTS = ("shoulder", "elbow", "wrist")
MASSES = np.array([4.0, 2.5, 1.0, 1.0])
# Rows: how far along each link the masses lie, m.
REACH = np.array([[0.4, 0, 0], [0.8, 0.3, 0], [0.8, 0.6, 0.15], [0.8, 0.6, 0.3]])
COUPLING = REACH.T @ (MASSES[:, None] * REACH)
INERTIA = np.diag([0.22, 0.08, 0.01])
WEIGHT = G * (MASSES @ REACH)
TARGET = np.array([0.9, 0.7, -0.5])
KP, KD, KI = np.array([400.0, 200, 60]), np.array([60.0, 20, 3]), np.array([600.0, 300, 100])
LIMIT = np.array([90.0, 40, 12])
BEGIN = np.array([-1.4, -1.5, -1.6, 0.0, 0.0, 0.0])
TIGHT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12}
PERIOD = 0.001


def relative(angles: np.ndarray) -> np.ndarray:
    """Of absolute angles or rates: those of the joints."""
    return np.diff(angles, prepend=0.0)


def accelerations(y: np.ndarray, torques: np.ndarray) -> np.ndarray:
    """φ̈ of the links under the torques of the joints, each of which acts on two links."""
    phi, omega = y[:3], y[3:6]
    between = phi[:, None] - phi
    mass = COUPLING * np.cos(between) + INERTIA
    force = torques - np.append(torques[1:], 0.0) - WEIGHT * np.cos(phi)
    answer: np.ndarray = np.linalg.solve(mass, force - (COUPLING * np.sin(between)) @ omega**2)
    return answer


def pd(y: np.ndarray) -> np.ndarray:
    """Torques of the joints, without limits."""
    return KP * (TARGET - relative(y[:3])) - KD * relative(y[3:6])


def check(run: Result, expected: np.ndarray) -> None:
    """Angles and angular velocities, (k, 6), to 1e-8."""
    assert run.outcome is Outcome.OK
    names = [f"{link}.phi" for link in LINKS]
    got = np.column_stack([*map(run.q, names), *map(run.v, names)])
    assert np.abs(got[:, :3] - expected[:, :3]).max() < 1e-8
    assert np.abs(got[:, 3:] - expected[:, 3:6]).max() < 1e-8 * np.abs(expected[:, 3:6]).max()


def held(
    count: int, law: Callable[[float, np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """States and torques at the samples, the torques kept in between."""
    y, states, torques = BEGIN, [], []
    for k in range(count):
        torque = law(k * PERIOD, y)
        states.append(y)
        torques.append(torque)

        def slope(_: float, y: np.ndarray, torque: np.ndarray = torque) -> np.ndarray:
            return np.concatenate([y[3:], accelerations(y, torque)])

        y = solve_ivp(slope, (0, PERIOD), y, **TIGHT).y[:, -1]
    return np.array(states), np.array(torques)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_continuous_control(method: str) -> None:
    times = np.linspace(0, 2, 101)

    def slope(_: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[3:], accelerations(y, pd(y))])

    exact = solve_ivp(slope, (0, 2), BEGIN, t_eval=times, **TIGHT)
    run = load("robot_arm", "continuous").simulate(2.0, times, rtol=1e-11, method=method)
    check(run, exact.y.T)


def test_sampled_control_that_saturates() -> None:
    count = 2000
    states, torques = held(count, lambda _, y: np.clip(pd(y), -LIMIT, LIMIT))
    full = np.abs(torques) == LIMIT
    assert full.any(axis=0).all()
    assert not full.all(axis=0).any()
    times = PERIOD * np.arange(count)
    run = load("robot_arm", "sampled").simulate(times[-1], times, rtol=1e-11)
    check(run, states)
    for k, name in enumerate(JOINTS):
        assert np.abs(run.y(f"u_{name}") - torques[:, k])[:-1].max() < 1e-8 * LIMIT[k]


def test_a_controller_of_ones_own() -> None:
    """PD control with the weight taken off, along a plan of eight steps."""
    plan = TARGET * np.linspace(0.2, 1.0, 8)[:, None]

    def law(t: float, y: np.ndarray) -> np.ndarray:
        goal = plan[min(int(t / 0.03 + 1e-9), 7)]
        load_torques = np.cumsum((WEIGHT * np.cos(y[:3]))[::-1])[::-1]
        torque = KP * (goal - relative(y[:3])) / 4 - KD * relative(y[3:]) / 2 + load_torques
        return np.clip(torque, -LIMIT, LIMIT)

    def control(k: int) -> Callable[[Sample], float]:
        def answer(sample: Sample) -> float:
            read = [sample.q(f"{link}.phi") for link in LINKS]
            read += [sample.v(f"{link}.omega") for link in LINKS]
            return float(law(sample.t, np.array(read))[k])

        return answer

    count = 400
    states, _ = held(count, law)
    times = PERIOD * np.arange(count)
    controllers = {f"own_{name}": control(k) for k, name in enumerate(JOINTS)}
    machine = load("robot_arm", "own")
    check(machine.simulate(times[-1], times, rtol=1e-11, controllers=controllers), states)


def test_control_with_an_integral() -> None:
    times = np.linspace(0, 6, 121)

    def slope(_: float, y: np.ndarray) -> np.ndarray:
        error = TARGET - relative(y[:3])
        return np.concatenate([y[3:6], accelerations(y, pd(y) + KI * y[6:]), error])

    exact = solve_ivp(slope, (0, 6), [*BEGIN, 0, 0, 0], t_eval=times, **TIGHT)
    run = load("robot_arm", "integral").simulate(6.0, times, rtol=1e-11)
    check(run, exact.y.T)
    for k, name in enumerate(JOINTS):
        assert np.abs(run.y(f"sum_{name}") - exact.y[6 + k]).max() < 1e-8
    sagging = load("robot_arm", "continuous").simulate(6.0, rtol=1e-9)
    rest = [np.array([r.q(f"{link}.phi")[-1] for link in LINKS]) for r in (run, sagging)]
    off = [np.abs(relative(angles) - TARGET).max() for angles in rest]
    assert off[0] < 5e-3
    assert off[1] > 5e-2
