"""The scotch yoke against forces with friction by hand, and SciPy's motion of the crank."""

from collections.abc import Callable
from itertools import product
from math import cos, floor, inf, isclose, pi, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from runtime import Outcome, Result, load

R, BEARING, SLOT, GUIDE, PUMP = 0.1, 0.4, 0.15, 0.1, 60.0
CRANK, MASS, WEIGHT = 0.05, 2.0, 2.0 * 9.81  # inertia of the crank; mass and weight of the yoke
SPEED, START = 4 * pi, pi / 6
LIMIT = 1e-8

Torque = Callable[[float, float], float]
Forces = tuple[float, float, float, float]


def balance(
    phi: float, omega: float, slips: tuple[float, float], pump: float,
    torque: float | None = None,
) -> Forces:  # fmt: skip
    """The pin's push N, friction in slot and guide, and α under a torque, or the torque of α = 0.

    With the signs of both slips the balance of both bodies is linear for either sign of N, either
    sign of the force on the guide, and whether that force or the moment presses it more; one
    combination agrees with what it takes for granted.
    """
    s, c = sin(phi), cos(phi)
    up, right = slips
    load = pump if right > 0 else 0.0
    for push, hold, tilted in product((1, -1), (1, -1), (False, True)):
        rub = up * SLOT * push  # the pin rubs the yoke along y with rub N
        weight, slope = hold * WEIGHT, -hold * rub
        if tilted:
            weight, slope = 0.0, 2 * R * abs(s) * push / BEARING
        # m ẍ = N - right GUIDE (weight + slope N) - load with ẍ = -R (s α + c ω²),
        # J α = torque + R s N - R c rub N; N and α, or N and the torque.
        across = 1 - right * GUIDE * slope
        rest = right * GUIDE * weight + load - MASS * R * c * omega**2
        moment = R * s - R * c * rub
        if torque is None:
            normal = rest / across
            found = -moment * normal
        else:
            rows = [[across, MASS * R * s], [moment, -CRANK]]
            normal, found = np.linalg.solve(rows, [rest, -torque])
        force, tilt = abs(WEIGHT - rub * normal), 2 * R * abs(s * normal) / BEARING
        pressure = weight + slope * normal
        if push * normal >= 0 and isclose(pressure, max(force, tilt), rel_tol=1e-9, abs_tol=1e-9):
            return normal, rub * normal, -right * GUIDE * pressure, found
    raise AssertionError("no combination agrees")


def slips(quarter: int, side: int) -> tuple[float, float]:
    """Signs of the slips in a quarter of a turn: of the pin upwards, of the yoke to the right."""
    middle = (quarter + 0.5) * pi / 2
    return side * np.sign(cos(middle)), -side * np.sign(sin(middle))


def breaks_away(
    torque: Torque, pump: float, phi: float, quarter: int, begin: float, end: float
) -> tuple[float, int]:
    """When the torque first exceeds what both frictions hold at rest, and to which side."""
    grid, found = np.linspace(begin, end, 4001), (inf, 0)
    for side in (1, -1):
        most = balance(phi, 0.0, slips(quarter, side), pump)[3]

        def over(t: float, side: int = side, most: float = most) -> float:
            return side * (torque(t, 0.0) - most)

        above = [k for k, t in enumerate(grid) if over(t) > 0]
        if above:
            k = above[0]
            at = begin if k == 0 else brentq(over, grid[k - 1], grid[k], xtol=1e-15)
            found = min(found, (at, side))
    return found


