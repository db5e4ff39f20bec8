"""The Schur complement of a mechanism's Jacobian, against dense linear algebra."""

import numpy as np
import pytest

from runtime.linalg.dense_elimination import factor_fully
from runtime.singularity.schur_complement import reduce_to_weak_part
from runtime.singularity.search_function_table import set_units, unit_jacobian_entries
from tests.runtime.singularity.crossing import closed, mechanism
from tests.runtime.singularity.drivers import lost_gap


def u_first(arrays):
    """Eliminate the first row with u."""
    arrays["column_order"][:] = [2, 0, 1, 3]
    arrays["column_place"][:] = [1, 2, 0, 3]


@pytest.mark.parametrize("distance", [0.1, 0.01])
def test_the_complement_is_the_small_singular_value(distance):
    """But for the square of its ratio to the others; the gap is that of the lost combination."""
    scaled = mechanism(c=0.5, gap=1e-3, d=0.3)
    table, arrays = scaled.layout
    z = np.append(closed(distance, 0.3 * distance), 0.5 * distance)
    set_units(table, 1.0, z)
    u_first(arrays)
    a, gaps, left, null = np.empty((2, 4)), np.empty(2), np.empty((2, 1)), np.empty((4, 3))
    gap = lost_gap(table, z, 1, a, gaps, left, null, np.empty((1, 1)), np.empty((3, 3)))
    values = np.empty(8)
    unit_jacobian_entries(table, z, values)
    dense = scaled.dense(values)
    np.testing.assert_allclose(dense[0] @ null, 0.0, atol=1e-14)
    assert left[1, 0] == 1.0
    smallest = np.linalg.svd(dense, compute_uv=False)[-1]
    assert np.linalg.norm(a[1, 1:]) == pytest.approx(smallest, rel=smallest**2)
    unit = left[:, 0] / np.linalg.norm(left)
    phi = scaled.gaps(z[3], z[:3])
    raw = scaled.dense(scaled.entries(z[3], z[:3], 1.0))
    assert gap == pytest.approx(abs(unit @ (phi / np.linalg.norm(raw[:, :3], axis=1))), rel=1e-12)


def test_a_factored_matrix_gives_its_weak_part():
    scaled = mechanism()
    table, arrays = scaled.layout
    z = np.append(closed(0.02, -0.01), 0.0)
    set_units(table, 1.0, z)
    values = np.empty(8)
    unit_jacobian_entries(table, z, values)
    a = scaled.dense(values)
    assert factor_fully(a, np.zeros(2, np.int64), arrays["column_order"], 0.5) == 1
    assert reduce_to_weak_part(table, a, 1) == 1
    smallest = np.linalg.svd(scaled.dense(values), compute_uv=False)[-1]
    assert np.linalg.norm(a[1, 1:]) == pytest.approx(smallest, rel=1e-3)


def test_no_complement_without_a_pivot():
    scaled = mechanism()
    table, _ = scaled.layout
    set_units(table, 1.0, np.zeros(4))
    a, gaps, left, null = np.empty((2, 4)), np.empty(2), np.empty((2, 1)), np.empty((4, 3))
    work = np.empty((1, 1)), np.empty((3, 3))
    # In the first order of pivots x is to be eliminated, which Φ₁ does not contain here.
    assert lost_gap(table, np.zeros(4), 1, a, gaps, left, null, *work) == -1.0
