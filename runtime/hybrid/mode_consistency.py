"""Consistency of modes: the motion that follows from them agrees, in a short look-ahead."""

import numpy as np

from runtime.core import function_table as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Integers, Vector
from runtime.core.jit import inlined, inner
from runtime.core.modes import SLIDING, Mode
from runtime.core.rhs import evaluate_accelerations
from runtime.hybrid.switching_functions import extrapolate

CONSISTENT = -1
_DECIDED = len(Mode)  # code: added to a mode in row PREFERRED
_SIGNIFICANT = 1e-14  # accuracy: change of g over its maximum that is more than rounding
_FIRST = 1e-7  # measured: first look-ahead over the last
MISSED = 1e-9  # accuracy: distance by which a share may miss its bounds at an event


@inlined
def decided_entry(mode: int) -> int:
    """The entry of row PREFERRED for a mode that is decided and needs no look-ahead."""
    return mode + _DECIDED


@inlined
def preferred_mode(entry: float) -> int:
    """The mode in an entry of row PREFERRED, decided or not."""
    return int(entry) % _DECIDED


@inner
def look_ahead(context: Integers, t: float, d: float, state: int) -> None:
    """Write g after a time `d`, at the acceleration in row DELTA, into row TRIAL of `sw`."""
    p = ft.parameters_of(context)
    extrapolate(context, state, ws.second_half(context, ws.DELTA), d)
    q, v = ws.positions(context, ws.SAMPLE), ws.velocities(context, ws.SAMPLE)
    abi.switching_of(context)(t + d, q, v, p, ws.switch_row(context, ws.TRIAL))


@inner
def count_sliding(context: Integers, modes: Integers) -> None:
    """Count the functions in sliding mode, so that the right-hand side is that of `modes`."""
    count = 0
    for k in range(modes.size):
        count += 1 if modes[k] == SLIDING else 0
    context[ft.SLIDING_COUNT] = count
    context[ft.MODIFIED] = count + context[ft.STABILIZED]


@inner
def nearest_mode(context: Integers, k: int) -> int:
    """The mode, 0 or 1, at the bound to which the share of function `k` is nearer."""
    low, high = ft.share_low_of(context)[k], ft.share_high_of(context)[k]
    return 1 if ft.share_of(context)[k] > 0.5 * (low + high) else 0


@inner
def find_unsupported(context: Integers, t: float, q: Vector, v: Vector) -> int:
    """First function in sliding mode whose share is out of bounds, else `CONSISTENT`.

    The right-hand side must just have been evaluated.
    """
    matrix, share = ft.response_of(context), ft.share_of(context)
    low, high = ft.share_low_of(context), ft.share_high_of(context)
    count = context[ft.SLIDING_COUNT]
    for c in range(count):
        k = int(ft.sliding_functions_of(context)[c])
        inside = low[k] - MISSED <= share[k] <= high[k] + MISSED
        if ft.limits_of(context)[2 * k] >= 0:
            inside = ft.friction_margin_of(context)(context, t, q, v, k) >= -MISSED
        if not inside or not matrix[c * count + c] < 0.0:
            return k
    return CONSISTENT


@inner
def find_contradiction(
    context: Integers, t: float, d: float, state: int, candidate: Integers, count: int
) -> int:
    """First of the `count` members that does not go to the side that its candidate mode claims.

    Returns `CONSISTENT` where all do. `signs` receives the direction of each: -1, 0 or 1.
    """
    members, signs = ft.members_of(context), ft.signs_of(context)
    g = ws.switch_row(context, ws.NOW)
    ahead, largest = ws.switch_row(context, ws.TRIAL), ws.switch_row(context, ws.LARGEST)
    preferred = ws.switch_row(context, ws.PREFERRED)
    rigid, sticks = ft.rigid_of(context), ft.sticks_of(context)
    q, v = ws.positions(context, state), ws.velocities(context, state)
    count_sliding(context, candidate)
    evaluate_accelerations(context, t, q, v, candidate, ws.second_half(context, ws.DELTA))
    if context[ft.SLIDING_COUNT] != 0:
        k = find_unsupported(context, t, q, v)
        if k != CONSISTENT:
            return k
    open_members = 0
    for i in range(count):
        signs[i] = 0
        open_members += 1 if candidate[members[i]] != SLIDING else 0
    distance = d * _FIRST
    while open_members > 0 and distance <= 1.5 * d:
        look_ahead(context, t, distance, state)
        for i in range(count):
            k = members[i]
            change = ahead[k] - g[k]
            significant = abs(change) > _SIGNIFICANT * max(largest[k], abs(g[k]))
            if signs[i] == 0 and significant and candidate[k] != SLIDING:
                signs[i] = 1 if change > 0.0 else -1
                open_members -= 1
        distance *= 10.0
    for i in range(count):
        k = int(members[i])
        if candidate[k] == SLIDING:
            continue
        if not np.isfinite(ahead[k]):
            return k
        if int(preferred[k]) == decided_entry(candidate[k]):
            continue
        # A contact that others keep closed may touch without a force of its own; friction at rest
        # may exert any force within its bounds, also those at their ends.
        touches = (rigid[k] >= 0 or sticks[k] != 0) and signs[i] == 0
        if not touches and (signs[i] > 0) != (candidate[k] != 0):
            return k
    return CONSISTENT
