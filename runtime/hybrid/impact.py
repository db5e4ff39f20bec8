"""Rigid contacts in an instant: impacts, the end of bouncing, and the return onto what is held."""

import numpy as np

from runtime.core.array_views import floats_at, integers_at, view
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    HELD,
    PLAIN,
    RESTITUTION,
    RIGID,
    RIGID_COUNT,
    SHARE,
    SOUGHT,
    SWITCHES,
    WORK,
    gap_accelerations_of,
    switching_of,
    switching_rates_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.signatures import IMPACT, RETURN_HELD, Integers, Vector
from runtime.core.workspace import ATOL, LARGEST, NOW, RATE_NOW, RESERVE, ROWS
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
def largest_gap(sw: Vector, modes: Integers, k: int) -> float:
    """Running maximum of the gap of contact `k`, also while it is closed."""
    s = modes.size
    return float(sw[RESERVE * s + k] if modes[k] == HELD_MODE else sw[LARGEST * s + k])


@inner
def free_gap(
    machine: Integers, t: float, q: Vector, v: Vector, p: Vector, modes: Integers, first: int
) -> float:
    """Second derivative of the gap of contact `first` under `modes`, in which it is open."""
    n, m, s = machine[COORDINATES], machine[CONSTRAINT_COUNT], machine[SWITCHES]
    size, r = n + m, machine[RIGID_COUNT]
    rigid = integers_at(machine, RIGID, s)
    work = floats_at(machine, WORK, (s + 2) * size + 2 * s * s + 4 * s + r)
    count = 0
    for k in range(s):
        count += 1 if modes[k] == HELD_MODE else 0
    machine[HELD] = count
    units(machine, t, q, v, p, modes)
    a = view(work, 0, n)
    if count > 0:
        shares(machine, t, q, v, p, count)
        share = floats_at(machine, SHARE, s)
        held = view(integers_at(machine, PLAIN, 2 * s), s, s)
        for c in range(count):
            unit = view(work, (c + 1) * size, n)
            for j in range(n):
                a[j] += share[held[c]] * unit[j]
    gaps = view(work, (s + 1) * size + s * s + 4 * s, r)
    gap_accelerations_of(machine)(t, q, v, a, p, gaps)
    return float(gaps[rigid[first]])


