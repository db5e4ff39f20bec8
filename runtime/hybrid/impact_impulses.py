"""Impulses of an impact: of rigid contacts that rebound, and of freewheels that grip."""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core.array_types import Context, Vector
from runtime.core.jit import inner
from runtime.core.modes_and_event_kinds import FREE, ONE_WAY, SLIDING
from runtime.core.unowned_array_views import view
from runtime.hybrid import filippov_shares as shares
from runtime.hybrid.stiction_force import is_prescribed
from runtime.linalg.lu import solve_equilibrated
from runtime.linalg.rank_policy import SAME_HOLD
from runtime.linalg.vectors import axpy, copy_vector, largest_magnitude

SLOW = 1e-12  # accuracy: of the largest velocity; a freewheel whose slip is slower may grip

_SWEEPS = 200  # safety: sweeps over all contacts with rebound, and as many again without
_PIVOTS = 10  # safety: of a contact in an impact; changes of the part that it takes
_AGREED = 1e-14  # accuracy: of the fastest approach; change by a sweep at which impulses agree
_ROUNDING = 1e-15  # accuracy: of the largest velocity; the same
_HOPELESS = 1e-6  # accuracy: of the fastest approach; larger changes mean no convergence


@inner
def evaluate_directions(context: Context, t: float, q: Vector, v: Vector) -> None:
    """Fill the units of the functions in sliding mode, without friction that they would cause.

    Friction that sticks elsewhere is free meanwhile, and friction that creeps exerts nothing where
    nothing moves; what acts beside a condition depends on the velocities.
    """
    free, still = context.candidate_modes, view(context.weights, v.size, v.size)
    copy_vector(context.modes, free)
    copy_vector(v, still)
    if context[ft.SUPERPOSES] == 0:
        moves = False
        for k in range(context[ft.SWITCHES]):
            prescribed = is_prescribed(context, k)
            moves = moves or (free[k] == SLIDING and not prescribed)
            if free[k] != SLIDING and context.rigid[k] < 0 and prescribed:
                free[k] = FREE
        if not moves:
            still.fill(0.0)
    shares.evaluate_units(context, t, q, still, free)


@inner
def evaluate_approach(context: Context, t: float, q: Vector, v: Vector) -> None:
    """Write what an impact changes into RATE_NOW: the rates of gaps, the slips of freewheels."""
    p, rates, g = context.parameters, context.rate_now, context.response_rates
    any_a, found = context.base_accelerations, False  # the rate of a gap does not depend on it
    abi.switching_rates_of(context)(t, q, v, any_a, p, rates)
    for k in range(context[ft.SWITCHES]):
        if context.sticks[k] == ONE_WAY:
            if not found:
                abi.switching_of(context)(t, q, v, p, g)
                found = True
            rates[k] = g[k]


@inner
def settle_impulses(context: Context, t: float, q: Vector, v: Vector) -> int:
    """Change v by exact impulses, from those of sweeps that converge too slowly; 1 without any.

    Principal pivots of least index (K. G. Murty, 1974): what pushes keeps its target, all else has
    no impulse, and the first that contradicts its own condition changes its part.
    """
    rates, impulse, target = context.rate_now, context.right_side, context.response_column
    pushes, change, copy = context.candidate_modes, context.base_response, context.response_copy
    count, wrong = context[ft.SLIDING_COUNT], 0
    for c in range(count):
        pushes[c] = 1 if impulse[c] > 0.0 else 0
    for _ in range(_PIVOTS * count):
        evaluate_approach(context, t, q, v)
        fastest, largest = 0.0, 0.0
        for c in range(count):
            k = context.sliding_functions[c]
            fastest = max(fastest, abs(rates[k]), target[c])
            change[c] = target[c] - rates[k] if pushes[c] != 0 else -impulse[c]
            for j in range(count):
                own = 1.0 if j == c else 0.0
                pushing = pushes[c] != 0
                copy[c * count + j] = -context.response[c * count + j] if pushing else own
        if solve_equilibrated(copy, change, count, context.response_pivots, SAME_HOLD) != 0:
            return 1
        for c in range(count):
            axpy(-change[c], context.unit_accelerations[c], v)
            impulse[c] = impulse[c] + change[c] if pushes[c] != 0 else 0.0
            largest = max(largest, abs(impulse[c]))
        former, wrong = wrong, -1
        evaluate_approach(context, t, q, v)
        least = _AGREED * fastest + _ROUNDING * largest_magnitude(v)
        for c in range(count):
            short = target[c] - rates[context.sliding_functions[c]]
            pulls = pushes[c] != 0 and impulse[c] < -_AGREED * largest
            if wrong < 0 and (pulls or (pushes[c] == 0 and short > least)):
                wrong = c
        if wrong < 0 and former < 0:
            return 0  # a second solution has refined the first
        if wrong >= 0:
            pushes[wrong] = 1 - pushes[wrong]
    return 1


@inner
def sweep_impulses(context: Context, t: float, q: Vector, v: Vector) -> None:
    """Change v by the impulses that reach the targets, by projected Gauss-Seidel sweeps."""
    rates, impulse, target = context.rate_now, context.right_side, context.response_column
    count, fastest = context[ft.SLIDING_COUNT], 0.0
    evaluate_approach(context, t, q, v)
    for c in range(count):
        impulse[c] = 0.0
        fastest = max(fastest, abs(rates[context.sliding_functions[c]]))
    rounding = _ROUNDING * largest_magnitude(v)
    for sweep in range(2 * _SWEEPS):
        moved = 0.0
        for c in range(count):
            k = context.sliding_functions[c]
            evaluate_approach(context, t, q, v)
            gain = -context.response[c * count + c]
            more = max((target[c] - rates[k]) / gain, -impulse[c]) if gain > 0.0 else 0.0
            axpy(-more, context.unit_accelerations[c], v)
            impulse[c] += more
            moved = max(moved, abs(more * gain))
        if not moved > _AGREED * fastest + rounding:
            break
        if sweep == _SWEEPS - 1:
            if settle_impulses(context, t, q, v) == 0:
                break
            if moved > _HOPELESS * fastest:
                # Bodies without clearance cannot rebound from each other.
                for c in range(count):
                    target[c] = 0.0


@inner
def apply_impulses(context: Context, t: float, q: Vector, v: Vector) -> None:
    """Change v by the impulses of all functions in sliding mode, contacts and freewheels.

    First contacts rebound, ġ⁺ ≥ -e ġ⁻, and freewheels that do not overrun give no way. Those that
    overrun grip after that where the rebound has made their drivers faster, with e = 0 for all: at
    once with the rebound they would bring energy.
    """
    rates, target, overruns = context.rate_now, context.response_column, False
    evaluate_directions(context, t, q, v)
    evaluate_approach(context, t, q, v)
    slow = SLOW * largest_magnitude(v)
    for c in range(context[ft.SLIDING_COUNT]):
        k = context.sliding_functions[c]
        if context.rigid[k] >= 0:
            target[c] = -context.restitution_coefficients[context.rigid[k]] * min(rates[k], 0.0)
        else:
            target[c] = 0.0 if rates[k] <= slow else -np.inf
            overruns = overruns or rates[k] > slow
    sweep_impulses(context, t, q, v)
    evaluate_approach(context, t, q, v)
    grips = False
    for c in range(context[ft.SLIDING_COUNT]):
        k = context.sliding_functions[c]
        grips = grips or (overruns and context.rigid[k] < 0 and rates[k] < -slow)
        target[c] = 0.0
    if grips:
        sweep_impulses(context, t, q, v)
