"""Elimination by rows: pivots, their product, and rows that follow from others."""

import numpy as np
import pytest

from tests.runtime.linalg.drivers import eliminate_rows, fill_unit_rows


def sparse(dense):
    rows, columns = (np.ascontiguousarray(places) for places in np.nonzero(dense))
    return rows, columns, np.ascontiguousarray(dense[rows, columns])


def test_unit_rows_of_a_jacobian_in_scaled_coordinates():
    random = np.random.default_rng(2)
    jacobian = np.where(random.random((3, 5)) < 0.6, random.normal(size=(3, 5)), 0.0)
    jacobian[2] = 0.0
    rows, columns, entries = sparse(jacobian)
    rates = random.normal(size=entries.size)
    scale, dense = np.array([1.0, 10.0, 0.1, 2.0, 1.0]), np.full((3, 5), 7.0)
    fill_unit_rows(
        0.5, np.concatenate([entries, rates]), scale, rows, columns, np.zeros(entries.size), dense,
    )  # fmt: skip
    expected = np.zeros((3, 5))
    expected[rows, columns] = (entries + 0.5 * rates) * scale[columns]
    expected[:2] /= np.linalg.norm(expected[:2], axis=1)[:, None]
    np.testing.assert_allclose(dense, expected, rtol=1e-14)


@pytest.mark.parametrize("seed", range(4))
def test_the_product_of_pivots_is_the_determinant_but_for_its_sign(seed):
    random = np.random.default_rng(seed)
    square = random.normal(size=(6, 6))
    order, pivots = np.zeros(6, np.int64), np.zeros(6)
    least = eliminate_rows(square.copy(), order, pivots, 1)
    assert sorted(order) == list(range(6))
    assert abs(np.prod(pivots)) == pytest.approx(abs(np.linalg.det(square)), rel=1e-10)
    assert least == np.abs(pivots).min(initial=1.0)
    # In the order found, the pivots of another matrix change sign with its determinant.
    other, same = random.normal(size=(6, 6)), np.zeros(6)
    eliminate_rows(other.copy(), order, same, 0)
    sign = np.sign(np.linalg.det(square) * np.linalg.det(other))
    assert np.sign(np.prod(pivots) * np.prod(same)) == sign


def test_a_row_that_follows_from_others_has_no_pivot_and_changes_none():
    random = np.random.default_rng(8)
    rows = random.normal(size=(4, 6))
    matrix = np.vstack([rows[:2], rows[0] - 2.0 * rows[1], rows[2:]])
    order, pivots = np.zeros(5, np.int64), np.zeros(5)
    least = eliminate_rows(matrix, order, pivots, 1)
    assert abs(pivots[2]) < 1e-14
    assert least == min(1.0, np.abs(pivots[[0, 1, 3, 4]]).min())
    alone = np.zeros(4)
    eliminate_rows(rows, np.zeros(4, np.int64), alone, 1)
    np.testing.assert_allclose(alone, pivots[[0, 1, 3, 4]], rtol=1e-12)
