"""Constraints in comparable units, against differences of their values."""

import numpy as np

from tests.runtime.singularity.crossing import closed, mechanism

SCALE, T, Q = (2.0, 0.5, 10.0), 0.3, closed(0.4, -0.7)


def test_entries_are_derivatives_by_scaled_coordinates_and_time():
    scaled = mechanism(k=0.3, d=0.8, scale=SCALE)
    entries = scaled.entries(T, Q, 0.25)
    h = 1e-6
    columns = [
        (scaled.gaps(T, Q + h * s * e) - scaled.gaps(T, Q - h * s * e)) / (2 * h)
        for s, e in zip(SCALE, np.eye(3), strict=True)
    ]
    columns.append(0.25 * (scaled.gaps(T + h, Q) - scaled.gaps(T - h, Q)) / (2 * h))
    np.testing.assert_allclose(scaled.dense(entries), np.column_stack(columns), atol=1e-8)


def test_dependent_rows_are_set_aside():
    scaled = mechanism()
    scaled.independent = np.array([1])
    assert scaled.gaps(T, Q).shape == (1,)
    rows, columns = scaled.places
    np.testing.assert_array_equal(rows, [1, 1, 1, 0, 0, 0, 1, 0])
    np.testing.assert_array_equal(columns, [0, 1, 2, 0, 1, 2, 3, 3])
    dense = scaled.dense(scaled.entries(T, Q, 1.0))
    np.testing.assert_allclose(dense[0, :3], [2 * 0.4, 2 * 0.7, 0.5])
