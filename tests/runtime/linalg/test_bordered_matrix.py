"""Symmetric matrices in blocks are those of SciPy."""

import numpy as np
import pytest
from scipy.sparse import block_array, csr_matrix, identity, random_array

from runtime.linalg.least_norm import bordered_matrix


@pytest.mark.parametrize(("m", "n"), [(3, 7), (1, 1), (0, 4), (5, 2)])
def test_the_blocks_of_scipy(m: int, n: int) -> None:
    generator = np.random.default_rng(1)
    b = csr_matrix(random_array((m, n), density=0.4, rng=generator))
    a, c = 2.0 * identity(n), -1e-9 * identity(m)
    whole = bordered_matrix(a, b, c)
    np.testing.assert_array_equal(
        whole.toarray(), block_array([[a, b.T], [b, c]], format="csc").toarray()
    )
    assert whole.format == "csc"
    assert whole.has_sorted_indices
