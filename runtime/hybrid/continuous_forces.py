"""Switching functions at which the forces bend and do not jump: their surface holds no motion."""

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context
from runtime.core.jit import inner
from runtime.core.modes_and_event_kinds import BALANCED, SLIDING
from runtime.core.state_derivative import evaluate_accelerations
from runtime.hybrid import mode_consistency as consistency
from runtime.linalg.vectors import copy_vector, is_finite

_CONTINUOUS = 1e-3  # safety: ratio of responses on a surface and beside it; of a jump it is 1


@inner
def response_at(context: Context, t: float, state: int, k: int) -> float:
    """By how much the modes of the sliding function `k` change its rate in the state of a row."""
    q, v = ws.positions(context, state), ws.velocities(context, state)
    evaluate_accelerations(context, t, q, v, context.modes, context.first_scratch)
    count = context[ft.SLIDING_COUNT]
    for c in range(count):
        if context.sliding_functions[c] == k:
            return float(context.response[c * count + c])
    return 0.0


@inner
def bends_on_surface(context: Context, t: float, k: int) -> bool:
    """Whether both modes of function `k` have one motion on its surface; row SAMPLE is there.

    So it is where a force is continuous, as c |v| at v = 0. Off the surface, by the error of the
    event, the modes differ, and neither side may seem right, or the motion to be held between.
    """
    modes, kept = context.modes, int(context.modes[k])
    if context.rigid[k] >= 0 or context.sticks[k] != 0 or context.boundary[k] >= BALANCED:
        return False
    modes[k] = SLIDING
    consistency.count_sliding(context, modes)
    before, place = response_at(context, t, ws.Y1, k), ws.row_of(context, ws.SAMPLE)
    copy_vector(ws.row_of(context, ws.Y1), place)
    ft.return_to_surfaces_of(context)(context, t, ws.SAMPLE)
    after = response_at(context, t, ws.SAMPLE, k)
    modes[k] = kept
    consistency.count_sliding(context, modes)
    return is_finite(place) and not abs(after) > _CONTINUOUS * abs(before)
