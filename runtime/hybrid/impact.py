"""Rigid contacts: impacts, the end of bouncing, and the return onto switching surfaces."""

import numpy as np

from runtime.core import function_table as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Integers, Vector
from runtime.core.jit import addressed, inner
from runtime.core.modes import FREE, SLIDING
from runtime.hybrid.redundant_sliding import solve_least
from runtime.hybrid.sliding_shares import (
    CANCELLED,
    combine_accelerations,
    evaluate_units,
    solve_shares,
)
from runtime.linalg.lu import solve_equilibrated
from runtime.linalg.rank_policy import SAME_HOLD
from runtime.linalg.vectors import axpy, copy_vector, largest_magnitude

ON_SURFACE = 1e-13  # accuracy: |g| over its running maximum below which g is zero at an event

_SWEEPS = 200  # safety: sweeps over all contacts with rebound, and as many again without
# accuracy: of the fastest approach; change by a sweep at which impulses have converged
_AGREED = 1e-14
_ROUNDING = 1e-15  # accuracy: of the largest velocity; the same
_HOPELESS = 1e-6  # accuracy: of the fastest approach; larger changes mean no convergence
# accuracy: of the tolerance of a position; flights that rise no higher have ended
_LOW_FLIGHT = 0.01
# accuracy: of the largest gap; heights at which rounding would move the next impact
_UNSEEN = 2e-12


@inner
def find_largest_gap(context: Integers, k: int) -> float:
    """Running maximum of the gap of contact `k`, open or closed."""
    modes, reserve = ft.modes_of(context), ws.switch_row(context, ws.RESERVE)
    largest = ws.switch_row(context, ws.LARGEST)
    return float(reserve[k] if modes[k] == SLIDING else largest[k])


@inner
def evaluate_free_gap(context: Integers, t: float, q: Vector, v: Vector, first: int) -> float:
    """Second derivative of the gap of contact `first` under `modes`, in which it is open."""
    a, gaps = ft.base_accelerations_of(context), ft.response_gaps_of(context)
    evaluate_units(context, t, q, v, ft.modes_of(context))
    if context[ft.SLIDING_COUNT] > 0:
        solve_shares(context, t, q, v)
        combine_accelerations(context, a)
    abi.gap_accelerations_of(context)(t, q, v, a, ft.parameters_of(context), gaps)
    return float(gaps[ft.rigid_of(context)[first]])


@inner
def close_contacts(context: Integers, first: int, t: float, q: Vector, v: Vector) -> None:
    """Close `first` and all contacts that touch, and open all else: friction gives no impulse."""
    modes, rigid = ft.modes_of(context), ft.rigid_of(context)
    gaps, places = ft.right_side_of(context), ft.stiction_place_of(context)
    abi.switching_of(context)(t, q, v, ft.parameters_of(context), gaps)
    for k in range(context[ft.SWITCHES]):
        touches = abs(gaps[k]) <= ON_SURFACE * find_largest_gap(context, k)
        if rigid[k] < 0 and modes[k] == SLIDING:
            modes[k] = FREE if places[k] >= 0 else 0
        elif rigid[k] >= 0 and touches:
            modes[k] = SLIDING
    modes[first] = SLIDING


@inner
def sweep_impulses(context: Integers, t: float, q: Vector, v: Vector) -> None:
    """Change v by the impulses of the closed contacts, by projected Gauss-Seidel sweeps."""
    p, count = ft.parameters_of(context), context[ft.SLIDING_COUNT]
    rigid, closed = ft.rigid_of(context), ft.sliding_functions_of(context)
    restitution, rates = ft.restitution_of(context), ws.switch_row(context, ws.RATE_NOW)
    any_a = ft.base_accelerations_of(context)  # the rate of a gap does not depend on it
    impulse, target = ft.right_side_of(context), ft.response_column_of(context)
    matrix = ft.response_of(context)
    abi.switching_rates_of(context)(t, q, v, any_a, p, rates)
    fastest = 0.0
    for c in range(count):
        k = closed[c]
        impulse[c] = 0.0
        target[c] = -restitution[rigid[k]] * min(rates[k], 0.0)
        fastest = max(fastest, abs(rates[k]))
    rounding = _ROUNDING * largest_magnitude(v)
    for sweep in range(2 * _SWEEPS):
        moved = 0.0
        for c in range(count):
            k = closed[c]
            abi.switching_rates_of(context)(t, q, v, any_a, p, rates)
            gain = -matrix[c * count + c]
            more = max((target[c] - rates[k]) / gain, -impulse[c]) if gain > 0.0 else 0.0
            axpy(-more, ft.unit_accelerations_of(context)[c], v)
            impulse[c] += more
            moved = max(moved, abs(more * gain))
        if not moved > _AGREED * fastest + rounding:
            break
        if sweep == _SWEEPS - 1:
            if not moved > _HOPELESS * fastest:
                break
            # Bodies without clearance cannot rebound from each other.
            for c in range(count):
                target[c] = 0.0


