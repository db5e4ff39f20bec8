"""Pivots of the Jacobian of a large machine, in an order of few fill-ins that is kept."""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context
from runtime.core.jit import allocating
from runtime.linalg.rank_policy import REDUNDANT
from runtime.linalg.sparse_elimination import by_rows, eliminate_in_order, order_sparsely


@allocating(ft.FIND_PIVOTS)
def find_sparse_pivots(context: Context, row: int, search: int) -> int:
    """Eliminate the Jacobian that was evaluated last, columns scaled, rows of unit length.

    Its pivots are written into row `row` of the pivots, in an order of their own if `search`, else
    in that of the last search; the order is `pivot_rows` and `pivot_columns`, of rows without a
    pivot -1. Returns 1 where every row has a pivot, else 0.
    """
    rows, columns = context.jacobian_rows, context.jacobian_columns
    scale = ws.second_half(context, ws.PARTITION)
    order, pivot_columns, pivots = context.pivot_rows, context.pivot_columns, context.pivots[row]
    m, n, rank = order.size, scale.size, 0
    values, lengths = np.empty(rows.size), np.zeros(m)
    for e in range(rows.size):
        values[e] = context.jacobian_values[e] * scale[columns[e]]
        lengths[rows[e]] += values[e] ** 2
    for e in range(rows.size):
        if lengths[rows[e]] > 0.0:
            values[e] /= np.sqrt(lengths[rows[e]])
    if search != 0:
        column_order = np.empty(n, np.int64)
        matrix = by_rows(rows, columns, values, m)
        rank = order_sparsely(matrix, n, REDUNDANT, order, column_order)
        for k in range(m):
            pivot_columns[k] = column_order[k] if k < rank else -1
    while rank < m and pivot_columns[rank] >= 0:
        rank += 1
    row_place, column_place = np.empty(m, np.int64), np.full(n, -1)
    for k in range(m):
        row_place[order[k]] = k
        if k < rank:
            column_place[pivot_columns[k]] = k
    at = rank
    for j in range(n):
        if column_place[j] < 0:
            column_place[j] = at
            at += 1
    ordered = by_rows(row_place[rows], column_place[columns], values, m)
    upper = eliminate_in_order(ordered, n, rank, np.zeros(m), REDUNDANT)
    regular = 1
    for k in range(m):
        pivots[order[k]] = upper.values[upper.starts[k]] if k < rank else 0.0
        if not abs(pivots[order[k]]) > REDUNDANT:
            regular = 0
    return regular
