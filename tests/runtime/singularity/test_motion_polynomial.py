"""Polynomials in time: derivatives at their nodes, convergence, nearest points."""

import numpy as np
import pytest
from numpy.polynomial import polynomial

from runtime.singularity.motion_polynomial import (
    Motion,
    distance,
    evaluate,
    hermite,
    interpolate,
    nearest_time,
    taylor,
)


def derivatives(series, s, orders):
    """Derivatives of these orders after the time s."""
    return tuple(
        polynomial.polyval(s, polynomial.polyder(series, k) if k else series) for k in orders
    )


@pytest.mark.parametrize(
    ("nodes", "orders"),
    [
        ((0, 0, 0), (0, 1, 2)),
        ((0, 0, 0, 1, 1, 1), (0, 1, 2, 0, 1, 2)),
        ((0, 0, -2.3, -1.3, 0.7, 1.7), (0, 1, 2, 2, 2, 2)),
        ((-1, 1, -2, 2, -1, 1, -2, 2), (0, 0, 0, 0, 1, 1, 1, 1)),
    ],
)
@pytest.mark.parametrize("unit", [1.0, 1e-3])
def test_a_polynomial_is_known_by_its_derivatives(nodes, orders, unit):
    series = np.random.default_rng(1).normal(size=(len(nodes), 4))
    values = [
        derivatives(series, unit * x, (order,))[0] for x, order in zip(nodes, orders, strict=True)
    ]
    found = interpolate(2.0, unit, nodes, orders, np.stack(values))
    assert found.t == 2.0
    powers = unit ** np.arange(len(nodes))[:, None]
    np.testing.assert_allclose(found.series * powers, series * powers, atol=1e-12)


def test_the_error_of_a_quintic_is_of_sixth_order():
    """sin t over steps of length h: what lies between errs by h⁶ / 46080."""
    errors = []
    for h in (0.8, 0.4, 0.2):
        ends = [
            tuple(np.array([f]) for f in (np.sin(t), np.cos(t), -np.sin(t))) for t in (1.0, 1.0 + h)
        ]
        middle = hermite(1.0, h, *ends).at(0.5 * h)[0][0]
        errors.append(abs(middle - np.sin(1.0 + 0.5 * h)))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 6.0, atol=0.3)
    assert errors[0] == pytest.approx(0.8**6 * np.sin(1.4) / 46080, rel=0.1)


def test_position_and_velocity_after_a_time():
    motion = taylor(1.0, np.array([1.0, 2.0]), np.array([3.0, -1.0]), np.array([4.0, 0.0]))
    q, v = motion.at(0.5)
    np.testing.assert_allclose(q, [1.0 + 1.5 + 0.5, 1.5])
    np.testing.assert_allclose(v, [5.0, -1.0])
    np.testing.assert_array_equal(motion.position, [1.0, 2.0])
    np.testing.assert_array_equal(motion.velocity, [3.0, -1.0])


def test_scaled_motions_have_time_as_a_coordinate():
    series = np.random.default_rng(2).normal(size=(4, 3))
    scale = np.array([1.0, 2.0, 0.5])
    scaled = Motion(0.7, series).scaled(scale, 5.0).series
    z, rate = np.empty((2, 4))
    evaluate(scaled, 0.2, z, rate)
    q, v = derivatives(series, 0.2, (0, 1))
    np.testing.assert_allclose(z, [*(q / scale), 0.9 * 5.0])
    np.testing.assert_allclose(rate, [*(v / scale), 5.0])


def test_a_motion_is_nearest_to_a_place_that_it_passes_when_it_passes_it():
    series = np.random.default_rng(1).normal(size=(6, 4))
    passed = Motion(2.0, series).scaled(np.ones(4), 1.0).series
    z = derivatives(series, 0.1, (0,))[0]
    s = nearest_time(passed, 0.11, z)
    assert s == pytest.approx(0.1, abs=1e-6)
    assert distance(passed, s, z) < 1e-5
    # Beside it, the way there is across the motion.
    aside = np.linalg.svd(derivatives(series, 0.1, (1,)))[2][-1]
    z += 0.01 * aside
    assert distance(passed, nearest_time(passed, 0.1, z), z) == pytest.approx(0.01, rel=0.05)
