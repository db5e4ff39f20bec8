"""Impacts of rigid contacts that rebound and freewheels that grip, and the end of bouncing.

Beside them the return onto switching surfaces.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Vector, view
from runtime.core.jit import addressed, inner
from runtime.core.kinds import FREE, ONE_WAY, SLIDING
from runtime.hybrid import filippov_shares as shares
from runtime.hybrid.filippov_shares import put_friction_on_law
from runtime.hybrid.rest_forces import is_prescribed, is_resting, solve_least
from runtime.linalg.dense_elimination import solve_equilibrated
from runtime.linalg.rank_policy import SAME_HOLD
from runtime.linalg.vectors import axpy, copy_vector, largest_magnitude

SLOW = 1e-12  # accuracy: of the largest velocity; a freewheel whose slip is slower may grip

_SWEEPS = 200  # safety: sweeps over all contacts with rebound, and as many again without
_PIVOTS = 10  # safety: of a contact in an impact; changes of the part that it takes
_AGREED = 1e-14  # accuracy: of the fastest approach; change by a sweep at which impulses agree
_ROUNDING = 1e-15  # accuracy: of the largest velocity; the same
_HOPELESS = 1e-6  # accuracy: of the fastest approach; larger changes mean no convergence

ON_SURFACE = 1e-13  # accuracy: |g| over its running maximum below which g is zero at an event

_LOW_FLIGHT = 0.01  # accuracy: of a position's tolerance; bouncing ends when flights rise no higher
_UNSEEN = 2e-12  # accuracy: of the largest gap; at this height rounding determines the next impact


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
