"""Tolerances lie between the noise that they are for and what is no noise."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.arrays import EPS
from runtime.linalg.rank_policy import LOST, NO_DIVISOR, NO_PIVOT, REDUNDANT, SAME_HOLD
from tests.runtime.linalg.drivers import eliminate_rows
from tests.runtime.linalg.test_full_pivoting import factored


@given(seed=st.integers(0, 2**20), n=st.integers(6, 60), noise=st.sampled_from([0.0, 1e-9]))
def test_redundant_rows_of_a_sparse_matrix_have_no_pivot(seed, n, noise):
    """At every size: to rounding, and with the error that positions have on the way."""
    random = np.random.default_rng(seed)
    m = n - 2
    dense = np.where(random.random((m, n)) < 3.0 / n, random.normal(size=(m, n)), 0.0)
    dense[:, :m] += 2.0 * np.eye(m)
    dense[-1] = random.normal(size=3) @ dense[:3]
    dense /= np.linalg.norm(dense, axis=1)[:, None]
    if noise == 0.0:
        values = np.linalg.svd(dense, compute_uv=False)
        assert factored(dense, NO_PIVOT)[0] == (values > NO_PIVOT).sum() == m - 1
    else:
        dense[-1] += noise * random.normal(size=n) / np.sqrt(n)
        pivots = np.zeros(m)
        eliminate_rows(dense, np.zeros(m, np.int64), pivots, 1)
        assert abs(pivots[-1]) < REDUNDANT


def test_a_double_root_is_found_as_singular():
    """Newton's method stalls at √EPS of x² = 0; the slope there is what is left of the Jacobian."""
    x = 0.3
    for _ in range(60):
        if x * x <= EPS:
            break
        x -= 0.5 * x
    assert EPS < x < LOST


def test_tolerances_are_ordered_by_the_noise_of_what_is_known():
    assert EPS < NO_DIVISOR < SAME_HOLD < NO_PIVOT < REDUNDANT < np.sqrt(EPS) < LOST
    assert pytest.approx(67.0, rel=0.01) == LOST / np.sqrt(EPS)
