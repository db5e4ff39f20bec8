"""Rigid contacts in an instant: impacts, the end of bouncing, and the return onto what is held."""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.array_views import view
from runtime.core.function_table import (
    COORDINATES,
    IMPACT,
    RETURN_HELD,
    RIGID_COUNT,
    SLIDING_COUNT,
    SWITCHES,
    base_accelerations_of,
    base_response_of,
    modes_of,
    parameters_of,
    response_column_of,
    response_copy_of,
    response_gaps_of,
    response_of,
    response_rates_of,
    restitution_of,
    right_side_of,
    rigid_of,
    share_of,
    sliding_functions_of,
    stiction_place_of,
    unit_accelerations_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import gap_accelerations_of, switching_of, switching_rates_of
from runtime.core.workspace import (
    ATOL,
    LARGEST,
    NOW,
    RATE_NOW,
    RESERVE,
    positions,
    row_of,
    switch_row,
    velocities,
)
from runtime.hybrid.degenerate_sliding import least
from runtime.hybrid.sliding_modes import CANCELLED, HELD_MODE, shares, units
from runtime.hybrid.stiction_force import FREE_MODE
from runtime.linalg.lu import solve_equilibrated
from runtime.linalg.rank_policy import SAME_HOLD

ON_SURFACE = 1e-13  # accuracy: |g| over its running maximum below which g is zero at an event

_SWEEPS = 200  # safety: sweeps over all contacts with rebound, and as many again without
# accuracy: of the fastest approach; change by a sweep at which impulses have converged
_AGREED = 1e-14
_ROUNDING = 1e-15  # accuracy: of the largest velocity; the same
# accuracy: of the fastest approach; change that sweeps without convergence still make
_HOPELESS = 1e-6
# accuracy: of the tolerance of a position; flights that rise no higher have ended
_LOW_FLIGHT = 0.01
# accuracy: of the largest gap; heights at which rounding would move the next impact
_UNSEEN = 2e-12


@inner
def largest_gap(context: Integers, k: int) -> float:
    """Running maximum of the gap of contact `k`, also while it is closed."""
    modes = modes_of(context)
    reserve = switch_row(context, RESERVE)
    largest = switch_row(context, LARGEST)
    return float(reserve[k] if modes[k] == HELD_MODE else largest[k])


@inner
def free_gap(context: Integers, t: float, q: Vector, v: Vector, first: int) -> float:
    """Second derivative of the gap of contact `first` under `modes`, in which it is open."""
    p = parameters_of(context)
    modes = modes_of(context)
    n, s = context[COORDINATES], context[SWITCHES]
    rigid = rigid_of(context)
    count = 0
    for k in range(s):
        count += 1 if modes[k] == HELD_MODE else 0
    context[SLIDING_COUNT] = count
    units(context, t, q, v, modes)
    a = base_accelerations_of(context)
    if count > 0:
        shares(context, t, q, v, count)
        share = share_of(context)
        held = sliding_functions_of(context)
        for c in range(count):
            unit = view(unit_accelerations_of(context), c * n, n)
            for j in range(n):
                a[j] += share[held[c]] * unit[j]
    gaps = response_gaps_of(context)
    gap_accelerations_of(context)(t, q, v, a, p, gaps)
    return float(gaps[rigid[first]])


@addressed(IMPACT)
def impact(context: Integers, first: int, t: float, state: int) -> float:
    """Change the velocities in row `state` by the impact of rigid contact `first`.

    Newton's law, ġ⁺ = -e ġ⁻, with impulses that only push, and with those that hold the other
    contacts that touch: v⁺ = v⁻ + Σ P_i d_i, P_i ≥ 0, ġ_i⁺ ≥ -e_i ġ_i⁻, one of the two an
    equality, by projected Gauss-Seidel sweeps; without rebound where no such velocities exist. The
    directions d_i are those in which the forces of the contacts accelerate the machine.

    Where the flight that follows would rise no higher than what a tolerance lets pass, bouncing
    ends: all further flights, each e times as long as the one before, take T/(1 - e) together,
    and the contact closes. Then `modes` says that it is held.

    Returns the time T of the next flight, T/(1 - e) negative where it is the last, infinite where
    the contact does not return by itself.
    """
    p = parameters_of(context)
    modes = modes_of(context)
    atol = row_of(context, ATOL)
    n, s = context[COORDINATES], context[SWITCHES]
    q, v = positions(context, state), velocities(context, state)
    rigid = rigid_of(context)
    restitution = restitution_of(context)
    held = sliding_functions_of(context)
    rates, now = switch_row(context, RATE_NOW), switch_row(context, NOW)
    before, holding = modes[first], context[SLIDING_COUNT]
    # All contacts that touch as held, and nothing else: friction gives no impulse.
    gaps, sought = right_side_of(context), stiction_place_of(context)
    switching_of(context)(t, q, v, p, gaps)
    for k in range(s):
        touches = abs(gaps[k]) <= ON_SURFACE * largest_gap(context, k)
        now[k] = modes[k]
        if rigid[k] < 0 and modes[k] == HELD_MODE:
            modes[k] = FREE_MODE if sought[k] >= 0 else 0
        elif rigid[k] >= 0 and touches:
            modes[k] = HELD_MODE
    modes[first] = HELD_MODE
    units(context, t, q, v, modes)
    count = 0
    for k in range(s):
        count += 1 if modes[k] == HELD_MODE else 0
    any_a = base_accelerations_of(context)  # the rate of a gap does not depend on it
    impulse = right_side_of(context)
    target = response_column_of(context)
    switching_rates_of(context)(t, q, v, any_a, p, rates)
    fastest = 0.0
    for c in range(count):
        k = held[c]
        impulse[c] = 0.0
        target[c] = -restitution[rigid[k]] * min(rates[k], 0.0)
        fastest = max(fastest, abs(rates[k]))
    matrix = response_of(context)
    quickest = 0.0
    for j in range(n):
        quickest = max(quickest, abs(v[j]))
    for sweep in range(2 * _SWEEPS):
        moved = 0.0
        for c in range(count):
            k = held[c]
            unit = view(unit_accelerations_of(context), c * n, n)
            switching_rates_of(context)(t, q, v, any_a, p, rates)
            gain = -matrix[c * count + c]
            more = max((target[c] - rates[k]) / gain, -impulse[c]) if gain > 0.0 else 0.0
            for j in range(n):
                v[j] -= more * unit[j]
            impulse[c] += more
            moved = max(moved, abs(more * gain))
        if not moved > _AGREED * fastest + _ROUNDING * quickest:
            break
        if sweep == _SWEEPS - 1:
            if not moved > _HOPELESS * fastest:
                break
            # Bodies without clearance cannot rebound from each other.
            for c in range(count):
                target[c] = 0.0
    for k in range(s):
        modes[k] = int(now[k])
    switching_rates_of(context)(t, q, v, any_a, p, rates)
    leaving = rates[first]
    # How the gap goes on without this contact.
    modes[first] = 1
    fall = free_gap(context, t, q, v, first)
    modes[first] = before
    context[SLIDING_COUNT] = holding
    if not fall < 0.0:
        return np.inf
    flight = -2.0 * leaving / fall
    share = restitution[rigid[first]]
    lowest = np.inf
    for j in range(n):
        lowest = min(lowest, atol[j])
    unseen = max(_LOW_FLIGHT * lowest, _UNSEEN * largest_gap(context, first))
    if -0.5 * leaving * leaving / fall > unseen or share >= 1.0:
        # What still closes was let no jump by the constraints.
        return float(flight) if flight > 0.0 else np.inf
    modes[first] = HELD_MODE
    return -float(max(flight, 1e-300) / (1.0 - share))


@addressed(RETURN_HELD)
def return_held(context: Integers, t: float, state: int) -> int:
    """Bring the state in row `state` back onto the surfaces of what is held.

    It moves in the directions in which the forces that hold act. These leave the constraints as
    they are in the velocities; in the positions, but for the square of what was to be corrected.
    """
    p = parameters_of(context)
    modes = modes_of(context)
    unit_accelerations = unit_accelerations_of(context)
    n = context[COORDINATES]
    r = context[RIGID_COUNT]
    q, v = positions(context, state), velocities(context, state)
    count = context[SLIDING_COUNT]
    rigid = rigid_of(context)
    held = sliding_functions_of(context)
    matrix = response_of(context)
    rates = response_rates_of(context)
    right = right_side_of(context)
    values = base_response_of(context)
    reach = response_column_of(context)
    copy = response_copy_of(context)
    units(context, t, q, v, modes)
    for level in range(2):
        # First the gaps, then the velocities.
        if level == 0 and r == 0:
            continue
        switching_of(context)(t, q, v, p, values)
        switching_rates_of(context)(t, q, v, base_accelerations_of(context), p, rates)
        for attempt in range(2):
            for i in range(count):
                k = held[i]
                closed = rigid[k] >= 0
                right[i] = rates[k] if level == 1 and closed else values[k]
                if level == 0 and not closed:
                    right[i] = 0.0
                for j in range(count):
                    copy[i * count + j] = matrix[i * count + j]
                    if level == 0 and not closed:
                        copy[i * count + j] = 1.0 if i == j else 0.0
            if attempt == 0 and solve_equilibrated(copy, right, count, SAME_HOLD) == 0:
                break
            if attempt == 1:
                for c in range(count):
                    reach[c] = 1.0
                # What surfaces that depend on each other ask for differs by rounding.
                if least(context, copy, right, count, reach, np.inf) != 0:
                    return 1
        for j in range(n):
            total, largest = 0.0, 0.0
            for c in range(count):
                part = right[c] * unit_accelerations[c * n + j]
                total += part
                largest = max(largest, abs(part))
            if level == 0:
                q[j] -= total
            else:
                rests = abs(v[j] - total) <= CANCELLED * max(largest, abs(v[j]))
                v[j] = 0.0 if rests else v[j] - total
    return 0
