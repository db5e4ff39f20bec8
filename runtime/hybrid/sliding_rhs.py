"""The field where it is not the machine's own: what is held, and what is stabilized.

With Baumgarte's method the constraints are not recovered but pulled back, as a damped spring would:
Φ̈ + 2 Φ̇/τ + Φ/τ² = 0 (J. Baumgarte, Computer Methods in Applied Mechanics and Engineering 1, 1972,
with α = β = 1/τ). Accelerations depend on the right side of Φ_q q̈ = γ by the same map as the
corrections of `correction` in the metric of the masses on theirs, so no kernel is needed for it.
"""

from runtime.core.array_views import floats_at, integers_at, view
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    EACH_STAGE,
    HELD,
    PLAIN,
    RIGID_COUNT,
    SETTINGS,
    SHARE,
    STABILIZED,
    SWITCHES,
    WEIGHTS,
    WORK,
    accelerations_of,
    correct_of,
    correction_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.rhs import field
from runtime.core.signatures import FIELD, SLOPE, Integers, Vector
from runtime.core.workspace import PARTITION, ROWS
from runtime.hybrid.sliding_modes import CANCELLED, shares, units
from runtime.hybrid.stiction_force import exert

STEP, TIME_SCALE = 0, 1
"""Places in SETTINGS: the length of the step, s; τ of Baumgarte's method, s."""


@inner
def beyond(value: Vector, change: Vector, size: Vector) -> float:
    """The part of a correction that is not the rounding of what it corrects.

    What a state cannot hold of itself is not to be pulled at: τ⁻² of it would be a force. Rounding
    goes by the sizes of coordinates and knows nothing of masses. All coordinates are pulled at by
    the same part, as without some of them the pull would do work along the constraints.
    """
    largest, moved = 0.0, 0.0
    for j in range(value.size):
        largest = max(largest, abs(value[j]) / size[j])
        moved = max(moved, abs(change[j]) / size[j])
    rounded = CANCELLED * largest
    return 1.0 - rounded / moved if moved > rounded else 0.0


@addressed(FIELD)
def bent(
    machine: Integers,
    t: float,
    q: Vector,
    v: Vector,
    p: Vector,
    modes: Integers,
    a: Vector,
    lam: Vector,
) -> int:
    """Accelerations and multipliers, what is held included; as `accelerations`.

    SHARE receives the share of each function that is held.
    """
    n, m, s = machine[COORDINATES], machine[CONSTRAINT_COUNT], machine[SWITCHES]
    size = n + m
    count = machine[HELD]
    if count == 0:
        weak = int(accelerations_of(machine)(t, q, v, p, modes, a, lam))
    else:
        weak = units(machine, t, q, v, p, modes)
        shares(machine, t, q, v, p, count)
        exert(machine, p, count)
        share = floats_at(machine, SHARE, s)
        held = view(integers_at(machine, PLAIN, 2 * s), s, s)
        work = floats_at(machine, WORK, (s + 2) * size + 2 * s * s + 4 * s + machine[RIGID_COUNT])
        for i in range(m):
            lam[i] = work[n + i]
        for j in range(n):
            total, largest = work[j], abs(work[j])
            for c in range(count):
                part = share[held[c]] * work[(c + 1) * size + j]
                total += part
                largest = max(largest, abs(part))
            # What is left where they cancel would set a machine at rest creeping. What is no number
            # stays none.
            a[j] = 0.0 if abs(total) <= CANCELLED * largest else total
        for c in range(count):
            part = share[held[c]]
            unit = view(work, (c + 1) * size + n, m)
            for i in range(m):
                lam[i] += part * unit[i]
    if machine[STABILIZED] != 0 and m > 0:
        tau = floats_at(machine, SETTINGS, 2)[TIME_SCALE]
        pull = floats_at(machine, WEIGHTS, 4 * n)
        dq, dv = view(pull, n, n), view(pull, 2 * n, n)
        correction_of(machine)(t, q, v, p, view(pull, 0, n), dq, dv)
        size = view(pull, 3 * n, n)
        part, rate = beyond(q, dq, size), beyond(v, dv, size)
        for j in range(n):
            a[j] += part * dq[j] / (tau * tau) + rate * 2.0 * dv[j] / tau
    return weak


@addressed(SLOPE)
def bent_slope(
    machine: Integers,
    t: float,
    state: int,
    derivative: int,
    w: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """As `slope`, also where the field is not the machine's own or stages are corrected."""
    length = w.size // ROWS
    n = length // 2
    taken = 0
    if machine[EACH_STAGE] != 0:
        taken = int(correct_of(machine)(machine, t, state, PARTITION, w, p))
    q = view(w, state * length, n)
    v = view(w, state * length + n, n)
    rate = view(w, derivative * length, n)
    field(machine, t, q, v, p, modes, view(w, derivative * length + n, n), lam)
    for j in range(n):
        rate[j] = v[j]
    return taken
