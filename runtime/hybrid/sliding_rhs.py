"""The field where it is not the machine's own: what is held, and what is stabilized.

With Baumgarte's method the constraints are not recovered but pulled back, as a damped spring would:
Φ̈ + 2 Φ̇/τ + Φ/τ² = 0 (J. Baumgarte, Computer Methods in Applied Mechanics and Engineering 1, 1972,
with α = β = 1/τ). Accelerations depend on the right side of Φ_q q̈ = γ by the same map as the
corrections of `correction` in the metric of the masses on theirs, so no kernel is needed for it.
"""

from runtime.core.array_types import Integers, Vector
from runtime.core.array_views import view
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    EACH_STAGE,
    FIELD,
    SLIDING_COUNT,
    SLOPE,
    STABILIZED,
    base_accelerations_of,
    base_multipliers_of,
    correct_of,
    modes_of,
    parameters_of,
    settings_of,
    share_of,
    sliding_functions_of,
    unit_accelerations_of,
    unit_multipliers_of,
    weights_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import accelerations_of, correction_of
from runtime.core.rhs import field
from runtime.core.workspace import PARTITION, position_rates, positions, velocities, velocity_rates
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
    context: Integers, t: float, q: Vector, v: Vector, modes: Integers, a: Vector, lam: Vector
) -> int:
    """Accelerations and multipliers, what is held included; as `accelerations`.

    SHARE receives the share of each function that is held.
    """
    p = parameters_of(context)
    base_multipliers = base_multipliers_of(context)
    base_accelerations = base_accelerations_of(context)
    unit_accelerations = unit_accelerations_of(context)
    n, m = context[COORDINATES], context[CONSTRAINT_COUNT]
    size = n + m
    count = context[SLIDING_COUNT]
    if count == 0:
        weak = int(accelerations_of(context)(t, q, v, p, modes, a, lam))
    else:
        weak = units(context, t, q, v, modes)
        shares(context, t, q, v, count)
        exert(context, count)
        share = share_of(context)
        held = sliding_functions_of(context)
        for i in range(m):
            lam[i] = base_multipliers[i]
        for j in range(n):
            total, largest = base_accelerations[j], abs(base_accelerations[j])
            for c in range(count):
                part = share[held[c]] * unit_accelerations[c * n + j]
                total += part
                largest = max(largest, abs(part))
            # What is left where they cancel would set a machine at rest creeping. What is no number
            # stays none.
            a[j] = 0.0 if abs(total) <= CANCELLED * largest else total
        for c in range(count):
            part = share[held[c]]
            unit = view(unit_multipliers_of(context), c * m, m)
            for i in range(m):
                lam[i] += part * unit[i]
    if context[STABILIZED] != 0 and m > 0:
        tau = settings_of(context)[TIME_SCALE]
        pull = weights_of(context)
        dq, dv = view(pull, n, n), view(pull, 2 * n, n)
        correction_of(context)(t, q, v, p, view(pull, 0, n), dq, dv)
        size = view(pull, 3 * n, n)
        part, rate = beyond(q, dq, size), beyond(v, dv, size)
        for j in range(n):
            a[j] += part * dq[j] / (tau * tau) + rate * 2.0 * dv[j] / tau
    return weak


@addressed(SLOPE)
def bent_slope(context: Integers, t: float, state: int, derivative: int) -> int:
    """As `slope`, also where the field is not the machine's own or stages are corrected."""
    modes = modes_of(context)
    n = context[COORDINATES]
    taken = 0
    if context[EACH_STAGE] != 0:
        taken = int(correct_of(context)(context, t, state, PARTITION))
    q = positions(context, state)
    v = velocities(context, state)
    rate = position_rates(context, derivative)
    field(context, t, q, v, modes, velocity_rates(context, derivative))
    for j in range(n):
        rate[j] = v[j]
    return taken
