"""When a partition is poor, chosen anew, and logged."""

import numpy as np

from runtime.constraints.repartitioning import GROWTH_LIMIT
from runtime.core.workspace_rows import PARTITION, Y0, Y1
from tests.runtime.constraints.drivers import is_poorly_chosen, repartition, wired

SCALE = np.array([1.0, 1.0, 1e3])


def swinging(rows, row, phi, omega):
    rows[row, 0] = np.cos(phi), np.sin(phi), phi
    rows[row, 1] = -np.sin(phi) * omega, np.cos(phi) * omega, omega


def begun(phi=0.3):
    wiring, rows = wired(scale=SCALE)
    r = wiring.arrays["record"][0]
    r["growth_limit"] = r["ratio_limit"] = GROWTH_LIMIT
    swinging(rows, Y0, phi, 1.0)
    assert repartition(wiring.table, 0.0, Y0) == 1
    return wiring, rows, r


def test_a_new_choice_is_logged():
    wiring, rows, r = begun()
    assert r["rank"] == 2
    assert (rows[PARTITION, 0] == 0.0).tolist() == [False, True, False]
    swinging(rows, Y0, 1.3, 1.0)
    assert repartition(wiring.table, 2.5, Y0) == 1
    assert (rows[PARTITION, 0] == 0.0).tolist() == [True, False, False]
    assert r["logged_repartitions"] == r["repartitions"] == 2
    np.testing.assert_array_equal(wiring.arrays["log_times"][:2], [0.0, 2.5])
    np.testing.assert_array_equal(wiring.arrays["log_sets"][:2], [[0, 1, 0], [1, 0, 0]])
    assert r["growth_limit"] == r["ratio_limit"] == GROWTH_LIMIT


def test_the_same_choice_doubles_the_limits_and_is_not_logged():
    wiring, rows, r = begun()
    before = rows[PARTITION].copy()
    assert repartition(wiring.table, 0.1, Y0) == 0
    assert r["growth_limit"] == r["ratio_limit"] == 2.0 * GROWTH_LIMIT
    assert r["logged_repartitions"] == 1
    np.testing.assert_array_equal(rows[PARTITION], before)


def test_a_choice_is_poor_where_dependent_coordinates_run_away():
    wiring, rows, _ = begun()
    swinging(rows, Y1, 0.4, 1.0)
    assert is_poorly_chosen(wiring.table, 0.0) == 0
    swinging(rows, Y1, 1.5, 1.0)  # x moves fourteen times as fast as y
    assert is_poorly_chosen(wiring.table, 0.0) == 1


def test_a_machine_at_rest_is_probed_every_few_steps():
    wiring, rows, r = begun()
    swinging(rows, Y1, 1.5, 0.0)
    r["check_in"] = 3
    assert [is_poorly_chosen(wiring.table, 0.0) for _ in range(3)] == [0, 0, 1]
    assert r["corrections"] == 2
    swinging(rows, Y1, 0.4, 0.0)
    assert [is_poorly_chosen(wiring.table, 0.0) for _ in range(4)] == [0, 0, 0, 0]
    assert r["corrections"] == 4
