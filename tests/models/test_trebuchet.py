"""The trebuchet against the same machine in three pieces, each in coordinates of its own."""

from dataclasses import dataclass
from functools import lru_cache
from math import asin, pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from runtime import Outcome, Result, load

G = 9.81
PIVOT, SLING, RELEASE = 5j, 5.5, 0.6
# (mass, inertia, arms along e^{iφ} of the beam, e^{iψ} of the counterweight, e^{iσ} of the sling)
BODIES = (
    (300.0, 1600.0, (-2.5, 0.0, 0.0)),
    (4000.0, 700.0, (1.5, -1.2j, 0.0)),
    (50.0, 0.0, (-6.5, 0.0, SLING)),
)
TIGHT = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13, "dense_output": True}


def equations(angles: np.ndarray, rates: np.ndarray, count: int) -> tuple[np.ndarray, ...]:
    """M, forces, and ball's Jacobian and bias, of the first `count` bodies, by virtual power."""
    mass, force = np.zeros((count, count)), np.zeros(count)
    turned = np.exp(1j * angles[:count])
    columns, bias = np.zeros(count, complex), 0j
    for k, (m, inertia, arms) in enumerate(BODIES[:count]):
        placed = np.array(arms[:count]) * turned
        columns, bias = 1j * placed, -(placed @ rates[:count] ** 2)
        mass += m * (columns.conj()[:, None] * columns).real
        force -= m * (columns.conj() * (bias + 1j * G)).real
        mass[k, k] += inertia
    return mass, force, columns, np.array(bias)


