"""Symbolic elimination of Φ_q in a given order of pivots, and its numerical replay.

The order of pivots alone determines which entries an elimination by rows changes. A plan lists
them, and each later elimination follows the list: it tests no entry for being zero.

A plan is an array of integers: their number (0: there is no plan), the number of entries that fill
in, and for every row the place of its pivot, the number of rows subtracted from it, and for each of
these the places of the factor and of the other row's pivot, the number of entries that change, and
the places of each and of its subtrahend. A place is i n + j. The entries that fill in are listed
from the end. (T. A. Davis, Direct Methods for Sparse Linear Systems, chapters 3 and 6.)
"""

import numpy as np

from runtime.core.arrays import Integers, Matrix, Vector
from runtime.core.jit import inner
from runtime.linalg.dense_elimination import Sparse
from runtime.linalg.rank_policy import REDUNDANT


def plan_capacity(m: int, nonzeros: int) -> int:
    """Integers reserved for a plan; an elimination with more fill-in than that has none."""
    return 64 + 32 * m + 16 * nonzeros


@inner
def write_plan(
    order: Integers, sparse: Sparse, scale: Vector, dense: Matrix, plan: Integers, lengths: Vector
) -> None:
    """Write the plan of the elimination with its pivots in the columns `order`; overwrites `dense`.

    `lengths` receives the inverse lengths of the rows of the Jacobian, columns times `scale`.
    """
    rows, columns, values = sparse.rows, sparse.columns, sparse.values
    m, n = dense.shape
    lengths[:] = 0.0
    dense[:, :] = 0.0
    for k in range(rows.size):
        dense[rows[k], columns[k]] = 1.0
        lengths[rows[k]] += (values[k] * scale[columns[k]]) ** 2
    for i in range(m):
        lengths[i] = 1.0 / np.sqrt(lengths[i]) if lengths[i] > 0.0 else 0.0
    plan[0] = 0
    zeros, c = 0, 2
    for k in range(m):
        if c + 2 + zeros > plan.size:
            return
        head = c
        plan[head], plan[head + 1] = k * n + order[k], 0
        c += 2
        for i in range(k):
            if dense[k, order[i]] == 0.0 or lengths[i] == 0.0:
                continue
            if c + 3 + 3 * n + zeros > plan.size:
                return
            plan[head + 1] += 1
            each = c
            plan[each], plan[each + 1] = k * n + order[i], i * n + order[i]
            plan[each + 2] = 0
            c += 3
            for j in range(n):
                if j == order[i] or dense[i, j] == 0.0:
                    continue
                if dense[k, j] == 0.0:
                    dense[k, j] = 1.0
                    zeros += 1
                    plan[plan.size - zeros] = k * n + j
                plan[each + 2] += 1
                plan[c], plan[c + 1] = k * n + j, i * n + j
                c += 2
            dense[k, order[i]] = 0.0
    plan[0], plan[1] = c, zeros


@inner
def replay_plan(
    sparse: Sparse, scale: Vector, flat: Vector, plan: Integers, lengths: Vector, pivots: Vector
) -> bool:
    """Pivots of Φ_q by the plan, columns times `scale` and rows times `lengths`.

    `flat` is overwritten. False where a row with entries follows from those before it.
    """
    rows, columns, values, n = sparse.rows, sparse.columns, sparse.values, scale.size
    for z in range(plan[1]):
        flat[plan[plan.size - 1 - z]] = 0.0
    for k in range(rows.size):
        flat[rows[k] * n + columns[k]] = values[k] * scale[columns[k]]
    c = 2
    for k in range(pivots.size):
        place, count = plan[c], plan[c + 1]
        c += 2
        for _ in range(count):
            factor = flat[plan[c]] / flat[plan[c + 1]]
            entries = plan[c + 2]
            c += 3
            for _ in range(entries):
                flat[plan[c]] -= factor * flat[plan[c + 1]]
                c += 2
        pivots[k] = flat[place] * lengths[k]
        if lengths[k] > 0.0 and not abs(pivots[k]) > REDUNDANT:
            return False
    return True
