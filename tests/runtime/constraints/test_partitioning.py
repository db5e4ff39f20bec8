"""The choice of independent coordinates, against numpy and by hand."""

from dataclasses import replace

import numpy as np
import pytest

from runtime.constraints.partitioning import order_by_pivots
from runtime.core.workspace_rows import PARTITION, UNIT, Y1
from tests.runtime.constraints.drivers import choose_independent, column_norm, lever, wired
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
    wiring, workspace = wired(scale=scale)
    at = np.array([np.cos(phi), np.sin(phi), phi])
    rank = choose_independent(wiring.table, 0.0, at)
    columns, weights = wiring.arrays["column_order"], workspace[PARTITION, 0]
    assert rank == 2
    assert columns[2] == independent
    expected = scale**2
    expected[independent] = 0.0
    np.testing.assert_array_equal(weights, expected)


WEIGHTS = np.array([0.0, 4.0, 0.0])
LEVER = replace(PENDULUM, correction=lever)


def lever_norm(independent):
    """The norm, and the velocities with the independent coordinates at rest."""
    wiring, workspace = wired(LEVER, PENDULUM_P, np.array([0.5, 2.0, 8.0]))
    workspace[PARTITION, 0], workspace[UNIT] = WEIGHTS, 1.0
    return column_norm(wiring.table, 1.0, independent), workspace[UNIT, 1]


def test_driven_velocities_are_those_of_independent_coordinates_at_rest():
    np.testing.assert_array_equal(lever_norm(0)[1], [0.0, 3.0, 0.0])


def test_the_norm_of_a_column_is_scaled_and_without_the_drivers():
    assert lever_norm(0)[0] == pytest.approx(2.0 * 0.5 / 2.0)
    assert lever_norm(2)[0] == pytest.approx(0.5 * 8.0 / 2.0)


def test_all_columns_are_probed_at_once_with_drawn_signs():
    """Of two columns the sum and the difference are seen, whichever is drawn."""
    seen = {round(lever_norm(-k)[0], 12) for k in range(1, 30)}
    assert seen == {1.5, 2.5}


def test_a_column_that_is_not_finite_is_infinite():
    wiring, workspace = wired(scale=np.ones(3))
    workspace[PARTITION, 0], workspace[Y1, 0] = [0.0, 1.0, 1.0], [1.0, 0.0, 0.0]
    assert column_norm(wiring.table, 0.0, 0) == np.inf
