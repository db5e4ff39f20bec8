"""Closed forms in space against integrations, laws of conservation, and each other."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests.space.closed_forms import (
    FlyballGovernor,
    SpatialSliderCrank,
    SwashPlate,
    universal_joint_angle,
    universal_joint_ratio,
)
from tests.space.free_body import FreeBody
from tests.space.heavy_top import G, HeavyTop, fall_of_upright_top, sleeping_limit

FLIPPING = (1.0, 2.0, 3.0), (0.1, 5.0, 0.2)


def turned(
    J: Any, weight: Any, omega: Any, attitude: Any, end: float
) -> tuple[Any, Any]:  # fmt: skip
    """ω′ and R of a body on a fixed point, with m g times the centre's place, at the end."""
    J = np.diag(J)

    def rates(_: float, y: Any) -> Any:
        R, w = y[:9].reshape(3, 3), y[9:]
        moment = np.cross(weight, -R[2])
        across = np.cross(w, np.eye(3)).T
        return np.concatenate(
            [(R @ across).ravel(), np.linalg.solve(J, moment - np.cross(w, J @ w))]
        )

    start = np.concatenate([np.ravel(attitude), omega])
    y = solve_ivp(rates, (0, end), start, method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    return y[9:], y[:9].reshape(3, 3)


@pytest.mark.parametrize(
    ("moments", "omega"),
    [
        FLIPPING,
        ((3, 2, 1), (0.01, 5, 0.02)),
        ((2, 1, 3), (-3, 0.3, 0.1)),
        ((1, 3, 2), (1, -2, 0.4)),
        ((1, 2, 3), (2, 0.5, -3)),
        ((3, 1, 2), (0.1, -0.2, -3)),
        ((2, 3, 1), (0.3, 0.1, -2)),
    ],
)
def test_a_free_body_turns_as_integrated(moments: Any, omega: Any) -> None:
    """In every order of moments, about every axis."""
    attitude = Rotation.from_rotvec([0.3, -0.8, 1.1]).as_matrix()
    body = FreeBody(moments, omega, attitude)
    np.testing.assert_allclose(body.omega(0.0), omega, atol=1e-15)
    np.testing.assert_allclose(body.attitude(0.0), attitude, atol=1e-15)
    w, R = turned(moments, np.zeros(3), omega, attitude, 3.0)
    np.testing.assert_allclose(body.omega(3.0), w, atol=1e-12)
    np.testing.assert_allclose(body.attitude(3.0), R, atol=1e-12)


def test_a_body_that_flips_keeps_momentum_and_energy_for_fifty_flips() -> None:
    moments, omega = (np.array(x) for x in FLIPPING)
    body = FreeBody(moments, omega)
    for flips in (1, 7.3, 25, 50):
        t = flips * body.flip_time
        w, R = body.omega(t), body.attitude(t)
        np.testing.assert_allclose(R @ (moments * w), moments * omega, atol=1e-13)
        assert moments @ w**2 == pytest.approx(moments @ omega**2, rel=1e-14)
        np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-14)
    assert body.omega(body.flip_time) == pytest.approx([-0.1, -5.0, 0.2], rel=1e-13)
    assert body.omega(50 * body.flip_time) == pytest.approx(omega, rel=1e-13)


def test_a_body_that_flips_turns_at_its_rate_after_fifty_flips() -> None:
    body, h = FreeBody(*FLIPPING), 1e-5
    for t in (50 * body.flip_time, 49.5 * body.flip_time):
        R, w = body.attitude(t), body.omega(t)
        rate = (body.attitude(t + h) - body.attitude(t - h)) / (2 * h)
        np.testing.assert_allclose(R.T @ rate, np.cross(w, np.eye(3)).T, atol=2e-8)


def test_a_body_that_flips_agrees_with_an_integration_over_five_flips() -> None:
    """In extended precision, by Gragg's method with extrapolation."""
    moments, omega = FLIPPING
    body = FreeBody(moments, omega)
    end = 5 * body.flip_time
    found = extended(moments, omega, end)
    assert np.abs(body.omega(end) - found[1]).max() < 1e-12
    assert np.abs(body.attitude(end) - found[0]).max() < 1e-12


def extended(moments: Any, omega: Any, end: float, size: float = 0.03) -> tuple[Any, Any]:
    """R and ω′ by the midpoint rule of order 16 in long double."""
    J = np.array(moments, np.longdouble)
    counts = np.arange(2, 18, 2)
    steps = int(np.ceil(end / size))
    H = np.longdouble(end) / steps
    inertia = (J[[1, 2, 0]] - J[[2, 0, 1]]) / J
    after, before = [1, 2, 0], [2, 0, 1]

    def rates(y: Any) -> Any:
        w, R = y[3], y[:3]
        turning = R[:, after] * w[before] - R[:, before] * w[after]
        return np.vstack([turning, inertia * w[after] * w[before]])

    def midpoint(y: Any, n: int) -> Any:
        h = H / n
        last, now = y, y + h * rates(y)
        for _ in range(n - 1):
            last, now = now, last + 2 * h * rates(now)
        return 0.5 * (last + now + h * rates(now))

    y = np.vstack([np.eye(3), omega]).astype(np.longdouble)
    for _ in range(steps):
        table: list[Any] = []
        for k, n in enumerate(counts):
            row = [midpoint(y, int(n))]
            for j in range(1, k + 1):
                ratio = (np.longdouble(n) / counts[k - j]) ** 2
                row.append(row[j - 1] + (row[j - 1] - table[j - 1]) / (ratio - 1))
            table = row
        y = table[-1]
    return y[:3], y[3]


