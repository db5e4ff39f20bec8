"""The iteration for a singular position: where it ends, how fast, and when it gives up."""

import numpy as np
import pytest

from runtime.singularity.search_function_table import set_units
from runtime.singularity.singular_root_search import find_root
from tests.runtime.singularity.crossing import closed, mechanism, noted
from tests.runtime.singularity.test_schur_complement import u_first


def searched(scaled, z, begin=None):
    """z of the root, the gap, and the vectors, from the place z; rows measured at `begin`."""
    table, arrays = scaled.layout
    set_units(table, 1.0, z if begin is None else begin)
    u_first(arrays)
    z, left, null = z.copy(), np.empty((2, 1)), np.empty((4, 3))
    return z, find_root(table, z, left, null), left, null


@pytest.mark.parametrize("gap", [0.0, 1e-3, -0.02])
def test_the_root_is_the_saddle_whatever_it_is_missed_by(gap):
    scaled = mechanism(c=0.5, gap=gap, d=0.7)
    z, missed, left, null = searched(scaled, np.append(closed(0.1, -0.15), 0.05))
    np.testing.assert_allclose(z, 0.0, atol=1e-10)
    lengths = scaled.layout.arrays["lengths"]
    lost = np.array([-0.5 * lengths[0], lengths[1]])
    expected = abs(gap) / np.linalg.norm(lost)
    assert missed == pytest.approx(expected, rel=1e-9, abs=1e-15)
    np.testing.assert_allclose(np.abs(left[:, 0]), np.abs(lost) / np.linalg.norm(lost), rtol=1e-9)
    np.testing.assert_allclose(null.T @ null, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(null[2], 0.0, atol=1e-9)


def test_convergence_is_quadratic_while_derivatives_are_taken_anew():
    """They are taken at the first two places and then kept: order 2, then e₁ times smaller."""
    scaled = mechanism(c=0.5, k=1.0, d=0.7)
    _, gap, _, _ = searched(scaled, np.append(closed(0.1, -0.1), 0.1))
    assert gap < 1e-14
    errors = np.linalg.norm(noted(scaled), axis=1)
    assert errors[0] > 0.1
    assert errors[1] < 3.0 * errors[0] ** 2
    assert errors[2] < 3.0 * errors[1] ** 2
    assert errors[3] < 3.0 * errors[2] * errors[1] + 1e-14
    assert len(errors) < 10
    # Of first order at least 20 places would have been needed.
    orders = np.log(errors[2] / errors[1]) / np.log(errors[1] / errors[0])
    assert orders > 1.6


def test_time_stays_where_nothing_depends_on_it():
    scaled = mechanism(d=0.0)
    z, gap, _, _ = searched(scaled, np.append(closed(0.05, 0.1), 3.0))
    np.testing.assert_allclose(z, [0.0, 0.0, 0.0, 3.0], atol=1e-9)
    assert gap < 1e-14


@pytest.mark.parametrize(("x", "y"), [(2.0, 1.0), (0.0, 0.9)])
def test_a_root_far_from_the_start_is_none(x, y):
    scaled = mechanism(d=0.7)
    assert searched(scaled, np.append(closed(x, y), 0.0))[1] == -1.0
