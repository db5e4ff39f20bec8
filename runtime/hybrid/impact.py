"""Contacts and freewheels: impacts, the end of bouncing, the return onto switching surfaces."""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context, Vector
from runtime.core.jit import addressed, inner
from runtime.core.modes_and_event_kinds import FREE, ONE_WAY, SLIDING
from runtime.hybrid import filippov_shares as shares
from runtime.hybrid.coupled_sliding_friction import put_friction_on_law
from runtime.hybrid.impact_impulses import apply_impulses, evaluate_directions
from runtime.hybrid.redundant_sliding import is_resting, solve_least
from runtime.hybrid.stiction_force import is_prescribed
from runtime.linalg.lu import solve_equilibrated
from runtime.linalg.rank_policy import SAME_HOLD
from runtime.linalg.vectors import copy_vector

ON_SURFACE = 1e-13  # accuracy: |g| over its running maximum below which g is zero at an event

_LOW_FLIGHT = 0.01  # accuracy: of the tolerance of a position; flights that rise no higher are over
_UNSEEN = 2e-12  # accuracy: of the largest gap; heights at which rounding moves the next impact


@inner
def find_largest_gap(context: Context, k: int) -> float:
    """Running maximum of the gap of contact `k`, open or closed."""
    return float(context.reserve[k] if context.modes[k] == SLIDING else context.largest[k])


@inner
def evaluate_free_gap(context: Context, t: float, q: Vector, v: Vector, first: int) -> float:
    """Second derivative of the gap of contact `first` under `modes`, in which it is open."""
    a, gaps = context.base_accelerations, context.response_gaps
    shares.evaluate_units(context, t, q, v, context.modes)
    if context[ft.SLIDING_COUNT] > 0:
        shares.solve_shares(context, t, q, v)
        put_friction_on_law(context, t, q, v)
        shares.combine_accelerations(context, a)
    abi.gap_accelerations_of(context)(t, q, v, a, context.parameters, gaps)
    return float(gaps[context.rigid[first]])


@inner
def close_contacts(context: Context, first: int, t: float, q: Vector, v: Vector) -> None:
    """Close `first`, all contacts that touch and all freewheels, and open all else.

    Friction gives no impulse. A freewheel that overruns may get one: its slip may not be negative.
    """
    modes, gaps = context.modes, context.right_side
    abi.switching_of(context)(t, q, v, context.parameters, gaps)
    for k in range(context[ft.SWITCHES]):
        touches = abs(gaps[k]) <= ON_SURFACE * find_largest_gap(context, k)
        if context.sticks[k] == ONE_WAY:
            modes[k] = SLIDING
        elif context.rigid[k] < 0 and modes[k] == SLIDING:
            modes[k] = FREE if is_prescribed(context, k) else 0
        elif context.rigid[k] >= 0 and touches:
            modes[k] = SLIDING
    modes[first] = SLIDING


