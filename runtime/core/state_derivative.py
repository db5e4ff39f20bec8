"""The right-hand side of the equations of motion, as the methods call it."""

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Integers, Vector
from runtime.core.jit import inlined
from runtime.core.kernel_abi import accelerations_of


@inlined
def evaluate_accelerations(
    context: Context, t: float, q: Vector, v: Vector, modes: Integers, a: Vector
) -> int:
    """Accelerations and multipliers; 0, or 1 + the constraint whose pivot is weak.

    Where the motion follows the machine's own equations this is its kernel and nothing else.
    """
    p, lam = context.parameters, context.multipliers
    if context[ft.MODIFIED] == 0:
        return int(accelerations_of(context)(t, q, v, p, modes, a, lam))
    return int(ft.modified_accelerations_of(context)(context, t, q, v, modes, a, lam))


@inlined
def write_derivative(context: Context, t: float, state: int, derivative: int) -> int:
    """Write (v, a) at the state in row `state` into another row; answers as the accelerations."""
    q, v = ws.positions(context, state), ws.velocities(context, state)
    rate = ws.position_rates(context, derivative)
    for j in range(context[ft.COORDINATES]):
        rate[j] = v[j]
    a = ws.velocity_rates(context, derivative)
    return evaluate_accelerations(context, t, q, v, context.modes, a)


@inlined
def evaluate_rhs(context: Context, t: float, state: int, derivative: int) -> int:
    """Write the derivative at a stage, the state in row `state`, into row `derivative`.

    Where stages are corrected, the state is first; returns the iterations that took, negative
    where they failed. All other cases share one call: a stage with three places
    of calls took twice the time, whichever was made.
    """
    p, modes, lam = context.parameters, context.modes, context.multipliers
    if context[ft.MODIFIED] + context[ft.EACH_STAGE] != 0:
        return int(ft.modified_rhs_of(context)(context, t, state, derivative))
    q, v = ws.positions(context, state), ws.velocities(context, state)
    rate = ws.position_rates(context, derivative)
    accelerations_of(context)(t, q, v, p, modes, ws.velocity_rates(context, derivative), lam)
    for j in range(context[ft.COORDINATES]):
        rate[j] = v[j]
    return 0
