"""The Watt six-bar against its vector loops, virtual power, and one equation of motion."""

from dataclasses import dataclass
from functools import lru_cache
from math import pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from runtime import Outcome, Result, load

SPEED, TORQUE, STIFFNESS, FREE, ANCHOR = 2 * pi, 60.0, 150.0, 1.0, 1 + 6j
NAMES = ("crank", "coupler", "rocker", "left", "right")
MASSES = np.array([2.0, 6.0, 5.0, 2.0, 2.0])
INERTIAS = np.array([1.5, 4.0, 3.0, 0.7, 0.7])
B, C, E = -2.2 - 0.5j, 0.8 - 0.5j, 1.4 + 1.0j  # in the coupler
D, H, F = -1.9 + 0.3j, 0.6 + 0.3j, 1.3 - 0.6j  # in the rocker; H is its pin C
# Rows of arms, which times e^{iφ} of the five bodies add up to what is below each.
LOOPS = np.array([[1, C - B, -(H - D), 0, 0], [0, E - C, -(F - H), 2, -2]])  # 3, 0
CENTRES = np.array(
    [[0, 0, 0, 0, 0], [1, -B, 0, 0, 0], [0, 0, -D, 0, 0], [1, E - B, 0, 1, 0],
     [0, 0, F - D, 0, 1]]
)  # fmt: skip
PLACES = np.array([0, 0, 3, 0, 3])  # added to the centres
PIN_G = np.array([1, E - B, 0, 2, 0])
# Joint → (body that pushes, body that is pushed, the pin in both); -1 is the ground.
PINS = {"A": (-1, 0, 0, 0), "B": (0, 1, 1, B), "C": (1, 2, C, H), "D": (-1, 2, 3, D),
        "E": (1, 3, E, -1), "F": (2, 4, F, -1), "G": (3, 4, 1, 1)}  # fmt: skip