@addressed(IMPACT)
def impact(
    machine: Integers,
    first: int,
    t: float,
    state: int,
    w: Vector,
    sw: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> float:
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
    length = w.size // ROWS
    n, m, s = machine[COORDINATES], machine[CONSTRAINT_COUNT], machine[SWITCHES]
    size = n + m
    q, v = view(w, state * length, n), view(w, state * length + n, n)
    rigid = integers_at(machine, RIGID, s)
    restitution = floats_at(machine, RESTITUTION, machine[RIGID_COUNT])
    plain = integers_at(machine, PLAIN, 2 * s)
    held = view(plain, s, s)
    work = floats_at(machine, WORK, (s + 2) * size + 2 * s * s + 4 * s + machine[RIGID_COUNT])
    rates, now = view(sw, RATE_NOW * s, s), view(sw, NOW * s, s)
    before, holding = modes[first], machine[HELD]
    # All contacts that touch as held, and nothing else: friction gives no impulse.
    gaps, sought = view(work, (s + 1) * size, s), integers_at(machine, SOUGHT, s)
    switching_of(machine)(t, q, v, p, gaps)
    for k in range(s):
        touches = abs(gaps[k]) <= ON_SURFACE * largest_gap(sw, modes, k)
        now[k] = modes[k]
        if rigid[k] < 0 and modes[k] == HELD_MODE:
            modes[k] = FREE_MODE if sought[k] >= 0 else 0
        elif rigid[k] >= 0 and touches:
            modes[k] = HELD_MODE
    modes[first] = HELD_MODE
    units(machine, t, q, v, p, modes)
    count = 0
    for k in range(s):
        count += 1 if modes[k] == HELD_MODE else 0
    any_a = view(work, 0, n)  # the rate of a gap does not depend on it
    impulse = view(work, (s + 1) * size + s * s + 3 * s, s)
    target = view(work, (s + 1) * size + s * s + s, s)
    switching_rates_of(machine)(t, q, v, any_a, p, rates)
    fastest = 0.0
    for c in range(count):
        k = held[c]
        impulse[c] = 0.0
        target[c] = -restitution[rigid[k]] * min(rates[k], 0.0)
        fastest = max(fastest, abs(rates[k]))
    matrix = view(work, (s + 1) * size, s * s)
    quickest = 0.0
    for j in range(n):
        quickest = max(quickest, abs(v[j]))
    for sweep in range(2 * _SWEEPS):
        moved = 0.0
        for c in range(count):
            k = held[c]
            unit = view(work, (c + 1) * size, n)
            switching_rates_of(machine)(t, q, v, any_a, p, rates)
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
    switching_rates_of(machine)(t, q, v, any_a, p, rates)
    leaving = rates[first]
    # How the gap goes on without this contact.
    modes[first] = 1
    fall = free_gap(machine, t, q, v, p, modes, first)
    modes[first] = before
    machine[HELD] = holding
    if not fall < 0.0:
        return np.inf
    flight = -2.0 * leaving / fall
    share = restitution[rigid[first]]
    lowest = np.inf
    for j in range(n):
        lowest = min(lowest, w[ATOL * length + j])
    unseen = max(_LOW_FLIGHT * lowest, _UNSEEN * largest_gap(sw, modes, first))
    if -0.5 * leaving * leaving / fall > unseen or share >= 1.0:
        # What still closes was let no jump by the constraints.
        return float(flight) if flight > 0.0 else np.inf
    modes[first] = HELD_MODE
    return -float(max(flight, 1e-300) / (1.0 - share))


@addressed(RETURN_HELD)
def return_held(
    machine: Integers,
    t: float,
    state: int,
    w: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """Bring the state in row `state` back onto the surfaces of what is held.

    It moves in the directions in which the forces that hold act. These leave the constraints as
    they are in the velocities; in the positions, but for the square of what was to be corrected.
    """
    length = w.size // ROWS
    n, m, s = machine[COORDINATES], machine[CONSTRAINT_COUNT], machine[SWITCHES]
    size, r = n + m, machine[RIGID_COUNT]
    q, v = view(w, state * length, n), view(w, state * length + n, n)
    count = machine[HELD]
    rigid = integers_at(machine, RIGID, s)
    held = view(integers_at(machine, PLAIN, 2 * s), s, s)
    work = floats_at(machine, WORK, (s + 2) * size + 2 * s * s + 4 * s + r)
    matrix = view(work, (s + 1) * size, s * s)
    rates = view(work, (s + 1) * size + s * s + 2 * s, s)
    right = view(work, (s + 1) * size + s * s + 3 * s, s)
    values = view(work, (s + 1) * size + s * s, s)
    reach = view(work, (s + 1) * size + s * s + s, s)
    copy = view(work, (s + 1) * size + s * s + 4 * s + r, s * s)
    units(machine, t, q, v, p, modes)
    for level in range(2):
        # First the gaps, then the velocities.
        if level == 0 and r == 0:
            continue
        switching_of(machine)(t, q, v, p, values)
        switching_rates_of(machine)(t, q, v, view(work, 0, n), p, rates)
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
                if least(machine, copy, right, count, reach, np.inf) != 0:
                    return 1
        for j in range(n):
            total, largest = 0.0, 0.0
            for c in range(count):
                part = right[c] * work[(c + 1) * size + j]
                total += part
                largest = max(largest, abs(part))
            if level == 0:
                q[j] -= total
            else:
                rests = abs(v[j] - total) <= CANCELLED * max(largest, abs(v[j]))
                v[j] = 0.0 if rests else v[j] - total
    return 0
