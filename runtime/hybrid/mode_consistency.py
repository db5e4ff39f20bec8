"""Whether modes agree with the motion that follows from them, in a short look ahead."""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.function_table import (
    COORDINATES,
    MODIFIED,
    SLIDING_COUNT,
    STABILIZED,
    SWITCHES,
    limited_of,
    limits_of,
    members_of,
    parameters_of,
    response_of,
    rigid_of,
    share_high_of,
    share_low_of,
    share_of,
    signs_of,
    sliding_functions_of,
    sticks_of,
)
from runtime.core.jit import inner
from runtime.core.kernel_abi import switching_of
from runtime.core.rhs import field
from runtime.core.workspace import (
    DELTA,
    LARGEST,
    NOW,
    PREFERRED,
    SAMPLE,
    TRIAL,
    positions,
    row_of,
    second_half,
    switch_row,
    velocities,
)
from runtime.hybrid.sliding_modes import HELD_MODE

CONSISTENT = -1
GIVEN = 4  # is added to a preferred mode that is known to be right, and needs no look-ahead
_SIGNIFICANT = 1e-14  # accuracy: change of g over its maximum that is more than rounding
_FIRST = 1e-7  # measured: first look-ahead over the last
MISSED = 1e-9  # accuracy: amount by which a share may miss its bounds at an event


@inner
def carry(context: Integers, t: float, d: float, state: int) -> None:
    """Write into row TRIAL of `sw` the functions after a time `d` at constant acceleration.

    The acceleration is the second half of row DELTA.
    """
    p = parameters_of(context)
    n = context[COORDINATES]
    y = row_of(context, state)
    a = second_half(context, DELTA)
    z = row_of(context, SAMPLE)
    for j in range(n):
        z[j] = y[j] + d * (y[n + j] + 0.5 * d * a[j])
        z[n + j] = y[n + j] + d * a[j]
    q, v = positions(context, SAMPLE), velocities(context, SAMPLE)
    switching_of(context)(t + d, q, v, p, switch_row(context, TRIAL))


@inner
def hold(context: Integers, modes: Integers) -> None:
    """Make the field that of `modes`: count what is held."""
    count = 0
    for k in range(modes.size):
        count += 1 if modes[k] == HELD_MODE else 0
    context[SLIDING_COUNT] = count
    context[MODIFIED] = count + context[STABILIZED]


@inner
def loose(context: Integers, t: float, q: Vector, v: Vector, s: int) -> int:
    """First function that is said to be held and that nothing holds, else `CONSISTENT`.

    To be called after the field was evaluated.
    """
    matrix = response_of(context)
    share = share_of(context)
    low, high = share_low_of(context), share_high_of(context)
    count = context[SLIDING_COUNT]
    held = sliding_functions_of(context)
    for c in range(count):
        k = int(held[c])
        inside = low[k] - MISSED <= share[k] <= high[k] + MISSED
        if limits_of(context)[2 * k] >= 0:
            inside = limited_of(context)(context, t, q, v, k) >= -MISSED
        if not inside or not matrix[c * count + c] < 0.0:
            return k
    return CONSISTENT


@inner
def contradicted(
    context: Integers, t: float, d: float, state: int, candidate: Integers, count: int
) -> int:
    """First of the `count` members that does not go to the side that its candidate mode claims.

    Returns `CONSISTENT` where all do. `signs` receives where each goes: -1, 0 or 1.
    """
    members = members_of(context)
    signs = signs_of(context)
    s = context[SWITCHES]
    g = switch_row(context, NOW)
    ahead = switch_row(context, TRIAL)
    largest = switch_row(context, LARGEST)
    preferred = switch_row(context, PREFERRED)
    rigid, sticks = rigid_of(context), sticks_of(context)
    q = positions(context, state)
    v = velocities(context, state)
    hold(context, candidate)
    field(context, t, q, v, candidate, second_half(context, DELTA))
    if context[SLIDING_COUNT] != 0:
        k = loose(context, t, q, v, s)
        if k != CONSISTENT:
            return k
    open_members = 0
    for i in range(count):
        signs[i] = 0
        open_members += 1 if candidate[members[i]] != HELD_MODE else 0
    distance = d * _FIRST
    while open_members > 0 and distance <= 1.5 * d:
        carry(context, t, distance, state)
        for i in range(count):
            k = members[i]
            change = ahead[k] - g[k]
            significant = abs(change) > _SIGNIFICANT * max(largest[k], abs(g[k]))
            if signs[i] == 0 and significant and candidate[k] != HELD_MODE:
                signs[i] = 1 if change > 0.0 else -1
                open_members -= 1
        distance *= 10.0
    for i in range(count):
        k = int(members[i])
        if candidate[k] == HELD_MODE:
            continue
        if not np.isfinite(ahead[k]):
            return k
        if int(preferred[k]) == candidate[k] + GIVEN:
            continue
        # A contact that others keep closed may touch without a force of its own; friction at rest
        # may exert any force within its bounds, also those at their ends.
        touches = (rigid[k] >= 0 or sticks[k] != 0) and signs[i] == 0
        if not touches and (signs[i] > 0) != (candidate[k] != 0):
            return k
    return CONSISTENT
