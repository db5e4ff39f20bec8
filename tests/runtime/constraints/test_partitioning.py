"""The choice of independent coordinates, against numpy and by hand."""

import numpy as np
import pytest

from runtime.constraints.partitioning import choose_independent, order_by_pivots
from tests.runtime.constraints.drivers import column_norm, driven_velocities, lever
from tests.runtime.integrate.systems import PENDULUM, PENDULUM_P


def test_rank_and_the_redundant_row():
    rng = np.random.default_rng(1)
    full = rng.normal(size=(4, 7))
    full = np.vstack([full, full[1] - 2.0 * full[3]])
    rows, columns = np.zeros(5, np.int64), np.zeros(7, np.int64)
    assert order_by_pivots(full.copy(), np.ones(7), rows, columns) == 4
    assert rows[4] in (1, 3, 4)
    dependent = full[rows[:4]][:, columns[:4]]
    assert np.linalg.cond(dependent) < 1e3
    # Units do not matter: coordinate 2 in millimetres.
    units = np.array([1.0, 1.0, 1e3, 1.0, 1.0, 1.0, 1.0])
    other_rows, other = np.zeros(5, np.int64), np.zeros(7, np.int64)
    assert order_by_pivots(full / units, units, other_rows, other) == 4
    assert np.array_equal(other, columns)


@pytest.mark.parametrize(("phi", "independent"), [(0.3, 1), (1.3, 0), (-1.3, 0), (3.0, 1)])
def test_the_coordinate_that_describes_the_motion_well(phi, independent):
    """Along the rod of a pendulum the motion is across; its heavy angle is dependent."""
    scale = np.array([1.0, 2.0, 1e3])
    weights, dense = np.full(3, 9.0), np.empty((2, 3))
    rows, columns = np.zeros(2, np.int64), np.zeros(3, np.int64)
    rank = choose_independent(
        PENDULUM.jacobian, 0.0, np.array([np.cos(phi), np.sin(phi), phi]), PENDULUM_P, scale,
        PENDULUM.jacobian_rows, PENDULUM.jacobian_columns, np.empty(4), dense, weights, rows,
        columns,
    )  # fmt: skip
    assert rank == 2
    assert columns[2] == independent
    expected = scale**2
    expected[independent] = 0.0
    np.testing.assert_array_equal(weights, expected)


WEIGHTS = np.array([0.0, 4.0, 0.0])
SCALES = np.array([0.5, 2.0, 8.0])


def lever_norm(independent):
    probe, dq, dv, driven = np.empty((4, 3))
    return column_norm(
        lever, 1.0, independent, np.zeros(3), PENDULUM_P, WEIGHTS, SCALES, probe, dq, dv, driven
    )


def test_driven_velocities_are_those_of_independent_coordinates_at_rest():
    probe, dq, dv = np.ones((3, 3))
    driven_velocities(lever, 1.0, np.zeros(3), PENDULUM_P, WEIGHTS, probe, dq, dv)
    np.testing.assert_array_equal(dv, [0.0, 3.0, 0.0])


def test_the_norm_of_a_column_is_scaled_and_without_the_drivers():
    assert lever_norm(0) == pytest.approx(2.0 * 0.5 / 2.0)
    assert lever_norm(2) == pytest.approx(0.5 * 8.0 / 2.0)


def test_all_columns_are_probed_at_once_with_drawn_signs():
    """Of two columns the sum and the difference are seen, whichever is drawn."""
    seen = {round(lever_norm(-k), 12) for k in range(1, 30)}
    assert seen == {1.5, 2.5}


def test_a_column_that_is_not_finite_is_infinite():
    probe, dq, dv, driven = np.empty((4, 3))
    singular = np.array([0.0, 1.0, 1.0])
    at = np.array([1.0, 0.0, 0.0])
    found = column_norm(
        PENDULUM.correction, 0.0, 0, at, PENDULUM_P, singular, np.ones(3), probe, dq, dv, driven
    )
    assert found == np.inf
