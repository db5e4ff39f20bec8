"""The scotch yoke against forces with friction by hand, and SciPy's motion of the crank."""

from collections.abc import Callable
from functools import partial
from itertools import product
from math import cos, floor, inf, pi, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import OptimizeResult, brentq

from runtime import Outcome, Result, load

R, BEARING, SLOT, GUIDE, PUMP = 0.1, 0.4, 0.15, 0.1, 60.0
CRANK, MASS, WEIGHT = 0.05, 2.0, 2.0 * 9.81  # inertia of the crank; mass and weight of the yoke
SPEED, START = 4 * pi, pi / 6
LIMIT = 1e-8

Torque = Callable[[float, float], float]
Forces = tuple[float, float, float, float]
Margins = tuple[float, float, float]
Combination = tuple[int, int, bool]  # signs of N and of the force on the guide; the moment presses
COMBINATIONS: list[Combination] = list(product((1, -1), (1, -1), (False, True)))


def combine(
    phi: float, omega: float, slips: tuple[float, float], pump: float, torque: float | None,
    combination: Combination,
) -> tuple[Forces, Margins]:  # fmt: skip
    """The balance of a combination, and margins that are positive where it agrees with itself.

    The forces are the pin's push N, friction in slot and guide, and α under a torque, or the torque
    of α = 0. With the signs of both slips the balance of both bodies is linear for either sign of
    N, either sign of the force on the guide, and whether that force or the moment presses it more.
    """
    s, c = sin(phi), cos(phi)
    up, right = slips
    push, hold, tilted = combination
    load = pump if right > 0 else 0.0
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
    force, tilt = hold * (WEIGHT - rub * normal), 2 * R * abs(s) * push * normal / BEARING
    forces = normal, rub * normal, -right * GUIDE * (weight + slope * normal), found
    return forces, (push * normal, force, tilt - force if tilted else force - tilt)


def choose(
    phi: float, omega: float, slips: tuple[float, float], pump: float, torque: float | None
) -> tuple[Combination, Forces]:
    """The combination that agrees with what it takes for granted, and its forces."""
    for combination in COMBINATIONS:
        forces, margins = combine(phi, omega, slips, pump, torque, combination)
        if min(margins) >= -1e-9:
            return combination, forces
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
        most = choose(phi, 0.0, slips(quarter, side), pump, None)[1][3]

        def over(t: float, side: int = side, most: float = most) -> float:
            return side * (torque(t, 0.0) - most)

        above = [k for k, t in enumerate(grid) if over(t) > 0]
        if above:
            k = above[0]
            at = begin if k == 0 else brentq(over, grid[k - 1], grid[k], xtol=1e-15)
            found = min(found, (at, side))
    return found


def piece(
    torque: Torque, pump: float, begin: float, end: float, state: tuple[float, float],
    signs: tuple[float, float], edge: float, combination: Combination, longest: float,
) -> OptimizeResult:  # fmt: skip
    """The motion of a combination; the events are the edge, rest, and the end of each margin."""

    def rates(t: float, y: np.ndarray) -> list[float]:
        forces, _ = combine(y[0], y[1], signs, pump, torque(t, y[1]), combination)
        return [y[1], forces[3]]

    def margin(t: float, y: np.ndarray, k: int) -> float:
        return combine(y[0], y[1], signs, pump, torque(t, y[1]), combination)[1][k]

    side = np.sign(edge - state[0])
    ends = [
        lambda _, y: side * (edge - y[0]),
        lambda _, y: side * y[1],
        *(partial(margin, k=k) for k in range(3)),
    ]
    for function in ends:
        function.terminal, function.direction = True, -1
    return solve_ivp(rates, (begin, end), state, "DOP853", rtol=1e-13, atol=1e-14,
                     max_step=longest, dense_output=True, events=ends)  # fmt: skip


