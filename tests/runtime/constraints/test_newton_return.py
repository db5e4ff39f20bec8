"""The return onto the constraints of a pendulum in Cartesian coordinates."""

import numpy as np
import pytest

from runtime.constraints.newton_return import FAILED
from runtime.core.workspace_rows import PARTITION, PROJECTION, Y1
from tests.runtime.constraints.drivers import SCALE, return_to_constraints, wired


def residuals(q, v):
    c, s = np.cos(q[2]), np.sin(q[2])
    return np.array([q[0] - c, q[1] - s, v[0] + s * v[2], v[1] - c * v[2]])


def off_the_constraints(rows, phi=0.6, by=1e-2):
    rows[Y1] = [np.cos(phi), np.sin(phi), phi], [0.5, -0.3, 0.2]
    rows[Y1, 0] += by * np.array([1.0, -2.0, 0.5])
    return rows[Y1].copy()


def test_independent_coordinates_stay():
    wiring, rows = wired()
    rows[PARTITION, 0] = [1.0, 0.0, 100.0]
    before = off_the_constraints(rows)
    done = return_to_constraints(wiring.table, 0.0, Y1, PARTITION)
    assert 3 <= done <= 6
    np.testing.assert_array_equal(rows[Y1, :, 1], before[:, 1])
    assert np.abs(residuals(*rows[Y1])).max() < 2e-16 * 4


@pytest.mark.parametrize("by", [1e-2, 1e-4])
def test_a_projection_is_the_least_change_in_the_metric_of_the_masses(by):
    wiring, rows = wired()
    before = off_the_constraints(rows, by=by)
    assert return_to_constraints(wiring.table, 0.0, Y1, PROJECTION) > 0
    assert np.abs(residuals(*rows[Y1])).max() < 1e-15
    phi = rows[Y1, 0, 2]
    along = np.array([-np.sin(phi), np.cos(phi), 1.0])
    change = (rows[Y1, 0] - before[0]) / SCALE**2
    # But for the curvature of the constraints, the change has nothing along the motion.
    assert abs(change @ along) < 10.0 * by * np.linalg.norm(change)
    by_velocity = (rows[Y1, 1] - before[1]) / SCALE**2
    assert abs(by_velocity @ along) < (1e-14 if by == 0.0 else 10.0 * by)


def test_convergence_is_quadratic():
    """From an error of 1e-3 in the position two steps reach rounding, and a third one sees it."""
    calls = []
    for by in (1e-1, 1e-3, 1e-6, 0.0):
        wiring, rows = wired()
        rows[PARTITION, 0] = [1.0, 0.0, 100.0]
        off_the_constraints(rows, by=by)
        calls.append(return_to_constraints(wiring.table, 0.0, Y1, PARTITION))
    assert calls == sorted(calls, reverse=True)
    assert calls[0] <= 6
    assert calls[1] <= 4
    assert calls[2] <= 3


def test_a_state_at_rest_keeps_its_bits():
    wiring, rows = wired()
    rows[PARTITION, 0] = [1.0, 0.0, 100.0]
    rows[Y1, 0] = np.cos(0.6), np.sin(0.6), 0.6
    rows[Y1, 0, 0] += 1e-16
    before = rows[Y1].copy()
    assert return_to_constraints(wiring.table, 0.0, Y1, PARTITION) == 1
    np.testing.assert_array_equal(rows[Y1], before)


def test_a_weak_pivot_is_reported_with_the_result():
    """x is no independent coordinate where its rod lies along it."""
    wiring, rows = wired()
    rows[PARTITION, 0] = [0.0, 1.0, 1.0]
    rows[Y1, 0] = np.cos(1e-7), np.sin(1e-7), 1e-7
    assert return_to_constraints(wiring.table, 0.0, Y1, PARTITION) >= 1
    assert wiring.arrays["record"][0]["weak_return"] == 1


@pytest.mark.parametrize("phi", [np.nan, np.inf])
def test_what_is_not_finite_does_not_converge(phi):
    wiring, rows = wired()
    rows[PARTITION, 0] = [1.0, 0.0, 100.0]
    rows[Y1, 0] = 1.0, 0.0, phi
    assert return_to_constraints(wiring.table, 0.0, Y1, PARTITION) == FAILED


def test_no_position_has_such_a_coordinate():
    """With y = 1.3 held the rod of length 1 closes nowhere."""
    wiring, rows = wired()
    rows[PARTITION, 0] = [1.0, 0.0, 100.0]
    rows[Y1, 0] = 0.0, 1.3, 1.2
    assert return_to_constraints(wiring.table, 0.0, Y1, PARTITION) == FAILED
