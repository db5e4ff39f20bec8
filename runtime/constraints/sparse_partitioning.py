"""Choice of independent coordinates of large machines, by sparse elimination."""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context
from runtime.core.jit import allocating
from runtime.linalg.rank_policy import NO_PIVOT
from runtime.linalg.sparse_elimination import by_rows, order_sparsely


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
