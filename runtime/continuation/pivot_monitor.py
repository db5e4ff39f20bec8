"""Compiled monitor of the pivots of Phi_q along the continuation of a driven motion.

A step can be so long that it lands on another assembly of the machine, close to a position in which
two of them meet or almost meet. So the pivots of Phi_q are compared now and then, in one order: on
one assembly the determinant keeps its sign.
"""

from collections import namedtuple
from typing import Any, cast

import numpy as np

from runtime.core.array_types import integer_matrix, integers, matrix, named_tuple_type, vector
from runtime.core.jit import inner
from runtime.core.kernel_abi import jacobian_of
from runtime.linalg.rank_policy import REDUNDANT
from runtime.linalg.row_elimination import Sparse, eliminate_rows, fill_unit_rows, smallest_pivot
from runtime.linalg.vectors import copy_vector

MARGIN = 0.5  # measured: of the smallest pivot: scaled motion after which pivots are compared again
_POOR = 0.5  # measured: of the smallest pivots at both ends; a smaller one in between is suspicious
_GOOD = 0.05  # measured: smallest pivot of a state to which the continuation may return

# The record that a continuation keeps. t: instant of the state; barrier: instant to stop at, or not
# a number; travel: scaled motion since pivots were compared; least: the smallest then, negative
# where they are to be computed first; best: the largest of these since the continuation began or
# was resumed. At a suspicion, end: instant until which pivots were followed; zero: part of the way
# there at which one of them vanishes. compared: when pivots were compared last; good: when they
# were last about as good as the best; mark: number of instants done.
_FLOATS = ["t", "step", "barrier", "travel", "least", "best", "end", "zero", "compared_t", "good_t"]
_COUNTS = ["mark", "compared_mark", "good_mark", "steps", "rejected", "newton"]
RECORD = np.dtype([(name, float) for name in _FLOATS] + [(name, np.int64) for name in _COUNTS])

# Its arrays: those of the equations; the state, q to modes; samples, (instants, n); Phi_q, (m, n),
# the pivots at the last comparison, now and in between, (3, m), and their columns at the last
# comparison and elsewhere, (2, m); q and v at the last comparison, where pivots were good, and of a
# trial step, with their changes.
_WORKSPACE = {
    **dict.fromkeys(("p", "scale", "weights", "q", "v", "a", "lam", "values"), vector),
    **dict.fromkeys(("modes", "rows", "columns"), integers),
    **dict.fromkeys(("q_out", "v_out", "dense", "pivots", "compared", "good", "trial"), matrix),
    "orders": integer_matrix,
}
Workspace: Any = cast(Any, namedtuple)("Workspace", _WORKSPACE)
WORKSPACE = named_tuple_type(list(_WORKSPACE.values()), Workspace)


@inner
def eliminate_at(
    kernels: Any, s: Any, t: Any, q: Any, order: Any, pivots: Any, search: int
) -> float:
    """Fill the pivots of Phi_q at (t, q); the smallest of them."""
    jacobian_of(kernels)(t, q, s.p, s.values)
    fill_unit_rows(Sparse(s.rows, s.columns, s.values), s.scale, s.dense)
    eliminate_rows(s.dense, order, pivots, search)
    return float(smallest_pivot(pivots))


@inner
def record_pivots(kernels: Any, s: Any, r: Any) -> None:
    """Keep this state and its pivots for the next comparison."""
    r.least = eliminate_at(kernels, s, r.t, s.q, s.orders[0], s.pivots[0], 1)
    r.travel = 0.0
    r.compared_t, r.compared_mark = r.t, r.mark
    copy_vector(s.q, s.compared[0])
    copy_vector(s.v, s.compared[1])
    r.best = max(r.best, r.least)
    if r.least >= min(_GOOD, 0.5 * r.best):
        r.good_t, r.good_mark = r.t, r.mark
        copy_vector(s.q, s.good[0])
        copy_vector(s.v, s.good[1])


@inner
def return_to_comparison(s: Any, r: Any) -> None:
    """Return to the state of the last comparison, and let the next one come at once."""
    copy_vector(s.compared[0], s.q)
    copy_vector(s.compared[1], s.v)
    r.t, r.mark = r.compared_t, r.compared_mark
    r.travel = np.inf


@inner
def is_suspicious(kernels: Any, s: Any, r: Any) -> bool:
    """Whether the constraints were, or may have been, dependent since the last comparison.

    A pivot that vanishes only in this order of pivots takes another through infinity: signs change
    in pairs, and the position in between is a good one with an order of its own. An odd number of
    changes is a change of the determinant's sign.
    """
    before, now, between, middle = s.pivots[0], s.pivots[1], s.pivots[2], s.trial[2]
    eliminate_at(kernels, s, r.t, s.q, s.orders[0], now, 0)
    changes = 0
    poorest = np.inf
    for i in range(before.size):
        if min(abs(before[i]), abs(now[i])) <= REDUNDANT or before[i] * now[i] > 0.0:
            continue
        changes += 1
        part = before[i] / (before[i] - now[i])
        for j in range(s.q.size):
            middle[j] = s.compared[0, j] + part * (s.q[j] - s.compared[0, j])
        t = r.compared_t + part * (r.t - r.compared_t)
        least = eliminate_at(kernels, s, t, middle, s.orders[1], between, 1)
        if least < poorest:
            poorest = least
            r.zero = part
    if changes == 0:
        return False
    if changes % 2 == 0:
        least = eliminate_at(kernels, s, r.t, s.q, s.orders[1], between, 1)
        if poorest >= _POOR * min(r.least, least):
            return False
    r.end = r.t
    return True
