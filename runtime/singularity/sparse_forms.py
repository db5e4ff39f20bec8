"""Derivative of the sparse Schur complement along null vectors, from few differences.

Null vectors that meet in no constraint share one difference of Jacobians: of each constraint it is
that of the vector which enters the constraint. So it takes as many differences as vectors meet in a
constraint, however many there are. (A. R. Curtis, M. J. D. Powell and J. K. Reid, On the Estimation
of Sparse Jacobian Matrices, Journal of the Institute of Mathematics and its Applications 13, 1974.)
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array, vstack

from runtime.core.array_types import Integers, Vector
from runtime.singularity.sparse_complement import SparseJacobian

_DIFFERENCE = 6e-6  # accuracy: EPS ** (1/3), the relative size of a central difference


class Forms(NamedTuple):
    """Derivatives of entries of uᵀ Φ_z N along the null vectors: those that are not all zero."""

    left: Integers  # (k,): which left vector u and null vector N the entry belongs to
    null: Integers
    slopes: Any  # (k, free), sparse by rows


def difference(jacobian: SparseJacobian, z: Vector, direction: Vector) -> Vector:
    """The derivative along a direction, (n + 1,), of the entries of the Jacobian at z."""
    delta = _DIFFERENCE / max(float(np.abs(direction).max()), 1e-300)
    ahead = jacobian.entries(z + delta * direction)
    slopes: Vector = (ahead - jacobian.entries(z - delta * direction)) / (2.0 * delta)
    return slopes


def group(touched: Any) -> Integers:
    """Groups, (free,), of the columns of a sparse pattern; no row has two columns of a group."""
    by_column, by_row = touched.tocsc(), touched.tocsr()
    found = np.full(by_column.shape[1], -1)
    for f in range(found.size):
        rows = by_column.indices[by_column.indptr[f] : by_column.indptr[f + 1]]
        near = [by_row.indices[by_row.indptr[i] : by_row.indptr[i + 1]] for i in rows]
        taken = set(found[np.concatenate(near)].tolist()) if near else set()
        found[f] = next(k for k in range(found.size + 1) if k not in taken)
    return found


def _touched(jacobian: SparseJacobian, left: Any, null: Any) -> Any:
    """Which null vectors enter which of the constraints that the left vectors have; a pattern."""
    ones = np.ones(jacobian.rows.size)
    structure = csr_array((ones, (jacobian.rows, jacobian.columns)), shape=jacobian.shape)
    in_left = np.diff(left.indptr) > 0
    structure = structure.multiply(in_left[:, None]).tocsr()
    structure.eliminate_zeros()
    return (structure @ abs(null)).tocsr()


def differentiate(jacobian: SparseJacobian, z: Vector, left: Any, null: Any) -> Forms:
    """The forms at z between left vectors, (m', weak), and null vectors, (n + 1, free)."""
    m, free = jacobian.shape[0], null.shape[1]
    touched = _touched(jacobian, left, null)
    groups, of_null = group(touched), null.tocsc()
    entry = touched.tocoo()
    by_left, blocks = left.tocoo(), []
    keys, places, shares = [], [], []
    for k in range(int(groups.max(initial=-1)) + 1):
        members = groups == k
        slopes = difference(jacobian, z, of_null @ members.astype(float))
        blocks.append(jacobian.matrix(slopes) @ null)
        owner, mine = np.full(m, -1), members[entry.col]
        owner[entry.row[mine]] = entry.col[mine]
        owned = owner[by_left.row] >= 0
        rows, columns = by_left.row[owned], by_left.col[owned].astype(np.int64)
        keys.append(columns * free + owner[rows])
        places.append(rows.astype(np.int64) + k * m)
        shares.append(by_left.data[owned])
    if not blocks:
        nothing = np.zeros(0, np.int64)
        return Forms(nothing, nothing, csr_array((0, free)))
    pairs, number = np.unique(np.concatenate(keys), return_inverse=True)
    where = number, np.concatenate(places)
    sums = coo_array((np.concatenate(shares), where), shape=(pairs.size, m * len(blocks)))
    slopes = (sums.tocsr() @ vstack(blocks, format="csr")).tocsr()
    return Forms(pairs // free, pairs % free, slopes)


def entries_at(matrix: Any, rows: Integers, columns: Integers) -> Vector:
    """Entries of a sparse matrix by rows at the places in rising order, (k,)."""
    found = matrix.tocoo()
    width = matrix.shape[1]
    keys, wanted = found.row.astype(np.int64) * width + found.col, rows * width + columns
    at = np.searchsorted(wanted, keys)
    out = np.zeros(wanted.size)
    inside = at < wanted.size
    inside[inside] = wanted[at[inside]] == keys[inside]
    out[at[inside]] = found.data[inside]
    return out
