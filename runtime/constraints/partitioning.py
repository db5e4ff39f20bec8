"""Partition of the coordinates into dependent and independent ones, and its quality.

The constraint Jacobian is factored with full pivoting, columns scaled so that the choice does not
depend on units: the columns that receive a pivot are the dependent coordinates, the others the
independent ones; rows without a pivot are redundant. (E. J. Haug, Computer-Aided
Kinematics and Dynamics of Mechanical Systems, 1989; R. A. Wehage and E. J. Haug, Journal of
Mechanical Design 104, 1982.)

Choice of independent coordinates of large machines, by sparse elimination.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Integers, Matrix, Vector, i8, integers, matrix, vector
from runtime.core.jit import allocating, compiled, fetched, inner
from runtime.linalg.dense_elimination import Sparse, factor_fully, fill_dense
from runtime.linalg.rank_policy import NO_PIVOT
from runtime.linalg.sparse_elimination import by_rows, order_sparsely
from runtime.linalg.vectors import largest_magnitude


@inner
def factor_over_largest(dense: Matrix, row_order: Integers, column_order: Integers) -> int:
    """As `factor_fully`, each row first divided by its largest entry."""
    for i in range(dense.shape[0]):
        largest = largest_magnitude(dense[i])
        if largest > 0.0:
            for j in range(dense.shape[1]):
                dense[i, j] /= largest
    return factor_fully(dense, row_order, column_order, NO_PIVOT)


@compiled(i8(matrix, vector, integers, integers))
def order_by_pivots(
    dense: Matrix, scale: Vector, row_order: Integers, column_order: Integers
) -> int:
    """Order rows and columns of a Jacobian by full pivoting; returns the rank.

    `dense`, (m, n), is overwritten; `scale`, (n,), is the typical size of a change of each
    coordinate, 1 / sqrt(M_kk). `row_order`, (m,), receives the constraints, those with a pivot
    first, `column_order`, (n,), the coordinates, the dependent ones first.
    """
    for i in range(dense.shape[0]):
        for j in range(dense.shape[1]):
            dense[i, j] *= scale[j]
    return factor_over_largest(dense, row_order, column_order)


@fetched
def evaluate_jacobian(context: Context, t: float, q: Vector) -> Sparse:
    """Φ_q at (t, q)."""
    abi.jacobian_of(context)(t, q, context.parameters, context.jacobian_values)
    return Sparse(context.jacobian_rows, context.jacobian_columns, context.jacobian_values)


@inner
def choose_independent(context: Context, t: float, q: Vector) -> int:
    """Choose the independent coordinates at (t, q); the rank of the Jacobian.

    Sets the weights of the correction, which are 0 on independent coordinates and scale² on
    dependent ones, and the orders of rows and columns as `order_by_pivots` does.
    """
    scale, dense, column_order = context.scale, context.dense_jacobian, context.column_order
    sparse = evaluate_jacobian(context, t, q)
    if context[ft.SPARSE] != 0:
        rank = int(ft.order_sparsely_of(context)(context))
    else:
        fill_dense(sparse, scale, dense)
        rank = factor_over_largest(dense, context.row_order, column_order)
    for position in range(column_order.size):
        j = column_order[position]
        context.correction_weights[j] = scale[j] ** 2 if position < rank else 0.0
    return rank


@inner
def column_norm(context: Context, t: float, independent: int) -> float:
    """Largest entry of a column of H in dq_dependent = H dq_independent at Y1, coordinates scaled.

    It costs two calls of `correction`, and grows without bound where the partition becomes
    singular. Where `independent` is negative, all columns of H are added, with signs that are drawn
    by this number. Row `UNIT` is left with the velocities of the probe, and the dependent
    velocities with the independent coordinates at rest.
    """
    correction, q, p = abi.correction_of(context), context.q1, context.parameters
    weights, scale, dq, dv = context.correction_weights, context.scale, context.dq, context.dv
    probe, driven = ws.first_half(context, ws.UNIT), ws.second_half(context, ws.UNIT)
    probe[:] = 0.0
    correction(t, q, probe, p, weights, dq, driven)
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


@allocating(ft.PART)
def order_by_sparse_pivots(context: Context) -> int:
    """Order rows and columns of the Jacobian that was evaluated last by pivots; its rank.

    As `partitioning.order_by_pivots`, but that pivots are the largest ones to a factor.
    """
    rows, columns = context.jacobian_rows, context.jacobian_columns
    scale = ws.second_half(context, ws.PARTITION)
    values, largest = np.empty(rows.size), np.zeros(context.row_order.size)
    for e in range(rows.size):
        values[e] = context.jacobian_values[e] * scale[columns[e]]
        largest[rows[e]] = max(largest[rows[e]], abs(values[e]))
    for e in range(rows.size):
        if largest[rows[e]] > 0.0:
            values[e] /= largest[rows[e]]
    matrix = by_rows(rows, columns, values, largest.size)
    return int(
        order_sparsely(matrix, scale.size, NO_PIVOT, context.row_order, context.column_order)
    )
