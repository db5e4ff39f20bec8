"""Switching functions along a run: g itself, or how far what holds g at zero is from letting go."""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.array_views import view
from runtime.core.function_table import (
    COORDINATES,
    MARGINS,
    SLIDING_COUNT,
    SWITCHES,
    bent_of,
    limited_of,
    limits_of,
    margins_of,
    modes_of,
    multipliers_of,
    parameters_of,
    settings_of,
    share_high_of,
    share_low_of,
    share_of,
)
from runtime.core.jit import addressed, inlined, inner
from runtime.core.kernel_abi import switching_of, switching_rates_of
from runtime.core.workspace import (
    DELTA,
    SAMPLE,
    first_half,
    positions,
    row_of,
    switch_row,
    velocities,
    velocity_rates,
)
from runtime.hybrid.sliding_modes import HELD_MODE
from runtime.hybrid.sliding_rhs import STEP

_AHEAD = 1e-4  # accuracy: of a step; the distance over which the rate of a margin is differenced
UNBOUNDED = -1e300  # code: a lower bound below this is none


@inlined
def functions(context: Integers, t: float, state: int, slot: int) -> None:
    """Write g at the state in row `state` of the workspace into row `slot` of `sw`.

    In the place of a function that is held stands its margin, which is positive as long as its
    share lies between its bounds.
    """
    p = parameters_of(context)
    q, v = positions(context, state), velocities(context, state)
    switching_of(context)(t, q, v, p, switch_row(context, slot))
    if context[SLIDING_COUNT] != 0:
        margins_of(context)(context, t, state, slot)


@inner
def margin(context: Integers, t: float, q: Vector, v: Vector, s: int, k: int) -> float:
    """How far what holds function `k` is from letting go: zero where it does, negative beyond.

    That is the share's distance from its bounds, or what is left of the force that friction bears.
    """
    if limits_of(context)[2 * k] >= 0:
        return float(limited_of(context)(context, t, q, v, k))
    share = share_of(context)[k]
    low, high = share_low_of(context)[k], share_high_of(context)[k]
    room = high - share
    if low >= UNBOUNDED:
        room *= (share - low) / (high - low)
    return float(room) if np.isfinite(room) else -1.0


@addressed(MARGINS)
def margins(context: Integers, t: float, state: int, slot: int) -> None:
    """Write the margins of what is held over its functions in row `slot` of `sw`."""
    s = context[SWITCHES]
    modes, lam = modes_of(context), multipliers_of(context)
    q, v = positions(context, state), velocities(context, state)
    bent_of(context)(context, t, q, v, modes, first_half(context, DELTA), lam)
    for k in range(s):
        if modes[k] == HELD_MODE:
            switch_row(context, slot)[k] = margin(context, t, q, v, s, k)


@inner
def measure(context: Integers, t: float, state: int, derivative: int, slot: int) -> None:
    """Write g into row `slot` of `sw` and dg/dt into the next, for two rows of the workspace.

    The rate of a margin is a difference along the motion.
    """
    p = parameters_of(context)
    modes = modes_of(context)
    lam = multipliers_of(context)
    n = context[COORDINATES]
    s = context[SWITCHES]
    functions(context, t, state, slot)
    q, v = positions(context, state), velocities(context, state)
    a = velocity_rates(context, derivative)
    rates = switch_row(context, slot + 1)
    switching_rates_of(context)(t, q, v, a, p, rates)
    if context[SLIDING_COUNT] == 0:
        return
    y = row_of(context, state)
    z = row_of(context, SAMPLE)
    ahead = _AHEAD * settings_of(context)[STEP]
    for j in range(n):
        z[j] = y[j] + ahead * (y[n + j] + 0.5 * ahead * a[j])
        z[n + j] = y[n + j] + ahead * a[j]
    z_q, z_v = view(z, 0, n), view(z, n, n)
    bent_of(context)(context, t + ahead, z_q, z_v, modes, first_half(context, DELTA), lam)
    for k in range(s):
        if modes[k] == HELD_MODE:
            rates[k] = (
                margin(context, t + ahead, z_q, z_v, s, k) - switch_row(context, slot)[k]
            ) / ahead
