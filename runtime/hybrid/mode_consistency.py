"""Whether modes agree with the motion that follows from them, in a short look ahead."""

import numpy as np

from runtime.core.array_views import floats_at, integers_at, view
from runtime.core.function_table import (
    BENDS,
    CONSTRAINT_COUNT,
    COORDINATES,
    HELD,
    HIGH,
    LIMITS,
    LOW,
    PLAIN,
    RIGID,
    RIGID_COUNT,
    SHARE,
    STABILIZED,
    STICKS,
    WORK,
    limited_of,
    switching_of,
)
from runtime.core.jit import inner
from runtime.core.rhs import field
from runtime.core.signatures import Integers, Vector
from runtime.core.workspace import (
    DELTA,
    LARGEST,
    NOW,
    PREFERRED,
    ROWS,
    SAMPLE,
    SWITCH_ROWS,
    TRIAL,
)
from runtime.hybrid.sliding_modes import HELD_MODE

CONSISTENT = -1
GIVEN = 4  # is added to a preferred mode that is known to be right, and needs no look-ahead
_SIGNIFICANT = 1e-14  # accuracy: change of g over its maximum that is more than rounding
_FIRST = 1e-7  # measured: first look-ahead over the last
MISSED = 1e-9  # accuracy: amount by which a share may miss its bounds at an event


@inner
def carry(
    machine: Integers, t: float, d: float, state: int, w: Vector, sw: Vector, p: Vector
) -> None:
    """Write into row TRIAL of `sw` the functions after a time `d` at constant acceleration.

    The acceleration is the second half of row DELTA.
    """
    n = w.size // (2 * ROWS)
    s = sw.size // SWITCH_ROWS
    y = view(w, state * 2 * n, 2 * n)
    a = view(w, DELTA * 2 * n + n, n)
    z = view(w, SAMPLE * 2 * n, 2 * n)
    for j in range(n):
        z[j] = y[j] + d * (y[n + j] + 0.5 * d * a[j])
        z[n + j] = y[n + j] + d * a[j]
    q, v = view(w, SAMPLE * 2 * n, n), view(w, SAMPLE * 2 * n + n, n)
    switching_of(machine)(t + d, q, v, p, view(sw, TRIAL * s, s))


@inner
def hold(machine: Integers, modes: Integers) -> None:
    """Make the field that of `modes`: count what is held."""
    count = 0
    for k in range(modes.size):
        count += 1 if modes[k] == HELD_MODE else 0
    machine[HELD] = count
    machine[BENDS] = count + machine[STABILIZED]


@inner
def loose(machine: Integers, t: float, q: Vector, v: Vector, p: Vector, lam: Vector, s: int) -> int:
    """First function that is said to be held and that nothing holds, else `CONSISTENT`.

    To be called after the field was evaluated.
    """
    n, m = machine[COORDINATES], machine[CONSTRAINT_COUNT]
    size = n + m
    work = floats_at(machine, WORK, (s + 2) * size + 2 * s * s + 4 * s + machine[RIGID_COUNT])
    matrix = view(work, (s + 1) * size, s * s)
    share = floats_at(machine, SHARE, s)
    low, high = floats_at(machine, LOW, s), floats_at(machine, HIGH, s)
    count = machine[HELD]
    held = view(integers_at(machine, PLAIN, 2 * s), s, s)
    for c in range(count):
        k = int(held[c])
        inside = low[k] - MISSED <= share[k] <= high[k] + MISSED
        if integers_at(machine, LIMITS, 2 * s)[2 * k] >= 0:
            inside = limited_of(machine)(machine, t, q, v, p, lam, k) >= -MISSED
        if not inside or not matrix[c * count + c] < 0.0:
            return k
    return CONSISTENT


@inner
def contradicted(
    machine: Integers,
    t: float,
    d: float,
    state: int,
    w: Vector,
    sw: Vector,
    p: Vector,
    candidate: Integers,
    lam: Vector,
    members: Integers,
    count: int,
    signs: Integers,
) -> int:
    """First of the `count` members that does not go to the side that its candidate mode claims.

    Returns `CONSISTENT` where all do. `signs` receives where each goes: -1, 0 or 1.
    """
    n = w.size // (2 * ROWS)
    s = sw.size // SWITCH_ROWS
    g = view(sw, NOW * s, s)
    ahead = view(sw, TRIAL * s, s)
    largest = view(sw, LARGEST * s, s)
    preferred = view(sw, PREFERRED * s, s)
    rigid, sticks = integers_at(machine, RIGID, s), integers_at(machine, STICKS, s)
    q = view(w, state * 2 * n, n)
    v = view(w, state * 2 * n + n, n)
    hold(machine, candidate)
    field(machine, t, q, v, p, candidate, view(w, DELTA * 2 * n + n, n), lam)
    if machine[HELD] != 0:
        k = loose(machine, t, q, v, p, lam, s)
        if k != CONSISTENT:
            return k
    open_members = 0
    for i in range(count):
        signs[i] = 0
        open_members += 1 if candidate[members[i]] != HELD_MODE else 0
    distance = d * _FIRST
    while open_members > 0 and distance <= 1.5 * d:
        carry(machine, t, distance, state, w, sw, p)
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
