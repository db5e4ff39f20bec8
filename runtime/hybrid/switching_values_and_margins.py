"""Switching functions g along a run; in sliding modes their margins stand in their place."""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context, Vector
from runtime.core.jit import addressed, inlined, inner
from runtime.core.modes_and_event_kinds import SLIDING
from runtime.hybrid.redundant_sliding import is_resting
from runtime.hybrid.rhs_with_sliding_or_stabilization import STEP

_AHEAD = 1e-4  # accuracy: of a step; the distance over which the rate of a margin is differenced
_RESTING = 1e-13  # accuracy: of the largest |g|; a function that rests is no further off
TINY = 1e-300  # safety: added to a divisor that may be zero
UNBOUNDED = -1e300  # code: lower bounds below it mean none


@inlined
def evaluate_switching(context: Context, t: float, state: int, slot: int) -> None:
    """Write g at the state in row `state` of the workspace into row `slot` of `sw`.

    In sliding mode the margin stands in the place of g. It is positive as long as the share lies
    between its bounds.
    """
    q, v = ws.positions(context, state), ws.velocities(context, state)
    abi.switching_of(context)(t, q, v, context.parameters, ws.switch_row(context, slot))
    if context[ft.SLIDING_COUNT] != 0:
        ft.margins_of(context)(context, t, state, slot)


@inner
def compute_margin(context: Context, t: float, q: Vector, v: Vector, k: int) -> float:
    """Margin of function `k` in sliding mode: positive inside, zero where it leaves its surface.

    It is the distance of the share from its bounds, or the part of the friction limit that is left.
    """
    if context.limits[2 * k] >= 0:
        return float(ft.friction_margin_of(context)(context, t, q, v, k))
    share = context.share[k]
    low, high = context.share_low[k], context.share_high[k]
    room = high - share
    if low >= UNBOUNDED:
        room *= (share - low) / (high - low)
    return float(room) if np.isfinite(room) else -1.0


@addressed(ft.MARGINS)
def write_margins(context: Context, t: float, state: int, slot: int) -> None:
    """Write the margins of functions in sliding mode over their g in row `slot` of `sw`."""
    q, v = ws.positions(context, state), ws.velocities(context, state)
    margins = ws.switch_row(context, slot)
    a, lam = context.first_scratch, context.multipliers
    ft.modified_accelerations_of(context)(context, t, q, v, context.modes, a, lam)
    for k in range(context[ft.SWITCHES]):
        if context.modes[k] == SLIDING:
            margins[k] = compute_margin(context, t, q, v, k)
    for c in range(context[ft.SLIDING_COUNT]):
        if is_resting(context, c):
            k = context.sliding_functions[c]
            abi.switching_of(context)(t, q, v, context.parameters, context.base_response)
            width = _RESTING * context.reserve[k] + TINY
            margins[k] = 1.0 - abs(context.base_response[k]) / width


@inner
def extrapolate(context: Context, state: int, a: Vector, d: float) -> None:
    """Write the state in row `state` after a time `d` at the acceleration `a` into row SAMPLE."""
    y, z, n = ws.row_of(context, state), ws.row_of(context, ws.SAMPLE), context[ft.COORDINATES]
    for j in range(n):
        z[j] = y[j] + d * (y[n + j] + 0.5 * d * a[j])
        z[n + j] = y[n + j] + d * a[j]


@inner
def evaluate_switching_and_rates(
    context: Context, t: float, state: int, derivative: int, slot: int
) -> None:
    """Write g into row `slot` of `sw` and dg/dt into the next.

    The workspace holds the state in row `state`, its derivative in row `derivative`. The rate of a
    margin is a difference along the motion.
    """
    q, v = ws.positions(context, state), ws.velocities(context, state)
    a, rates = ws.velocity_rates(context, derivative), ws.switch_row(context, slot + 1)
    evaluate_switching(context, t, state, slot)
    abi.switching_rates_of(context)(t, q, v, a, context.parameters, rates)
    if context[ft.SLIDING_COUNT] == 0:
        return
    ahead = _AHEAD * context.settings[STEP]
    extrapolate(context, state, a, ahead)
    ft.margins_of(context)(context, t + ahead, ws.SAMPLE, slot + 1)
    now = ws.switch_row(context, slot)
    for k in range(context[ft.SWITCHES]):
        if context.modes[k] == SLIDING:
            rates[k] = (rates[k] - now[k]) / ahead
    for c in range(context[ft.SLIDING_COUNT]):
        if is_resting(context, c):
            # Off the constraints, where the joints do not keep it at zero, a difference is wrong.
            k, g, slopes = (
                context.sliding_functions[c],
                context.base_response,
                context.response_rates,
            )
            abi.switching_of(context)(t, q, v, context.parameters, g)
            abi.switching_rates_of(context)(t, q, v, a, context.parameters, slopes)
            rates[k] = -np.sign(g[k]) * slopes[k] / (_RESTING * context.reserve[k] + TINY)
