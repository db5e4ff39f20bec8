"""Partition of the coordinates into dependent and independent ones, and its quality.

The constraint Jacobian is factored with full pivoting, columns scaled so that the choice does not
depend on units: the columns that receive a pivot are the dependent coordinates, the others the
independent ones; rows without a pivot are redundant. (E. J. Haug, Computer-Aided
Kinematics and Dynamics of Mechanical Systems, 1989; R. A. Wehage and E. J. Haug, Journal of
Mechanical Design 104, 1982.)
"""

import numpy as np

from runtime.core.array_types import (
    Integers,
    Kernel,
    Matrix,
    Vector,
    f8,
    i8,
    integers,
    matrix,
    vector,
)
from runtime.core.jit import compiled, inner
from runtime.core.kernel_abi import TYPES
from runtime.linalg.full_pivoting import factor_fully
from runtime.linalg.rank_policy import NO_PIVOT


@compiled(i8(matrix, vector, integers, integers))
def order_by_pivots(
    dense: Matrix, scale: Vector, row_order: Integers, column_order: Integers
) -> int:
    """Order rows and columns of a Jacobian by full pivoting, and count the pivots.

    Parameters
    ----------
    dense : (m, n) float64
        The Jacobian; overwritten.
    scale : (n,) float64
        Typical size of a change of each coordinate, 1 / sqrt(M_kk).
    row_order : (m,) int64
        Out: constraints, those with a pivot first.
    column_order : (n,) int64
        Out: coordinates, the dependent ones first.

    Returns
    -------
    int
        The rank.
    """
    m, n = dense.shape
    for i in range(m):
        largest = 0.0
        for j in range(n):
            dense[i, j] *= scale[j]
            largest = max(largest, abs(dense[i, j]))
        if largest > 0.0:
            for j in range(n):
                dense[i, j] /= largest
    return factor_fully(dense, row_order, column_order, NO_PIVOT)


@compiled(
    i8(
        TYPES["jacobian"],
        f8,
        vector,
        vector,
        vector,
        integers,
        integers,
        vector,
        matrix,
        vector,
        integers,
        integers,
    )
)
def choose_independent(
    jacobian: Kernel,
    t: float,
    q: Vector,
    p: Vector,
    scale: Vector,
    rows: Integers,
    columns: Integers,
    values: Vector,
    dense: Matrix,
    weights: Vector,
    row_order: Integers,
    column_order: Integers,
) -> int:
    """Choose the independent coordinates at a position and set the weights of the correction.

    Parameters
    ----------
    jacobian
        Kernel that writes the Jacobian's structural non-zeros at (t, q) into `values`.
    scale : (n,) float64
        Typical size of a change of each coordinate, 1 / sqrt(M_kk).
    rows, columns : (nnz,) int64
        Where each of `values` belongs.
    dense : (m, n) float64
        Workspace.
    weights : (n,) float64
        Out: 0 on independent coordinates, scale ** 2 on dependent ones.
    row_order, column_order : (m,), (n,) int64
        Out: as in `order_by_pivots`.

    Returns
    -------
    int
        The rank of the Jacobian.
    """
    jacobian(t, q, p, values)
    dense[:, :] = 0.0
    for k in range(rows.size):
        dense[rows[k], columns[k]] += values[k]
    rank = order_by_pivots(dense, scale, row_order, column_order)
    for position in range(column_order.size):
        j = column_order[position]
        weights[j] = scale[j] ** 2 if position < rank else 0.0
    return rank


@inner
def driven_velocities(
    correction: Kernel,
    t: float,
    q: Vector,
    p: Vector,
    weights: Vector,
    probe: Vector,
    dq: Vector,
    dv: Vector,
) -> None:
    """Write into `dv` the dependent velocities with the independent coordinates at rest."""
    probe[:] = 0.0
    correction(t, q, probe, p, weights, dq, dv)


@inner
def column_norm(
    correction: Kernel,
    t: float,
    independent: int,
    q: Vector,
    p: Vector,
    weights: Vector,
    scale: Vector,
    probe: Vector,
    dq: Vector,
    dv: Vector,
    driven: Vector,
) -> float:
    """Largest entry of a column of H in dq_dependent = H dq_independent, coordinates scaled.

    It costs two calls of `correction`, and grows without bound where the partition becomes
    singular. Where `independent` is negative, all columns of H are added, with signs that are drawn
    by this number.
    """
    driven_velocities(correction, t, q, p, weights, probe, dq, driven)
    if independent >= 0:
        probe[independent] = scale[independent]
    else:
        drawn = -independent
        for j in range(q.size):
            drawn = (1103515245 * drawn + 12345) & 0x7FFFFFFF
            if weights[j] == 0.0:
                probe[j] = scale[j] if drawn & 0x10000 else -scale[j]
    correction(t, q, probe, p, weights, dq, dv)
    largest = 0.0
    for j in range(q.size):
        if weights[j] > 0.0:
            change = abs(dv[j] - driven[j]) / scale[j]
            if not change <= largest:
                largest = change
    return largest if np.isfinite(largest) else np.inf