def motion(
    torque: Torque, pump: float, phi: float, instants: np.ndarray
) -> tuple[np.ndarray, list[float]]:
    """Angle and speed of the crank at instants, from rest; and when it came to rest."""
    values, stops = np.zeros((2, instants.size)), [0.0]
    t, end, omega, side, quarter = 0.0, instants[-1], 0.0, 0, floor(phi / (pi / 2))
    while t < end:
        if not side:
            after, side = breaks_away(torque, pump, phi, quarter, t, end)
            values[:, instants >= t] = [[phi], [0.0]]
            t = after
            continue
        edge, signs = (quarter + (side > 0)) * pi / 2, slips(quarter, side)

        def rates(t: float, y: np.ndarray, signs: tuple[float, float] = signs) -> list[float]:
            return [y[1], balance(y[0], y[1], signs, pump, torque(t, y[1]))[3]]

        def arrives(_: float, y: np.ndarray, edge: float = edge) -> float:
            return float(y[0] - edge)

        def stands(_: float, y: np.ndarray) -> float:
            return float(y[1])

        arrives.terminal = stands.terminal = True  # type: ignore[attr-defined]
        arrives.direction, stands.direction = side, -side  # type: ignore[attr-defined]
        run = solve_ivp(rates, (t, end), [phi, omega], "DOP853", rtol=1e-12, atol=1e-13,
                        dense_output=True, events=[arrives, stands])  # fmt: skip
        here = (instants >= t) & (instants <= run.t[-1])
        values[:, here] = run.sol(instants[here])
        t, (phi, omega) = run.t[-1], run.y[:, -1]
        if run.t_events[0].size:
            quarter += side
        elif run.t_events[1].size:
            omega, side = 0.0, 0
            stops.append(t)
    return values, stops


@pytest.fixture(scope="module")
def driven() -> Result:
    return load("scotch_yoke", "inverse_dynamics").inverse_dynamics(np.linspace(0, 1, 360))


def test_it_moves_as_a_cosine(driven: Result) -> None:
    phi = START + SPEED * driven.t
    assert driven.outcome is Outcome.OK
    assert np.abs(driven.q("yoke.x") - R * np.cos(phi)).max() < 1e-14
    assert np.abs(driven.v("yoke.x") + R * SPEED * np.sin(phi)).max() < 1e-13
    assert np.abs(driven.a("yoke.x") + R * SPEED**2 * np.cos(phi)).max() < 1e-11


def test_the_driver_overcomes_friction_and_the_pump(driven: Result) -> None:
    phi = START + SPEED * driven.t
    exact = [balance(p, SPEED, slips(floor(p / (pi / 2)), 1), PUMP) for p in phi]
    push, slot, guide, torque = np.array(exact).T
    # The slot's line points up: the pin pushes to its left with -N. Slip is that of pin and yoke.
    assert np.abs(driven.reaction("slot", "fy") - push).max() < 1e-11
    assert np.abs(driven.force("slot_rub") + slot).max() < 1e-11
    assert np.abs(driven.force("guide_rub") - guide).max() < 1e-11
    assert np.abs(driven.reaction("crank_drive", "torque") - torque).max() < 1e-11
    assert np.ptp(slot) > 10
    assert np.ptp(guide) > 5


def test_a_motor_turns_it() -> None:
    run = load("scotch_yoke", "running").simulate(2.0, rtol=1e-11, atol=1e-12)
    exact, _ = motion(lambda _, w: 12 * (1 - w / 30), PUMP, START, run.t)
    assert run.outcome is Outcome.OK
    assert exact[0, -1] > 4 * pi
    assert np.abs(run.q("crank.phi") - exact[0]).max() < LIMIT
    assert np.abs(run.v("crank.phi") - exact[1]).max() < LIMIT * np.abs(exact[1]).max()
    assert np.abs(run.q("yoke.x") - R * np.cos(exact[0])).max() < LIMIT * R


def test_it_sticks_while_a_torque_is_small() -> None:
    run = load("scotch_yoke", "rocking").simulate(6.0, rtol=1e-11, atol=1e-12)
    exact, stops = motion(lambda t, _: 0.3 * sin(2 * t), 0.0, pi / 3, run.t)
    assert run.outcome is Outcome.OK
    assert len(stops) == 4
    assert np.abs(run.q("crank.phi") - exact[0]).max() < LIMIT
    assert np.abs(run.v("crank.phi") - exact[1]).max() < LIMIT
    resting = exact[1] == 0
    assert resting.sum() > 50
    assert np.abs(run.v("crank.phi")[resting]).max() < 1e-10
