"""The engine against SciPy's energy over the angle of its crank, and its balance of works."""

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

from models.engine import indicated
from runtime import Outcome, Result, load

LIMIT = 1e-8
R, ROD, BORE, FLYWHEEL, AMBIENT, LOAD = 0.04, 0.14, 0.08, 0.124, 1e5, 0.35
ROD_MASS, ROD_INERTIA, PISTON, GRAVITY = 0.6, 0.0015, 0.5, 9.81
TURNS = 4 * pi

# SciPy's pchip does not repeat: three periods side by side, of which the middle one counts.
ANGLES, BARS = np.radians(list(indicated)), 1e5 * np.array(list(indicated.values()))
PRESSURE = PchipInterpolator(
    np.concatenate([ANGLES[:-1] - TURNS, ANGLES, ANGLES[1:] + TURNS]),
    np.concatenate([BARS[:-1], BARS, BARS[1:]]),
)


def kinematics(phi: float | np.ndarray) -> tuple[np.ndarray, ...]:
    """x and dx/dφ of the piston, the inertia of all on the crank, and the potential."""
    s, c = np.sin(phi), np.cos(phi)
    sine = -R / ROD * s
    cosine = np.sqrt(1 - sine**2)
    lean = -R / ROD * c / cosine  # of the rod's angle over φ
    x, slope = R * c + ROD * cosine, -R * s - ROD * sine * lean
    centre = (-R * s - ROD / 2 * sine * lean) ** 2 + (R * c / 2) ** 2
    inertia = FLYWHEEL + ROD_MASS * centre + ROD_INERTIA * lean**2 + PISTON * slope**2
    return x, slope, inertia, ROD_MASS * GRAVITY * R * s / 2


def gas(phi: float) -> float:
    """The force on the piston."""
    return float(-(PRESSURE(phi % TURNS) - AMBIENT) * pi * BORE**2 / 4)


def motion(end: float) -> tuple[np.ndarray, list[float], list]:
    """Energy, time and works over φ from 0 to `end`, piece by piece between the table's points."""

    def rates(phi: float, y: np.ndarray) -> list[float]:
        _, slope, inertia, potential = kinematics(phi)
        omega = np.sqrt(2 * (y[0] - potential) / inertia)
        push, brake = gas(phi) * slope, -LOAD * omega
        return [push + brake, 1 / omega, push, brake]

    knots = np.concatenate([k * TURNS + ANGLES[:-1] for k in range(int(end / TURNS) + 1)])
    edges = [*knots[knots < end], end]
    state, pieces = [kinematics(0.0)[2] * 100.0**2 / 2, 0.0, 0.0, 0.0], []
    for begin, stop in pairwise(edges):
        run = solve_ivp(rates, (begin, stop), state, "DOP853", rtol=1e-12, atol=1e-12,
                        dense_output=True)  # fmt: skip
        pieces.append(run.sol)
        state = run.y[:, -1]
    return np.array(edges), state, pieces


def over(angles: np.ndarray) -> np.ndarray:
    """The columns of `motion` at angles, in rows."""
    edges, _, pieces = motion(float(angles[-1]))
    which = np.clip(np.searchsorted(edges, angles, side="right") - 1, 0, len(pieces) - 1)
    return np.array([pieces[k](phi) for k, phi in zip(which, angles, strict=True)])


@pytest.fixture(scope="module")
def fired() -> Result:
    return load("engine", "firing").simulate(0.5, rtol=1e-11, atol=1e-13)


def test_it_turns_as_its_energy_says(fired: Result) -> None:
    phi, omega = fired.q("crank.phi"), fired.v("crank.phi")
    assert fired.outcome is Outcome.OK
    assert phi[-1] > 4 * TURNS
    assert not fired.events  # the points of a table are none
    exact = over(phi)
    place, slope, inertia, potential = kinematics(phi)
    speed = np.sqrt(2 * (exact[:, 0] - potential) / inertia)
    assert np.abs(fired.t - exact[:, 1]).max() < LIMIT * 0.5
    assert np.abs(omega - speed).max() < LIMIT * speed.max()
    assert np.abs(fired.q("piston.x") - place).max() < LIMIT * R
    assert np.abs(fired.v("piston.x") - slope * speed).max() < LIMIT * np.abs(slope * speed).max()
    for series, column in ((fired.energy() - fired.energy()[0] + exact[0, 0], 0),
                           (fired.work("gas"), 2), (fired.work("load"), 3)):  # fmt: skip
        assert np.abs(series - exact[:, column]).max() < LIMIT * np.ptp(exact[:, column])


@pytest.mark.parametrize("rtol", [1e-6, 1e-7, 1e-8, 1e-9, 1e-10])
def test_energy_and_works_agree_to_the_tolerance(rtol: float) -> None:
    run = load("engine", "firing").simulate(1.0, rtol=rtol, atol=rtol / 100)
    gained = run.energy() - run.energy()[0]
    paid = run.work("gas") + run.work("load")
    assert np.abs(gained - paid).max() < rtol * np.ptp(run.work("gas"))


def test_at_default_tolerances_they_agree_too() -> None:
    run = load("engine", "firing").simulate(1.0)
    gained = run.energy() - run.energy()[0]
    paid = run.work("gas") + run.work("load")
    assert np.abs(gained - paid).max() < 1e-9 * np.ptp(run.work("gas"))