def motion(
    torque: Torque, pump: float, phi: float, instants: np.ndarray, longest: float = 2e-3
) -> tuple[np.ndarray, list[float]]:
    """Angle and speed of the crank at instants, from rest; and when it came to rest.

    No step passes a place where the accelerations jump or bend, since its error estimate may miss
    that. Steps are short for their interpolants, whose error no estimate sees.
    """
    values, stops = np.zeros((2, instants.size)), [0.0]
    t, end, omega, side, quarter = 0.0, instants[-1], 0.0, 0, floor(phi / (pi / 2))
    combination = None
    while t < end:
        if not side:
            after, side = breaks_away(torque, pump, phi, quarter, t, end)
            values[:, instants >= t] = [[phi], [0.0]]
            t = after
            continue
        edge, signs = (quarter + (side > 0)) * pi / 2, slips(quarter, side)
        if combination is None:
            combination, _ = choose(phi, omega, signs, pump, torque(t, omega))
        run = piece(torque, pump, t, end, (phi, omega), signs, edge, combination, longest)
        here = (instants >= t) & (instants <= run.t[-1])
        if here.any():
            values[:, here] = run.sol(instants[here])
        t, (phi, omega) = run.t[-1], run.y[:, -1]
        cause = next((k for k, found in enumerate(run.t_events) if found.size), None)
        if cause == 0:
            quarter, combination = quarter + side, None
        elif cause == 1:
            omega, side, combination = 0.0, 0, None
            stops.append(t)
        elif cause is not None:
            push, hold, tilted = combination
            neighbours = (-push, hold, tilted), (push, -hold, tilted), (push, hold, not tilted)
            combination = neighbours[cause - 2]
    return values, stops


def motor(_: float, omega: float) -> float:
    """Torque of the motor in the scene `running`."""
    return 12 * (1 - omega / 30)


def rocker(t: float, _: float) -> float:
    """Torque of the rocker in the scene `rocking`."""
    return 0.3 * sin(2 * t)


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
    exact = [choose(p, SPEED, slips(floor(p / (pi / 2)), 1), PUMP, None)[1] for p in phi]
    push, slot, guide, torque = np.array(exact).T
    # The slot's line points up: the pin pushes to its left with -N. Slip is that of pin and yoke.
    assert np.abs(driven.reaction("slot", "fy") - push).max() < 1e-11
    assert np.abs(driven.force("slot_rub") + slot).max() < 1e-11
    assert np.abs(driven.force("guide_rub") - guide).max() < 1e-11
    assert np.abs(driven.reaction("crank_drive", "torque") - torque).max() < 1e-11
    assert np.ptp(slot) > 10
    assert np.ptp(guide) > 5


@pytest.mark.parametrize(
    ("torque", "pump", "phi", "end"), [(motor, PUMP, START, 2.0), (rocker, 0.0, pi / 3, 6.0)]
)
def test_shorter_steps_change_nothing_by_hand(
    torque: Torque, pump: float, phi: float, end: float
) -> None:
    instants = np.linspace(0, end, 501)
    values, stops = motion(torque, pump, phi, instants)
    finer, same = motion(torque, pump, phi, instants, longest=1e-3)
    assert np.abs(values - finer).max() < LIMIT / 1000
    assert np.abs(np.subtract(stops, same)).max() < LIMIT / 1000


def test_a_motor_turns_it() -> None:
    # Steps pass places where the pin's push changes sign, or the moment begins to press the guide.
    # There the accelerations bend, and how well the estimate of a step's error sees it is chance.
    # Over 201 tolerances within 15 % of this one the largest error is 2.5e-9, the median 8e-11;
    # without max_step it is 7e-9, and with rtol=1e-11 as well 6e-8.
    machine = load("scotch_yoke", "running")
    run = machine.simulate(2.0, rtol=1e-13, atol=1e-14, max_step=1e-4)
    exact, _ = motion(motor, PUMP, START, run.t)
    assert run.outcome is Outcome.OK
    assert exact[0, -1] > 4 * pi
    assert np.abs(run.q("crank.phi") - exact[0]).max() < LIMIT
    assert np.abs(run.v("crank.phi") - exact[1]).max() < LIMIT * np.abs(exact[1]).max()
    assert np.abs(run.q("yoke.x") - R * np.cos(exact[0])).max() < LIMIT * R


def test_it_sticks_while_a_torque_is_small() -> None:
    run = load("scotch_yoke", "rocking").simulate(6.0, rtol=1e-11, atol=1e-12)
    exact, stops = motion(rocker, 0.0, pi / 3, run.t)
    assert run.outcome is Outcome.OK
    assert len(stops) == 4
    assert np.abs(run.q("crank.phi") - exact[0]).max() < LIMIT
    assert np.abs(run.v("crank.phi") - exact[1]).max() < LIMIT
    resting = exact[1] == 0
    assert resting.sum() > 50
    assert np.abs(run.v("crank.phi")[resting]).max() < 1e-10