@addressed(ft.IMPACT)
def apply_impact(context: Integers, first: int, t: float, state: int) -> float:
    """Change the velocities in row `state` by the impact of rigid contact `first`.

    Newton's law, ġ⁺ = -e ġ⁻, with impulses that only push, and with those that hold the other
    contacts that touch: v⁺ = v⁻ + Σ P_i d_i, P_i ≥ 0, ġ_i⁺ ≥ -e_i ġ_i⁻, one of the two an
    equality, by projected Gauss-Seidel sweeps; without rebound where no such velocities exist. The
    directions d_i are those in which the forces of the contacts accelerate the machine.

    Where the next flight would rise no higher than tolerances resolve, bouncing ends: all further
    flights, each e times as long as the one before, take T/(1 - e) together, and the contact
    closes: its mode becomes SLIDING.

    Returns the time T of the next flight, T/(1 - e) negative where it is the last, infinite where
    the contact does not return by itself.
    """
    modes, former = ft.modes_of(context), ws.switch_row(context, ws.NOW)
    q, v = ws.positions(context, state), ws.velocities(context, state)
    rates, any_a = ws.switch_row(context, ws.RATE_NOW), ft.base_accelerations_of(context)
    before, sliding_count = modes[first], context[ft.SLIDING_COUNT]
    copy_vector(modes, former)
    close_contacts(context, first, t, q, v)
    evaluate_units(context, t, q, v, modes)
    sweep_impulses(context, t, q, v)
    for k in range(context[ft.SWITCHES]):
        modes[k] = int(former[k])
    abi.switching_rates_of(context)(t, q, v, any_a, ft.parameters_of(context), rates)
    leaving = rates[first]
    # The motion of the gap after the contact has opened.
    modes[first] = 1
    fall = evaluate_free_gap(context, t, q, v, first)
    modes[first] = before
    context[ft.SLIDING_COUNT] = sliding_count
    if not fall < 0.0:
        return np.inf
    flight = -2.0 * leaving / fall
    e = ft.restitution_of(context)[ft.rigid_of(context)[first]]
    finest = np.inf
    for j in range(context[ft.COORDINATES]):
        finest = min(finest, ws.row_of(context, ws.ATOL)[j])
    unseen = max(_LOW_FLIGHT * finest, _UNSEEN * find_largest_gap(context, first))
    if -0.5 * leaving * leaving / fall > unseen or e >= 1.0:
        # Where the gap still closes, constraints permitted no jump.
        return float(flight) if flight > 0.0 else np.inf
    modes[first] = SLIDING
    return -float(max(flight, 1e-300) / (1.0 - e))


@addressed(ft.RETURN_TO_SURFACES)
def return_to_surfaces(context: Integers, t: float, state: int) -> int:
    """Return the state in row `state` onto the surfaces of functions in sliding mode.

    It moves along the accelerations by their forces. These keep the constraints of velocities, and
    those of positions up to the square of the correction.
    """
    p, modes, n = ft.parameters_of(context), ft.modes_of(context), context[ft.COORDINATES]
    q, v = ws.positions(context, state), ws.velocities(context, state)
    count, rigid = context[ft.SLIDING_COUNT], ft.rigid_of(context)
    sliding, matrix = ft.sliding_functions_of(context), ft.response_of(context)
    rates, right = ft.response_rates_of(context), ft.right_side_of(context)
    values, reach = ft.base_response_of(context), ft.response_column_of(context)
    copy, units = ft.response_copy_of(context), ft.unit_accelerations_of(context)
    evaluate_units(context, t, q, v, modes)
    for level in range(2):
        # First the gaps, then the velocities.
        if level == 0 and context[ft.RIGID_COUNT] == 0:
            continue
        abi.switching_of(context)(t, q, v, p, values)
        abi.switching_rates_of(context)(t, q, v, ft.base_accelerations_of(context), p, rates)
        for attempt in range(2):
            for i in range(count):
                k = sliding[i]
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
                # Dependent surfaces contradict each other by rounding.
                if solve_least(context, copy, right, count, reach, np.inf) != 0:
                    return 1
        for j in range(n):
            total, largest = 0.0, 0.0
            for c in range(count):
                part = right[c] * units[c, j]
                total += part
                largest = max(largest, abs(part))
            if level == 0:
                q[j] -= total
            else:
                rests = abs(v[j] - total) <= CANCELLED * max(largest, abs(v[j]))
                v[j] = 0.0 if rests else v[j] - total
    return 0
