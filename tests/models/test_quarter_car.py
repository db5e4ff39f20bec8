"""The quarter car: its loop closed by Newton's method, and SciPy's motion of two coordinates."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from runtime import Outcome, Result, load

LIMIT = 1e-8
SPEED, GRAVITY, RADIUS = 12.0, 9.81, 0.3
STRUT, DAMPER, FREE = 40e3, 3e3, 0.62
TYRE, DAMPING = 200e3, 150.0
ROAD = PchipInterpolator(
    [0.0, 1.0, 2.0, 2.25, 2.5, 2.75, 3.0, 3.25, 3.5, 4.0, 6.0],
    [0.0, 0.0, 0.0, 0.012, 0.038, 0.060, 0.045, 0.015, 0.0, 0.0, 0.0],
)
# Mass and inertia of chassis, lower and upper wishbone, upright.
MASSES = np.array([300.0, 300.0, 6.0, 6.0, 3.0, 3.0, 35.0, 35.0])
INERTIA = np.array([0.0, 0.1, 0.05, 1.0])
D, C = np.array([0.3, 0.0]), np.array([0.35, 0.25])  # on the chassis
HIGH = np.array([0.45, 0.5])  # of the strut on the chassis


def turned(angle: float, *place: float) -> np.ndarray:
    """A vector of a body, and its derivatives over the angle: r, r', r'' in rows."""
    c, s = np.cos(angle), np.sin(angle)
    r = np.array([c * place[0] - s * place[1], s * place[0] + c * place[1]])
    return np.array([r, [-r[1], r[0]], -r])


class Linkage(NamedTuple):
    """Wishbones and upright at an angle of the lower one, relative to the chassis.

    Attributes
    ----------
    angles, slopes, bends
        Those of lower wishbone, upper wishbone and upright, and derivatives over the first.
    places, rates, curves
        Centres of the three bodies and the strut's lower end, and derivatives.
    """

    angles: np.ndarray
    slopes: np.ndarray
    bends: np.ndarray
    places: np.ndarray
    rates: np.ndarray
    curves: np.ndarray


def linkage(theta: float) -> Linkage:
    """The loop closed by Newton's method, with its exact derivatives."""
    arm = turned(theta, 0.4, 0.0)
    upper, upright = 0.0, 0.0
    for _ in range(20):
        a, up, down = (
            turned(upper, 0.3, 0.0),
            turned(upright, -0.07, 0.12),
            turned(upright, -0.05, -0.12),
        )
        gap = D + arm[0] - down[0] + up[0] - C - a[0]
        matrix = np.array([-a[1], up[1] - down[1]]).T
        step = np.linalg.solve(matrix, -gap)
        upper, upright = upper + step[0], upright + step[1]
        if np.abs(step).max() < 1e-15:
            break
    a, up, down = (
        turned(upper, 0.3, 0.0), turned(upright, -0.07, 0.12), turned(upright, -0.05, -0.12)
    )  # fmt: skip
    matrix = np.array([-a[1], up[1] - down[1]]).T
    first = np.linalg.solve(matrix, -arm[1])
    second = np.linalg.solve(
        matrix, -(arm[2] - a[2] * first[0] ** 2 + (up[2] - down[2]) * first[1] ** 2)
    )
    angles, slopes, bends = (
        np.array([theta, upper, upright]), np.array([1.0, *first]), np.array([0.0, *second])
    )  # fmt: skip
    # Chains of turned vectors from the chassis to the centres and to the strut's foot.
    chains = [
        (D, [(0, (0.2, 0.0))]),
        (C, [(1, (0.15, 0.0))]),
        (D, [(0, (0.4, 0.0)), (2, (0.05, 0.12))]),
        (D, [(0, (0.3, 0.0))]),
    ]
    rows = []
    for base, links in chains:
        row = np.array([base, [0.0, 0.0], [0.0, 0.0]])
        for k, place in links:
            r = turned(angles[k], *place)
            row += [r[0], r[1] * slopes[k], r[1] * bends[k] + r[2] * slopes[k] ** 2]
        rows.append(row)
    places, rates, curves = np.array(rows).transpose(1, 0, 2)
    return Linkage(angles, slopes, bends, places, rates, curves)


class Moment(NamedTuple):
    """Forces and accelerations at an instant."""

    rates: np.ndarray
    pull: float
    length: float
    load: float
    margin: float  # the contact holds where it is negative


def moment(t: float, y: np.ndarray, closed: bool | None = None) -> Moment:
    """Of the state (height of the chassis, angle of the lower wishbone, and their rates)."""
    height, theta, rise, turn = y
    at = linkage(theta)
    line = HIGH - at.places[3]
    length = float(np.hypot(*line))
    slope = -line @ at.rates[3] / length
    pull = STRUT * (length - FREE) + DAMPER * slope * turn
    x = SPEED * t
    gap = height + at.places[2, 1] - RADIUS - ROAD(x)
    speed = rise + at.rates[2, 1] * turn - SPEED * ROAD(x, 1)
    push = -(TYRE * gap + DAMPING * speed)
    margin = max(gap, -push)
    load = push if (margin < 0 if closed is None else closed) else 0.0
    # Velocities of the masses are B (rise, turn), their accelerations B (…)' + curves turn².
    ones = np.tile([0.0, 1.0], 4)
    along = np.concatenate([[0.0, 0.0], at.rates[:3].ravel()])
    bend = np.concatenate([[0.0, 0.0], at.curves[:3].ravel()])
    spin, spin_bend = np.array([0.0, *at.slopes]), np.array([0.0, *at.bends])
    matrix = np.array([
        [ones @ (MASSES * ones), ones @ (MASSES * along)],
        [along @ (MASSES * ones), along @ (MASSES * along) + spin @ (INERTIA * spin)],
    ])  # fmt: skip
    inertia = MASSES * bend * turn**2
    rhs = np.array([
        load - GRAVITY * ones @ (MASSES * ones) - ones @ inertia,
        load * at.rates[2, 1] - pull * slope - GRAVITY * ones @ (MASSES * along)
        - along @ inertia - spin @ (INERTIA * spin_bend) * turn**2,
    ])  # fmt: skip
    return Moment(np.array([rise, turn, *np.linalg.solve(matrix, rhs)]), pull, length, load, margin)


