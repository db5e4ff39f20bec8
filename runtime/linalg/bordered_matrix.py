"""Symmetric sparse matrices in two by two blocks, [[A, Bᵀ], [B, C]]."""

from typing import Any

import numpy as np


def bordered_matrix(a: Any, b: Any, c: Any) -> Any:
    """The matrix by columns, of A, (n, n), B, (m, n), and C, (m, m).

    In half of the time of `scipy.sparse.block_array`, of which a passage takes hundreds.
    """
    from scipy.sparse import csc_matrix  # small machines load none of it

    (a_rows, a_columns, a_data), (b_rows, b_columns, b_data), (c_rows, c_columns, c_data) = map(
        _entries, (a, b, c)
    )
    m, n = b.shape
    data = np.concatenate([a_data, b_data, b_data, c_data])
    rows = np.concatenate([a_rows, b_rows + n, b_columns, c_rows + n])
    columns = np.concatenate([a_columns, b_columns, b_rows + n, c_columns + n])
    return csc_matrix((data, (rows, columns)), shape=(n + m, n + m))


def _entries(matrix: Any) -> tuple[Any, Any, Any]:
    """Rows, columns and values of the entries."""
    by_columns = matrix.tocsc()
    counts = np.diff(by_columns.indptr)
    return by_columns.indices, np.repeat(np.arange(len(counts)), counts), by_columns.data
