"""Results with the same bits."""

import numpy as np
from numpy.testing import assert_allclose

from runtime.results.result import Result


def same(whole: Result, parts: Result) -> None:
    """Assert that a result has all series of another one at its own instants; works by sums."""
    rows = np.isin(whole.t, parts.t)
    assert whole.t[rows].tobytes() == parts.t.tobytes()
    for name, x, y in zip(whole.samples._fields, whole.samples, parts.samples, strict=True):
        assert np.array_equal(x[rows], y, equal_nan=True), name
    for name, work in parts.works.items():
        assert_allclose(work, whole.works[name][rows], rtol=1e-11, atol=1e-10)
