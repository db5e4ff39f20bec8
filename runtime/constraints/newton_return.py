"""Return of a state onto the constraints by Newton's method, positions and velocities together.

The weights say which coordinates move. At the end of a step they are zero on the independent ones,
which stay, and the dependent ones follow (E. J. Haug's coordinate partitioning). States off the
steps, where the partition may be singular, are projected in the metric of the masses.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import EPS, Context
from runtime.core.jit import addressed
from runtime.core.kernel_abi import correction_of
from runtime.core.loop_record import run_record

ITERATIONS = 10  # safety: Newton iterations before the return counts as failed
FAILED = -1_000_000  # negative also when iterations of other stages are added to it
_ROUNDING = 2.0 * EPS  # accuracy: relative change of a position that is rounding, as at rest
_POSITION = 3e-14  # accuracy: relative change of a position below which velocities are right too
_VELOCITY = 1e-8  # accuracy: relative change of a velocity that one linear solve brings to rounding


@addressed(ft.CORRECT)
def return_to_constraints(context: Context, t: float, index: int, weighing: int) -> int:
    """Bring the state in row `index` of the workspace onto the constraints at time `t`.

    Row `weighing` holds the weights: `PARTITION` holds the independent coordinates, `PROJECTION`
    moves all of them, least in the metric of the masses. Returns the calls of `correction`;
    `FAILED` where the iteration does not converge. `run.weak_return` names a constraint with a weak
    pivot.
    """
    correction, p, r = correction_of(context), context.parameters, run_record(context)
    q, v = ws.positions(context, index), ws.velocities(context, index)
    dq, dv, n, previous = context.dq, context.dv, q.size, np.inf
    weights, size = ws.first_half(context, weighing), ws.row_of(context, ws.SIZE)
    for iteration in range(1, ITERATIONS + 1):
        r.weak_return = correction(t, q, v, p, weights, dq, dv)
        moved, turned = 0.0, 0.0
        for j in range(n):
            if not np.isfinite(dq[j] + dv[j]):  # which a maximum would pass over
                return FAILED
            if abs(dq[j]) > _ROUNDING * (abs(q[j]) + size[j]):
                q[j] += dq[j]
            v[j] += dv[j]
            moved = max(moved, abs(dq[j]) / (0.01 * abs(q[j]) + size[j]))
            turned = max(turned, abs(dv[j]) / (abs(v[j]) + size[n + j]))
        settled = moved <= _POSITION and turned <= _VELOCITY
        at_rounding = previous < 1e-10 and moved > 0.25 * previous
        if settled or at_rounding:
            return iteration
        previous = moved
    return FAILED
