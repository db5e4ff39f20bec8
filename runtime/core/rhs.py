"""The right side of the equations of motion, as the methods call it."""

from runtime.core.array_types import Integers, Vector
from runtime.core.function_table import (
    COORDINATES,
    EACH_STAGE,
    MODIFIED,
    modes_of,
    modified_accelerations_of,
    modified_rhs_of,
    multipliers_of,
    parameters_of,
)
from runtime.core.jit import inlined
from runtime.core.kernel_abi import accelerations_of
from runtime.core.workspace import position_rates, positions, velocities, velocity_rates


@inlined
def evaluate_accelerations(
    context: Integers, t: float, q: Vector, v: Vector, modes: Integers, a: Vector
) -> int:
    """Accelerations and multipliers; 0, or 1 + the constraint whose pivot is weak.

    Where the motion follows the machine's own equations this is its kernel and nothing else.
    """
    p = parameters_of(context)
    lam = multipliers_of(context)
    if context[MODIFIED] == 0:
        return int(accelerations_of(context)(t, q, v, p, modes, a, lam))
    return int(modified_accelerations_of(context)(context, t, q, v, modes, a, lam))


@inlined
def evaluate_rhs(context: Integers, t: float, state: int, derivative: int) -> int:
    """Write the derivative at the state in row `state` into row `derivative`.

    Where stages are corrected, the state is first; returns the iterations that took, negative
    where they failed. All but the machine's own equations is one call: a stage with three calls in
    it takes twice the time, whichever is made.
    """
    p = parameters_of(context)
    modes = modes_of(context)
    lam = multipliers_of(context)
    if context[MODIFIED] + context[EACH_STAGE] != 0:
        return int(modified_rhs_of(context)(context, t, state, derivative))
    n = context[COORDINATES]
    q = positions(context, state)
    v = velocities(context, state)
    rate = position_rates(context, derivative)
    accelerations_of(context)(t, q, v, p, modes, velocity_rates(context, derivative), lam)
    for j in range(n):
        rate[j] = v[j]
    return 0