@addressed(ft.IMPACT)
def apply_impact(context: Context, first: int, t: float, state: int) -> float:
    """Change the velocities in row `state` by the impact of contact or freewheel `first`.

    Newton's law, ġ⁺ = -e ġ⁻, with impulses that only push, and with those that hold the other
    contacts that touch: v⁺ = v⁻ + Σ P_i d_i, P_i ≥ 0, ġ_i⁺ ≥ -e_i ġ_i⁻, one of the two an
    equality; without rebound where no such velocities exist. The directions d_i are those in which
    the forces of the contacts accelerate the machine. Freewheels take part, with their slips in the
    place of ġ and e = 0.

    Where the next flight would rise no higher than tolerances resolve, bouncing ends: all further
    flights, each e times as long as the one before, take T/(1 - e) together, and the contact
    closes: its mode becomes SLIDING.

    Returns the time T of the next flight, T/(1 - e) negative where it is the last, infinite where
    the contact does not return by itself.
    """
    modes, former, rates = context.modes, context.now, context.rate_now
    p, any_a = context.parameters, context.base_accelerations
    q, v = ws.positions(context, state), ws.velocities(context, state)
    before, sliding_count = modes[first], context[ft.SLIDING_COUNT]
    copy_vector(modes, former)
    close_contacts(context, first, t, q, v)
    apply_impulses(context, t, q, v)
    for k in range(context[ft.SWITCHES]):
        modes[k] = int(former[k])
    if context.rigid[first] < 0:
        context[ft.SLIDING_COUNT] = sliding_count
        return np.inf
    abi.switching_rates_of(context)(t, q, v, any_a, p, rates)
    leaving = rates[first]
    # The motion of the gap after the contact has opened.
    modes[first] = 1
    fall = evaluate_free_gap(context, t, q, v, first)
    modes[first] = before
    context[ft.SLIDING_COUNT] = sliding_count
    if not fall < 0.0:
        return np.inf
    flight = -2.0 * leaving / fall
    e = context.restitution_coefficients[context.rigid[first]]
    atol, finest = ws.first_half(context, ws.ATOL), np.inf
    for j in range(atol.size):
        finest = min(finest, atol[j])
    unseen = max(_LOW_FLIGHT * finest, _UNSEEN * find_largest_gap(context, first))
    if -0.5 * leaving * leaving / fall > unseen or e >= 1.0:
        # Where the gap still closes, constraints permitted no jump.
        return float(flight) if flight > 0.0 else np.inf
    modes[first] = SLIDING
    return -float(max(flight, 1e-300) / (1.0 - e))


@inner
def fill_distances(context: Context, level: int) -> None:
    """Fill the matrix and the right side of the return onto surfaces: of gaps (level 0), of rates.

    At level 0 functions that are no closed contacts stay where they are; those that rest stay
    at both.
    """
    right, copy, count = context.right_side, context.response_copy, context[ft.SLIDING_COUNT]
    for i in range(count):
        k = context.sliding_functions[i]
        closed = context.rigid[k] >= 0
        value = context.response_rates[k] if level == 1 and closed else context.base_response[k]
        stays = is_resting(context, i) or (level == 0 and not closed)
        right[i] = 0.0 if stays else value
        for j in range(count):
            copy[i * count + j] = context.response[i * count + j]
            if stays:
                copy[i * count + j] = 1.0 if i == j else 0.0


@addressed(ft.RETURN_TO_SURFACES)
def return_to_surfaces(context: Context, t: float, state: int) -> int:
    """Return the state in row `state` onto the surfaces of functions in sliding mode.

    It moves along the accelerations by their forces. These keep the constraints of velocities, and
    those of positions up to the square of the correction.
    """
    p, right, copy = context.parameters, context.right_side, context.response_copy
    q, v = ws.positions(context, state), ws.velocities(context, state)
    evaluate_directions(context, t, q, v)
    count = context[ft.SLIDING_COUNT]
    # First the gaps, then the velocities.
    for level in range(0 if context[ft.RIGID_COUNT] > 0 else 1, 2):
        abi.switching_of(context)(t, q, v, p, context.base_response)
        any_a = context.base_accelerations  # the rate of a gap does not depend on it
        abi.switching_rates_of(context)(t, q, v, any_a, p, context.response_rates)
        fill_distances(context, level)
        if solve_equilibrated(copy, right, count, context.response_pivots, SAME_HOLD) != 0:
            fill_distances(context, level)
            for c in range(count):
                context.response_column[c] = 1.0
            # Dependent surfaces contradict each other by rounding.
            if solve_least(context, np.inf) != 0:
                return 1
        for j in range(q.size):
            total, largest = shares.add_units(context, j, 0.0)
            if level == 0:
                q[j] -= total
            else:
                rests = abs(v[j] - total) <= shares.CANCELLED * max(largest, abs(v[j]))
                v[j] = 0.0 if rests else v[j] - total
    return 0
