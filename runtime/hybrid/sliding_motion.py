"""Motion in sliding modes: its right-hand side, and the values and margins of its functions.

In sliding modes the margin of a switching function stands in the place of its value.

With Baumgarte's method the constraints are not recovered but pulled back, as a damped spring would:
Φ̈ + 2 Φ̇/τ + Φ/τ² = 0 (J. Baumgarte, Computer Methods in Applied Mechanics and Engineering 1, 1972,
with α = β = 1/τ). Accelerations depend on the right side of Φ_q q̈ = γ by the same map as the
corrections of `correction` in the metric of the masses on theirs, so no kernel is needed for it.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Integers, Vector, view
from runtime.core.jit import addressed, inlined, inner
from runtime.core.kinds import SLIDING
from runtime.core.state_derivative import write_derivative
from runtime.hybrid import filippov_shares as shares
from runtime.hybrid.filippov_shares import put_friction_on_law
from runtime.hybrid.rest_forces import is_resting, write_forces
from runtime.linalg.vectors import axpy, copy_vector, largest_ratio

STEP, TIME_SCALE = 0, 1  # places in SETTINGS: the length of the step, s; τ of Baumgarte's method, s

_AHEAD = 1e-4  # accuracy: of a step; distance in the difference quotient of a margin's rate
_RESTING = 1e-13  # accuracy: of the largest |g|; a function that rests is nearer to zero
TINY = 1e-300  # safety: added to a divisor that may be zero
UNBOUNDED = -1e300  # code: lower bounds below it mean none


@inner
def exclude_rounding(value: Vector, change: Vector, size: Vector) -> float:
    """The part of a correction that exceeds the rounding of the state.

    Rounding of a state must not be corrected: τ⁻² of it would be a force. It goes by the sizes of
    coordinates, not by masses. All coordinates are pulled at by the same part, as without some of
    them the pull would do work along the constraints.
    """
    moved, rounded = largest_ratio(change, size), shares.CANCELLED * largest_ratio(value, size)
    return 1.0 - rounded / moved if moved > rounded else 0.0


@addressed(ft.ACCELERATIONS)
def evaluate_sliding_accelerations(
    context: Context, t: float, q: Vector, v: Vector, modes: Integers, a: Vector, lam: Vector
) -> int:
    """Accelerations and multipliers as the kernel `accelerations`, in sliding modes.

    SHARE receives the share of each function in sliding mode.
    """
    weak = shares.evaluate_units(context, t, q, v, modes)
    shares.solve_shares(context, t, q, v)
    put_friction_on_law(context, t, q, v)
    write_forces(context)
    shares.combine_accelerations(context, a)
    copy_vector(context.base_multipliers, lam)
    for c in range(context[ft.SLIDING_COUNT]):
        axpy(context.share[context.sliding_functions[c]], context.unit_multipliers[c], lam)
    return int(weak)


@addressed(ft.ACCELERATIONS)
def evaluate_modified_accelerations(
    context: Context, t: float, q: Vector, v: Vector, modes: Integers, a: Vector, lam: Vector
) -> int:
    """Accelerations and multipliers as the kernel `accelerations`, sliding modes included."""
    p, n, pull = context.parameters, context[ft.COORDINATES], context.weights
    if context[ft.SLIDING_COUNT] == 0:
        weak = int(abi.accelerations_of(context)(t, q, v, p, modes, a, lam))
    else:
        weak = int(ft.sliding_accelerations_of(context)(context, t, q, v, modes, a, lam))
    if context[ft.STABILIZED] != 0 and context[ft.CONSTRAINT_COUNT] > 0:
        tau = context.settings[TIME_SCALE]
        dq, dv, size = view(pull, n, n), view(pull, 2 * n, n), view(pull, 3 * n, n)
        abi.correction_of(context)(t, q, v, p, view(pull, 0, n), dq, dv)
        part, rate = exclude_rounding(q, dq, size), exclude_rounding(v, dv, size)
        for j in range(n):
            a[j] += part * dq[j] / (tau * tau) + rate * 2.0 * dv[j] / tau
    return weak


@addressed(ft.RHS)
def evaluate_modified_rhs(context: Context, t: float, state: int, derivative: int) -> int:
    """The right-hand side in sliding modes, with stabilisation, and where stages are corrected."""
    taken = 0
    if context[ft.EACH_STAGE] != 0:
        taken = int(ft.correct_of(context)(context, t, state, ws.PARTITION))
    write_derivative(context, t, state, derivative)
    return taken


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
