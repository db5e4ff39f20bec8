"""Switching functions g along a run; in sliding modes their margins stand in their place."""

import numpy as np

from runtime.core import function_table as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace as ws
from runtime.core.array_types import Integers, Vector
from runtime.core.array_views import view
from runtime.core.jit import addressed, inlined, inner
from runtime.core.modes import SLIDING
from runtime.hybrid.sliding_rhs import STEP

_AHEAD = 1e-4  # accuracy: of a step; the distance over which the rate of a margin is differenced
UNBOUNDED = -1e300  # code: lower bounds below it mean none


@inlined
def evaluate_switching(context: Integers, t: float, state: int, slot: int) -> None:
    """Write g at the state in row `state` of the workspace into row `slot` of `sw`.

    In sliding mode the margin stands in the place of g. It is positive as long as the share lies
    between its bounds.
    """
    p = ft.parameters_of(context)
    q, v = ws.positions(context, state), ws.velocities(context, state)
    abi.switching_of(context)(t, q, v, p, ws.switch_row(context, slot))
    if context[ft.SLIDING_COUNT] != 0:
        ft.margins_of(context)(context, t, state, slot)


@inner
def compute_margin(context: Integers, t: float, q: Vector, v: Vector, k: int) -> float:
    """Margin of function `k` in sliding mode: positive inside, zero where it leaves its surface.

    It is the distance of the share from its bounds, or the part of the friction limit that is left.
    """
    if ft.limits_of(context)[2 * k] >= 0:
        return float(ft.friction_margin_of(context)(context, t, q, v, k))
    share = ft.share_of(context)[k]
    low, high = ft.share_low_of(context)[k], ft.share_high_of(context)[k]
    room = high - share
    if low >= UNBOUNDED:
        room *= (share - low) / (high - low)
    return float(room) if np.isfinite(room) else -1.0


@addressed(ft.MARGINS)
def write_margins(context: Integers, t: float, state: int, slot: int) -> None:
    """Write the margins of functions in sliding mode over their g in row `slot` of `sw`."""
    s = context[ft.SWITCHES]
    modes, lam = ft.modes_of(context), ft.multipliers_of(context)
    q, v = ws.positions(context, state), ws.velocities(context, state)
    ft.modified_accelerations_of(context)(
        context, t, q, v, modes, ws.first_half(context, ws.DELTA), lam
    )
    for k in range(s):
        if modes[k] == SLIDING:
            ws.switch_row(context, slot)[k] = compute_margin(context, t, q, v, k)


@inner
def evaluate_switching_and_rates(
    context: Integers, t: float, state: int, derivative: int, slot: int
) -> None:
    """Write g into row `slot` of `sw` and dg/dt into the next.

    The workspace holds the state in row `state`, its derivative in row `derivative`. The rate of a
    margin is a difference along the motion.
    """
    p, modes = ft.parameters_of(context), ft.modes_of(context)
    lam, n = ft.multipliers_of(context), context[ft.COORDINATES]
    s = context[ft.SWITCHES]
    evaluate_switching(context, t, state, slot)
    q, v = ws.positions(context, state), ws.velocities(context, state)
    a = ws.velocity_rates(context, derivative)
    rates = ws.switch_row(context, slot + 1)
    abi.switching_rates_of(context)(t, q, v, a, p, rates)
    if context[ft.SLIDING_COUNT] == 0:
        return
    y, z = ws.row_of(context, state), ws.row_of(context, ws.SAMPLE)
    ahead = _AHEAD * ft.settings_of(context)[STEP]
    for j in range(n):
        z[j] = y[j] + ahead * (y[n + j] + 0.5 * ahead * a[j])
        z[n + j] = y[n + j] + ahead * a[j]
    z_q, z_v = view(z, 0, n), view(z, n, n)
    ft.modified_accelerations_of(context)(
        context, t + ahead, z_q, z_v, modes, ws.first_half(context, ws.DELTA), lam
    )
    for k in range(s):
        if modes[k] == SLIDING:
            rates[k] = (
                compute_margin(context, t + ahead, z_q, z_v, k) - ws.switch_row(context, slot)[k]
            ) / ahead
