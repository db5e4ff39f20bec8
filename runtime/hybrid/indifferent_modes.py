"""Functions on their surface whose modes make no difference, as of contacts that touch at rest.

A force that is zero on its surface, as k g + c ġ where a gap closes without speed, is the same in
both modes but for rounding, and so is the motion that follows. No look ahead tells its modes apart,
and where several such functions act on one body, each contradicts the others by rounding.
"""

from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context
from runtime.core.jit import inner
from runtime.core.modes_and_event_kinds import BALANCED, SLIDING
from runtime.core.state_derivative import evaluate_accelerations
from runtime.hybrid import mode_consistency as consistency
from runtime.linalg.vectors import largest_magnitude

_SAME = 1e-9  # accuracy: of the largest acceleration; what a mode may change that is none


@inner
def is_plain(context: Context, k: int) -> bool:
    """Whether function `k` has two modes and no force of its own on its surface."""
    plain = context.rigid[k] < 0 and context.sticks[k] == 0 and context.modes[k] != SLIDING
    return bool(plain and context.boundary[k] < BALANCED)


@inner
def drop_indifferent(context: Context, t: float, state: int, first: int, count: int) -> int:
    """Take from the `count` members those whose modes make no difference; how many are left.

    They keep their modes, but for `first`, the function that crossed, which changes its own.
    """
    modes, members = context.modes, context.members
    before, after = context.first_scratch, context.second_scratch
    q, v = ws.positions(context, state), ws.velocities(context, state)
    consistency.count_sliding(context, modes)
    evaluate_accelerations(context, t, q, v, modes, before)
    least, left = _SAME * largest_magnitude(before), 0
    for i in range(count):
        k = members[i]
        same = is_plain(context, k)
        if same:
            modes[k] = 1 - modes[k]
            evaluate_accelerations(context, t, q, v, modes, after)
            for j in range(after.size):
                same = same and abs(after[j] - before[j]) <= least
            if not (same and k == first):
                modes[k] = 1 - modes[k]
        if not same:
            members[left] = k
            left += 1
    return left