def rest() -> np.ndarray:
    """Where it rests on the flat road: the tyre carries the weight, the strut its share."""
    weight = GRAVITY * MASSES[::2].sum()

    def height(theta: float) -> float:
        return RADIUS - weight / TYRE - linkage(theta).places[2, 1]

    def falls(theta: float) -> float:
        return float(moment(0.0, np.array([height(theta), theta, 0.0, 0.0])).rates[3])

    theta = brentq(falls, -0.3, 0.3, xtol=1e-15, rtol=1e-15)
    return np.array([height(theta), theta, 0.0, 0.0])


def motion(instants: np.ndarray) -> tuple[np.ndarray, list[float]]:
    """States at instants, piece by piece between points of the road; when the contact changes."""
    t, y, closed, changes = 0.0, rest(), True, []
    values = np.zeros((instants.size, 4))
    for _, edge in pairwise([0.0, *(x / SPEED for x in ROAD.x[1:] if x / SPEED < 1.0), 1.0]):
        while t < edge:

            def changed(t: float, y: np.ndarray, sign: int = 1 if closed else -1) -> float:
                return sign * moment(t, y).margin

            changed.terminal, changed.direction = True, 1  # type: ignore[attr-defined]
            run = solve_ivp(lambda t, y, c=closed: moment(t, y, c).rates, (t, edge), y, "DOP853",
                            rtol=1e-12, atol=1e-13, dense_output=True, events=changed)  # fmt: skip
            here = (instants >= t) & (instants <= run.t[-1])
            values[here] = run.sol(instants[here]).T
            t, y = run.t[-1], run.y[:, -1]
            if run.t_events[0].size:
                closed = not closed
                changes.append(t)
    return values, changes


@pytest.fixture(scope="module")
def driven() -> Result:
    machine = load("quarter_car", "bump")
    return machine.simulate(1.0, start=machine.equilibrium(), rtol=1e-11, atol=1e-12)


@pytest.fixture(scope="module")
def exact(driven: Result) -> tuple[np.ndarray, list[float]]:
    return motion(driven.t)


def test_the_linkage_has_the_slopes_of_its_values() -> None:
    step = 1e-4
    for theta in (-0.2, 0.0, 0.2):
        low, at, high = (linkage(theta + k * step) for k in (-1, 0, 1))
        for value, slope in (("angles", "slopes"), ("slopes", "bends"), ("places", "rates"),
                             ("rates", "curves")):  # fmt: skip
            difference = (getattr(high, value) - getattr(low, value)) / (2 * step)
            assert np.abs(difference - getattr(at, slope)).max() < 1e-7


def test_it_rests_where_the_forces_balance() -> None:
    found = load("quarter_car", "bump").equilibrium()
    height, theta, *_ = rest()
    assert abs(found.q("chassis.y")[0] - height) < LIMIT
    assert abs(found.q("lower.phi")[0] - theta) < LIMIT


def test_it_goes_over_the_bump(driven: Result, exact: tuple[np.ndarray, list[float]]) -> None:
    states, _ = exact
    assert driven.outcome is Outcome.OK
    for name, column in (("chassis.y", 0), ("lower.phi", 1)):
        assert np.abs(driven.q(name) - states[:, column]).max() < LIMIT
        assert np.abs(driven.v(name) - states[:, column + 2]).max() < LIMIT
    assert np.ptp(states[:, 0]) > 0.03


def test_its_forces_and_lengths_have_names(
    driven: Result, exact: tuple[np.ndarray, list[float]]
) -> None:
    states, changes = exact
    found = [moment(t, y) for t, y in zip(driven.t, states, strict=True)]
    at = [linkage(theta) for theta in states[:, 1]]
    travel = np.array([place.places[2, 1] for place in at])
    for series, values in (
        (driven.force("tyre"), np.array([m.load for m in found])),
        (driven.force("strut"), np.array([m.pull for m in found])),
        (driven.length("strut"), np.array([m.length for m in found])),
        (driven.q("upright.y") - driven.q("chassis.y"), travel),
    ):
        assert np.abs(series - values).max() < LIMIT * np.abs(values).max()
    lost = (driven.t > changes[0]) & (driven.t < changes[1])
    assert lost.sum() > 10
    assert not driven.force("tyre")[lost].any()


def test_the_wheel_leaves_the_road_once(
    driven: Result, exact: tuple[np.ndarray, list[float]]
) -> None:
    """The damper is cut off, then the gap opens; then it closes, and the damper acts again.

    Neither the pieces of the road nor its knots are events.
    """
    _, changes = exact
    assert len(changes) == 2
    assert len(driven.events) == 4
    assert abs(driven.events[0].time - changes[0]) < LIMIT
    assert abs(driven.events[-1].time - changes[1]) < LIMIT