@dataclass(frozen=True)
class Motion:
    """Angles of the five bodies, their derivatives by that of the crank, and what follows."""

    angles: np.ndarray
    first: np.ndarray
    second: np.ndarray

    def point(self, arms: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Place, and its two derivatives by the crank's angle."""
        turned = np.exp(1j * self.angles)
        spin = -(self.first**2) + 1j * self.second
        return arms @ turned, arms @ (1j * self.first * turned), arms @ (spin * turned)


def solve_loops(phi: float, near: np.ndarray) -> Motion:
    """Close both loops by Newton's method, and differentiate them twice."""
    angles = np.array([phi, *near[1:]])
    for _ in range(20):
        turned = LOOPS * np.exp(1j * angles)
        gap, slopes = turned.sum(axis=1) - [3, 0], 1j * turned[:, 1:]
        matrix = np.vstack([slopes.real, slopes.imag])
        change = np.linalg.solve(matrix, [*gap.real, *gap.imag])
        angles[1:] -= change
        if np.abs(change).max() < 1e-14:
            break
    turned = LOOPS * np.exp(1j * angles)
    slopes = 1j * turned[:, 1:]
    matrix = np.vstack([slopes.real, slopes.imag])
    lead = 1j * turned[:, 0]
    first = np.array([1.0, *np.linalg.solve(matrix, [*-lead.real, *-lead.imag])])
    bend = turned @ first**2
    second = np.array([0.0, *np.linalg.solve(matrix, [*bend.real, *bend.imag])])
    return Motion(angles, first, second)


BEGIN = np.array([0.0, 1.0, 1.7, 1.5, 2.0])


@lru_cache
def turn(count: int) -> tuple[Motion, ...]:
    """A turn of the crank in equal parts, followed from the drawing."""
    found: list[Motion] = []
    for phi in np.linspace(0, 2 * pi, count):
        found.append(solve_loops(phi, found[-1].angles if found else BEGIN))
    return tuple(found)


def spring(motion: Motion) -> complex:
    """Force of the spring on G."""
    line = ANCHOR - motion.point(PIN_G)[0]
    return STIFFNESS * (abs(line) - FREE) * line / abs(line)


def inertia_and_load(motion: Motion, rate: float) -> tuple[float, float]:
    """I of I φ̈ = T - load, and the load, by virtual power."""
    _, slope, bend = motion.point(CENTRES)
    inertia = MASSES @ np.abs(slope) ** 2 + INERTIAS @ motion.first**2
    load = (MASSES @ (slope.conj() * (bend * rate**2 + 9.81j)).real
            + INERTIAS @ (motion.first * motion.second) * rate**2)  # fmt: skip
    pulled = (motion.point(PIN_G)[1].conjugate() * spring(motion)).real
    return float(inertia), float(load - pulled)


def pin_forces(motion: Motion) -> tuple[dict[str, complex], float]:
    """Forces in all pins and the torque of the drive, from Newton and Euler of each body."""
    matrix, right = np.zeros((15, 15)), np.zeros(15)
    turned = np.exp(1j * motion.angles)
    bend = motion.point(CENTRES)[2] * SPEED**2
    for k in range(5):
        force = MASSES[k] * (bend[k] + 9.81j) - (spring(motion) if k == 3 else 0)
        moment = INERTIAS[k] * motion.second[k] * SPEED**2
        moment -= (turned[3].conjugate() * spring(motion)).imag if k == 3 else 0
        right[3 * k : 3 * k + 3] = force.real, force.imag, moment
    for column, (i, j, at_i, at_j) in enumerate(PINS.values()):
        for body, sign, at in ((i, -1, at_i), (j, 1, at_j)):
            if body >= 0:
                arm = at * turned[body]
                block = [[1, 0], [0, 1], [-arm.imag, arm.real]]
                matrix[3 * body : 3 * body + 3, 2 * column : 2 * column + 2] = sign * np.array(
                    block
                )
    matrix[2, 14] = 1
    answer = np.linalg.solve(matrix, right)
    pairs = answer[:14:2] + 1j * answer[1:14:2]
    return dict(zip(PINS, pairs.tolist(), strict=True)), float(answer[14])


def check_positions(run: Result, motions: tuple[Motion, ...]) -> None:
    """Angles and centres of mass with their velocities and accelerations, at constant speed."""
    for k, motion in enumerate(motions):
        places = [x + d for x, d in zip(motion.point(CENTRES), (PLACES, 0, 0), strict=True)]
        for body, name in enumerate(NAMES):
            turned = motion.angles[body], motion.first[body], motion.second[body]
            for power, (read, letters) in enumerate(
                ((run.q, ("x", "y", "phi")), (run.v, ("x", "y", "phi")), (run.a, ("x", "y", "phi")))
            ):
                x, y, phi = (read(f"{name}.{letter}")[k] for letter in letters)
                scale = SPEED**power
                assert abs(complex(x, y) - places[power][body] * scale) < 1e-8 * scale
                assert abs(phi - turned[power] * scale) < 1e-8 * scale


def test_the_loops_close_and_their_derivatives_are_right() -> None:
    step = 1e-5
    for motion in turn(73):
        assert np.abs((LOOPS * np.exp(1j * motion.angles)).sum(axis=1) - [3, 0]).max() < 1e-14
        near = [solve_loops(motion.angles[0] + d, motion.angles) for d in (-step, step)]
        rate = (near[1].angles - near[0].angles) / (2 * step)
        assert np.abs(rate - motion.first).max() < 1e-8
        assert np.abs((near[1].first - near[0].first) / (2 * step) - motion.second).max() < 1e-7


def test_it_moves_as_its_vector_loops_say() -> None:
    run = load("watt_six_bar", "kinematics").kinematics(np.linspace(0, 1, 181))
    assert run.outcome is Outcome.OK
    check_positions(run, turn(181))


def test_the_torque_and_the_forces_in_the_pins() -> None:
    run = load("watt_six_bar", "inverse_dynamics").inverse_dynamics(np.linspace(0, 1, 181))
    check_positions(run, turn(181))
    torque = run.reaction("crank_drive", "torque")
    scale = np.abs(torque).max()
    for k, motion in enumerate(turn(181)):
        forces, drive = pin_forces(motion)
        _, load_torque = inertia_and_load(motion, SPEED)
        assert abs(drive - load_torque) < 1e-10 * scale
        assert abs(torque[k] - load_torque) < 1e-8 * scale
        largest = max(abs(force) for force in forces.values())
        for joint, force in forces.items():
            pusher = PINS[joint][0]  # in whose axes reactions are
            axes = np.exp(1j * motion.angles[pusher]) if pusher >= 0 else 1
            ours = axes * complex(*(run.reaction(joint, f"f{letter}")[k] for letter in "xy"))
            assert abs(ours - force) < 1e-8 * largest, joint


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_constant_torque_turns_it(method: str) -> None:
    times = np.linspace(0, 2, 201)
    run = load("watt_six_bar", "constant_torque").simulate(2.0, times, rtol=1e-12, method=method)
    assert run.outcome is Outcome.OK
    phi, rate = one_equation()(times)
    assert np.abs(run.q("crank.phi") - phi).max() < 1e-8
    assert np.abs(run.v("crank.phi") - rate).max() < 1e-8 * np.abs(rate).max()
    gained = run.energy() - run.energy()[0] - TORQUE * (phi - phi[0])
    assert np.abs(gained).max() < 1e-8 * np.ptp(run.energy("kinetic"))


@lru_cache
def one_equation() -> object:
    """φ and φ̇ of the crank under the torque, a function of the time."""
    known = [BEGIN]

    def slope(_: float, y: np.ndarray) -> list[float]:
        motion = solve_loops(y[0], known[0])
        known[0] = motion.angles
        inertia, load_torque = inertia_and_load(motion, y[1])
        return [y[1], (TORQUE - load_torque) / inertia]

    run = solve_ivp(slope, (0, 2), [0.0, SPEED], method="DOP853", rtol=1e-12, atol=1e-12,
                    dense_output=True)  # fmt: skip
    return run.sol