def sliding_angles(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """φ, ψ, σ and their rates while the ball is on y = 0."""
    sigma = asin((6.5 * np.sin(y[0]) - PIVOT.imag) / SLING)
    rate = 6.5 * np.cos(y[0]) * y[2] / (SLING * np.cos(sigma))
    return np.array([*y[:2], sigma]), np.array([*y[2:4], rate])


def sliding(y: np.ndarray) -> np.ndarray:
    """Accelerations of the three angles, and the trough's force on the ball."""
    mass, force, columns, bias = equations(*sliding_angles(y), 3)
    matrix = np.block([[mass, -columns.imag[:, None]], [columns.imag[None], np.zeros((1, 1))]])
    answer: np.ndarray = np.linalg.solve(matrix, [*force, -bias.imag])
    return answer


def free(y: np.ndarray) -> np.ndarray:
    """Angles and rates → their derivatives, of two bodies, or of three."""
    count = len(y) // 2
    mass, force, _, _ = equations(y[:count], y[count:], count)
    return np.concatenate([y[count:], np.linalg.solve(mass, force)])


def ball_at(y: np.ndarray) -> tuple[complex, complex]:
    """Position and velocity of the ball in its sling."""
    arms = np.array(BODIES[2][2]) * np.exp(1j * y[:3])
    return PIVOT + arms.sum(), 1j * (arms @ y[3:6])


@dataclass(frozen=True)
class Throw:
    """The reference: instants, and the motion between them."""

    lift_off: float
    released: float
    landed: float
    sliding: object
    swinging: object
    after: object
    at: complex
    velocity: complex

    def angles(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """φ, ψ (and σ) and their rates."""
        if t <= self.lift_off:
            return sliding_angles(self.sliding(t))  # type: ignore[operator]
        y = (self.swinging if t <= self.released else self.after)(t)  # type: ignore[operator]
        return y[: len(y) // 2], y[len(y) // 2 :]

    def ball(self, t: float) -> tuple[complex, complex]:
        """Position and velocity of the ball."""
        if t <= self.released:
            return ball_at(np.concatenate(self.angles(t)))
        s = t - self.released
        return self.at + self.velocity * s - 0.5j * G * s**2, self.velocity - 1j * G * s


def until(value: object) -> object:
    """An event that ends the integration."""
    value.terminal = True  # type: ignore[attr-defined]
    return value


@lru_cache
def reference() -> Throw:
    """Sliding, swinging and flying, one after the other."""

    def lift(_: float, y: np.ndarray) -> float:
        return float(sliding(y)[3])

    def let_go(_: float, y: np.ndarray) -> float:
        return float(y[2] - y[0] + pi - RELEASE)

    def slide(_: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[2:], sliding(y)[:2]])

    first = solve_ivp(slide, (0, 5), [asin(5 / 6.5), 0, 0, 0], events=until(lift), **TIGHT)
    lifted = first.t[-1]
    angles, rates = sliding_angles(first.y[:, -1])
    second = solve_ivp(lambda _, y: free(y), (lifted, 5), [*angles, *rates],
                       events=until(let_go), **TIGHT)  # fmt: skip
    released, y = second.t[-1], second.y[:, -1]
    at, velocity = ball_at(y)
    landed = released + (velocity.imag + np.sqrt(velocity.imag**2 + 2 * G * at.imag)) / G
    third = solve_ivp(lambda _, y: free(y), (released, landed), y[[0, 1, 3, 4]], **TIGHT)
    return Throw(lifted, released, landed, first.sol, second.sol, third.sol, at, velocity)


@pytest.fixture(scope="module")
def run() -> Result:
    return load("trebuchet").simulate(20.0, rtol=1e-12)


def test_one_run_slides_lifts_off_lets_go_and_lands(run: Result) -> None:
    exact = reference()
    assert (run.outcome, run.ended_by) == (Outcome.OK, "landed")
    opened = [event.time for event in run.events if event.name.startswith("trough")]
    assert abs(opened[0] - exact.lift_off) < 1e-8
    (change,) = run.reconnections
    assert (change.joint, change.action, change.impulse) == ("sling", "release", {})
    assert abs(change.time - exact.released) < 1e-9
    assert abs(run.t[-1] - exact.landed) < 1e-8


def test_release_speed_and_range(run: Result) -> None:
    exact = reference()
    state = run.at(run.reconnections[0].time)
    velocity = complex(state.v("ball.vx").item(), state.v("ball.vy").item())
    assert abs(velocity - exact.velocity) < 1e-8 * abs(exact.velocity)
    distance = exact.ball(exact.landed)[0].real
    assert abs(run.q("ball.x")[-1] - distance) < 1e-8 * distance
    assert distance == pytest.approx(277.629, abs=0.001)


def test_the_whole_motion(run: Result) -> None:
    exact = reference()
    for k, t in enumerate(run.t[:-1]):
        angles, rates = exact.angles(t)
        at, velocity = exact.ball(t)
        assert abs(run.q("beam.phi")[k] - angles[0]) < 1e-8
        assert abs(run.q("counterweight.phi")[k] - angles[1]) < 1e-8
        assert abs(run.v("beam.phi")[k] - rates[0]) < 1e-8 * 10
        assert abs(complex(run.q("ball.x")[k], run.q("ball.y")[k]) - at) < 1e-8 * 100
        assert abs(complex(run.v("ball.x")[k], run.v("ball.y")[k]) - velocity) < 1e-8 * 50


def test_the_forces_of_trough_and_sling(run: Result) -> None:
    exact = reference()
    early = run.at(np.linspace(0.01, exact.lift_off - 1e-3, 40))
    pressed = np.array([sliding(exact.sliding(t))[3] for t in early.t])  # type: ignore[operator]
    assert np.abs(early.force("trough") - pressed).max() < 1e-8 * pressed.max()
    later = run.at(np.linspace(exact.lift_off + 1e-3, exact.released - 1e-6, 40))
    pulled = []
    for t in later.t:
        angles, rates = exact.angles(t)
        q = free(np.concatenate([angles, rates]))[3:]
        _, _, columns, bias = equations(angles, rates, 3)
        pulled.append(50.0 * (columns @ q + bias + 1j * G) * np.exp(-1j * angles[2]))
    force = np.array(pulled)
    assert np.abs(force.imag).max() < 1e-9 * np.abs(force.real).max()
    assert np.abs(later.reaction("sling", "fx") - force.real).max() < 1e-8 * np.abs(force).max()
    assert (run.reaction("sling", "fx")[run.t < exact.released] < 0.0).all()
    assert not run.reaction("sling", "fx")[run.t > exact.released].any()
