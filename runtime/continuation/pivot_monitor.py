"""Compiled monitor of the pivots of Phi_q along the continuation of a driven motion.

A step can be so long that it lands on another assembly of the machine, close to a position in which
two of them meet or almost meet. So the pivots of Phi_q are compared now and then, in one order: on
one assembly the determinant keeps its sign.
"""

from typing import Any

import numpy as np

from runtime.core.jit import inner
from runtime.linalg.rank_policy import REDUNDANT
from runtime.linalg.row_elimination import Sparse, eliminate_rows, fill_unit_rows, smallest_pivot

# Entries of the record that a continuation keeps. BARRIER: an instant to stop at, or not a number.
# TRAVEL: scaled motion since pivots were looked at; LEAST: the smallest then, negative where they
# are to be looked at first. At a suspicion, END: until when the pivots were followed, and ZERO:
# where between there and now one of them vanishes.
T, STEP, STEPS, REJECTED, NEWTON, MARK, BARRIER, TRAVEL, LEAST, END, ZERO = range(11)
# LOOK_T, LOOK_MARK: when pivots were looked at; GOOD_T, GOOD_MARK: when they were last about as
# good as the BEST since the walk began or was resumed.
LOOK_T, LOOK_MARK, GOOD_T, GOOD_MARK, BEST = range(11, 16)
RECORD = 16
# Rows of the work array, (ROWS, n): states at the last look, and where pivots were last good.
LOOK_Q, LOOK_V, SPARE, GOOD_Q, GOOD_V = range(5, 10)
ROWS = 10

# measured: of the smallest pivot: scaled motion after which pivots are looked at again
MARGIN = 0.5
_POOR = 0.5  # measured: of the smallest pivots at both ends; a smaller one in between is suspicious
_GOOD = 0.05  # measured: smallest pivot of a state that the walk may return to


@inner
def look(
    jacobian: Any, t: Any, q: Any, v: Any, p: Any, scale: Any, sparse: Any, values: Any,
    dense: Any, pivots: Any, order: Any, record: Any, work: Any,
) -> None:  # fmt: skip
    """Keep this state and the pivots there as what the next look is compared with."""
    n = len(q)
    jacobian(t, q, p, values)
    fill_unit_rows(Sparse(sparse[0], sparse[1], values), scale, dense)
    eliminate_rows(dense, order, pivots[0], 1)
    record[LEAST] = smallest_pivot(pivots[0])
    record[TRAVEL] = 0.0
    record[LOOK_T] = t
    record[LOOK_MARK] = record[MARK]
    for i in range(n):
        work[LOOK_Q, i] = q[i]
        work[LOOK_V, i] = v[i]
    record[BEST] = max(record[BEST], record[LEAST])
    if record[LEAST] >= min(_GOOD, 0.5 * record[BEST]):
        record[GOOD_T] = t
        record[GOOD_MARK] = record[MARK]
        for i in range(n):
            work[GOOD_Q, i] = q[i]
            work[GOOD_V, i] = v[i]


@inner
def restore_look(record: Any, work: Any, q: Any, v: Any) -> None:
    """Take the state of the last look back, and let the next look come at once."""
    for i in range(len(q)):
        q[i] = work[LOOK_Q, i]
        v[i] = work[LOOK_V, i]
    record[T] = record[LOOK_T]
    record[MARK] = record[LOOK_MARK]
    record[TRAVEL] = np.inf


@inner
def suspicious(
    jacobian: Any, t: Any, q: Any, p: Any, scale: Any, sparse: Any, values: Any, dense: Any,
    pivots: Any, order: Any, spare: Any, record: Any, work: Any,
) -> bool:  # fmt: skip
    """Whether the constraints were, or may have been, dependent since the last look.

    A pivot that vanishes only in this order of pivots takes another through infinity: signs change
    in pairs, and the position in between is a good one with an order of its own. An odd number of
    changes is a change of the determinant's sign.
    """
    now, later, between = pivots[0], pivots[1], pivots[2]
    before, moved = work[LOOK_Q], work[SPARE]
    jacobian(t, q, p, values)
    fill_unit_rows(Sparse(sparse[0], sparse[1], values), scale, dense)
    eliminate_rows(dense, order, later, 0)
    changes = 0
    poorest = np.inf
    for i in range(now.size):
        if min(abs(now[i]), abs(later[i])) <= REDUNDANT or now[i] * later[i] > 0.0:
            continue
        changes += 1
        share = now[i] / (now[i] - later[i])
        middle = record[LOOK_T] + share * (t - record[LOOK_T])
        for j in range(len(q)):
            moved[j] = before[j] + share * (q[j] - before[j])
        jacobian(middle, moved, p, values)
        fill_unit_rows(Sparse(sparse[0], sparse[1], values), scale, dense)
        eliminate_rows(dense, spare, between, 1)
        least = smallest_pivot(between)
        if least < poorest:
            poorest = least
            record[ZERO] = share
    if changes % 2 == 0:
        if changes == 0:
            return False
        jacobian(t, q, p, values)
        fill_unit_rows(Sparse(sparse[0], sparse[1], values), scale, dense)
        eliminate_rows(dense, spare, between, 1)
        if poorest >= _POOR * min(record[LEAST], smallest_pivot(between)):
            return False
    record[END] = t
    return True
