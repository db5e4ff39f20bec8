"""The table by which compiled searches reach a mechanism: units, scales and the order of rows."""

import numpy as np

from runtime.singularity.search_function_table import set_units, unit_jacobian_entries
from tests.runtime.singularity.crossing import closed, gaps_by_place, mechanism

SCALE, SPEED, T = np.array([2.0, 0.5, 10.0]), 4.0, 0.3
Q = closed(0.4, -0.7) + np.array([0.0, 0.0, 0.05])
Z = np.append(Q / SCALE, T * SPEED)


def scaled_jacobian(scaled):
    """Φ_q scale and Φ_t / speed by differences of Φ, (2, 4)."""
    columns = []
    for j in range(4):
        ends = []
        for sign in (1.0, -1.0):
            z = Z.copy()
            z[j] += sign * 1e-6
            ends.append(scaled.gaps(z[3] / SPEED, z[:3] * SCALE))
        columns.append((ends[0] - ends[1]) / 2e-6)
    return np.column_stack(columns)


def test_entries_are_those_of_unit_rows():
    scaled = mechanism(c=0.5, gap=0.1, k=0.3, d=0.8, scale=tuple(SCALE))
    table, arrays = scaled.layout
    set_units(table, SPEED, Z)
    expected = scaled_jacobian(scaled)
    lengths = np.linalg.norm(expected[:, :3], axis=1)
    np.testing.assert_allclose(arrays["lengths"], lengths, rtol=1e-8)
    values = np.empty(8)
    unit_jacobian_entries(table, Z, values)
    np.testing.assert_allclose(scaled.dense(values), expected / lengths[:, None], atol=1e-8)


def test_values_are_divided_by_the_lengths_and_stand_in_the_order_of_rows():
    scaled = mechanism(gap=0.1, scale=tuple(SCALE))
    table, arrays = scaled.layout
    set_units(table, SPEED, Z)
    arrays["row_place"][:] = [1, 0]
    gaps_by_place(table, Z, arrays["residuals"])
    expected = scaled.gaps(T, Q) / arrays["lengths"]
    np.testing.assert_allclose(arrays["residuals"], expected[::-1], rtol=1e-14)


def test_rows_set_aside_have_no_entries():
    scaled = mechanism()
    scaled.independent = np.array([1])
    table, arrays = scaled.layout
    set_units(table, SPEED, Z)
    values = np.empty(8)
    unit_jacobian_entries(table, Z, values)
    assert scaled.dense(values).shape == (1, 4)
    assert not values[[0, 1, 2, 6]].any()
    assert arrays["lengths"].shape == (1,)


def test_an_empty_row_keeps_its_length():
    scaled = mechanism(c=0.0)
    table, arrays = scaled.layout
    set_units(table, 1.0, np.zeros(4))
    np.testing.assert_array_equal(arrays["lengths"], [1.0, 1.0])