@pytest.mark.parametrize("seed", range(4))
def test_a_heavy_top_turns_as_integrated(seed: int) -> None:
    random = np.random.default_rng(seed)
    attitude = Rotation.from_quat(random.normal(size=4)).as_matrix()
    omega = 4 * random.normal(size=3)
    top = HeavyTop(2.0, 0.3, 0.1, 0.05, omega, attitude)
    np.testing.assert_allclose(top.attitude(0.0), attitude, atol=1e-15)
    _, R = turned((0.28, 0.28, 0.05), [0, 0, 2 * G * 0.3], omega, attitude, 3.0)
    np.testing.assert_allclose(top.attitude(3.0), R, atol=1e-12)


def test_a_heavy_top_nutates_between_two_angles() -> None:
    attitude = Rotation.from_rotvec([0.9, 0, 0]).as_matrix()
    top = HeavyTop(2.0, 0.3, 0.1, 0.05, (0, 0, 60.0), attitude)
    least, most = top.nutation
    assert least == pytest.approx(0.9, rel=1e-14)  # let go at rest, it falls first
    times = np.linspace(0, top.nutation_period, 41)
    angles = [float(np.arccos(top.attitude(t)[2, 2])) for t in times]
    assert angles[0] == pytest.approx(least)
    assert angles[-1] == pytest.approx(least)
    assert max(angles) == pytest.approx(most, rel=1e-12)


def test_the_heavy_top_that_lies_at_the_start_reaches_its_known_place() -> None:
    """15 kg at 1 m, 150 rad/s about its axis y′, -4.61538 rad/s about z′."""
    axes = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])  # the top's z′ along y
    top = HeavyTop(15.0, 1.0, 0.234375, 0.46875, axes.T @ [0, 150.0, -4.61538], axes)
    place = top.attitude(1.0)[:, 2]
    np.testing.assert_allclose(place, [0.17334396, 0.64008859, -0.74849079], atol=5e-9)
    moments = (15.234375, 0.46875, 15.234375)
    _, R = turned(moments, [0, 15 * G, 0], (0, 150, -4.61538), np.eye(3), 1.0)
    np.testing.assert_allclose(R[:, 1], place, atol=1e-12)


def test_a_top_sleeps_above_its_limit_alone() -> None:
    numbers = 2.0, 0.3, 0.1, 0.05
    limit = sleeping_limit(*numbers)
    assert limit == pytest.approx(2 * np.sqrt(2 * G * 0.3 * 0.28) / 0.05)
    slightly = Rotation.from_rotvec([1e-6, 0, 0]).as_matrix()
    for share in (0.8, 0.99, 1.01):
        top = HeavyTop(*numbers, (0, 0, share * limit), slightly)
        fall = fall_of_upright_top(share * limit, *numbers)
        assert top.nutation[1] == pytest.approx(fall, abs=1e-5)
        assert (fall == 0.0) == (share > 1)


def test_the_second_shaft_turns_at_the_ratio_of_the_universal_joint() -> None:
    h = 1e-5
    for bend in (0.3, 1.2):
        for angle in np.linspace(-7, 7, 23):
            ends = [universal_joint_angle(angle + s * h, bend) for s in (-1, 1)]
            rate = (ends[1] - ends[0]) / (2 * h)
            assert rate == pytest.approx(universal_joint_ratio(angle, bend), rel=1e-7)


@pytest.mark.parametrize(
    ("rod", "least", "most", "largest"),
    [(0.3, 0.18496, 0.29016, 2.667), (0.27, None, None, 3.772), (0.24, None, None, 11.605)],
)
def test_the_spatial_slider_crank_moves_as_known(
    rod: float, least: float | None, most: float | None, largest: float
) -> None:
    form = SpatialSliderCrank(rod)
    if least is not None:
        assert form.extremes(0, 1.0) == pytest.approx((least, most), abs=1e-5)
    assert form.extremes(2, 2 * np.pi)[1] == pytest.approx(largest, abs=5e-4)
    assert form.lock_up == pytest.approx(0.236205, abs=5e-7)


@pytest.mark.parametrize(
    ("tilt", "stroke", "largest"), [(20, 0.13681, 241), (30, 0.2, 372), (40, 0.25712, 630)]
)
def test_the_swash_plate_moves_its_pistons_as_known(
    tilt: float, stroke: float, largest: float
) -> None:
    plate = SwashPlate(np.radians(tilt))
    assert plate.stroke == pytest.approx(stroke, abs=5e-6)
    heights = [float(plate.piston(a, np.pi / 2)) for a in np.linspace(0, 2 * np.pi, 361)]
    assert max(heights) - min(heights) == pytest.approx(plate.stroke, rel=1e-12)
    assert plate.largest_acceleration(20 * np.pi) == pytest.approx(largest, abs=0.5)


@pytest.mark.parametrize(
    ("gain", "height", "speed"),
    [(7500, 0.046667, 10.2959), (12500, 0.048, 10.5875), (17500, 0.048571, 10.7121)],
)
def test_the_governor_is_steady_as_known(gain: float, height: float, speed: float) -> None:
    found = FlyballGovernor().steady(gain)
    assert found == pytest.approx((height, speed), rel=1e-5)
