"""The right-hand side in sliding modes, and with Baumgarte's stabilisation.

With Baumgarte's method the constraints are not recovered but pulled back, as a damped spring would:
Φ̈ + 2 Φ̇/τ + Φ/τ² = 0 (J. Baumgarte, Computer Methods in Applied Mechanics and Engineering 1, 1972,
with α = β = 1/τ). Accelerations depend on the right side of Φ_q q̈ = γ by the same map as the
corrections of `correction` in the metric of the masses on theirs, so no kernel is needed for it.
"""

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context, Integers, Vector
from runtime.core.jit import addressed, inner
from runtime.core.state_derivative import write_derivative
from runtime.core.unowned_array_views import view
from runtime.hybrid import filippov_shares as shares
from runtime.hybrid.coupled_sliding_friction import put_friction_on_law
from runtime.hybrid.stiction_force import write_forces
from runtime.linalg.vectors import axpy, copy_vector, largest_ratio

STEP, TIME_SCALE = 0, 1  # places in SETTINGS: the length of the step, s; τ of Baumgarte's method, s


@inner
def exclude_rounding(value: Vector, change: Vector, size: Vector) -> float:
    """The part of a correction that exceeds the rounding of the state.

    Rounding of a state must not be corrected: τ⁻² of it would be a force. It goes by the sizes of
    coordinates, not by masses. All coordinates are pulled at by the same part, as without some of
    them the pull would do work along the constraints.
    """
    moved, rounded = largest_ratio(change, size), shares.CANCELLED * largest_ratio(value, size)
    return 1.0 - rounded / moved if moved > rounded else 0.0


@addressed(ft.ACCELERATIONS)
def evaluate_sliding_accelerations(
    context: Context, t: float, q: Vector, v: Vector, modes: Integers, a: Vector, lam: Vector
) -> int:
    """Accelerations and multipliers as the kernel `accelerations`, in sliding modes.

    SHARE receives the share of each function in sliding mode.
    """
    weak = shares.evaluate_units(context, t, q, v, modes)
    shares.solve_shares(context, t, q, v)
    put_friction_on_law(context, t, q, v)
    write_forces(context)
    shares.combine_accelerations(context, a)
    copy_vector(context.base_multipliers, lam)
    for c in range(context[ft.SLIDING_COUNT]):
        axpy(context.share[context.sliding_functions[c]], context.unit_multipliers[c], lam)
    return int(weak)


@addressed(ft.ACCELERATIONS)
def evaluate_modified_accelerations(
    context: Context, t: float, q: Vector, v: Vector, modes: Integers, a: Vector, lam: Vector
) -> int:
    """Accelerations and multipliers as the kernel `accelerations`, sliding modes included."""
    p, n, pull = context.parameters, context[ft.COORDINATES], context.weights
    if context[ft.SLIDING_COUNT] == 0:
        weak = int(abi.accelerations_of(context)(t, q, v, p, modes, a, lam))
    else:
        weak = int(ft.sliding_accelerations_of(context)(context, t, q, v, modes, a, lam))
    if context[ft.STABILIZED] != 0 and context[ft.CONSTRAINT_COUNT] > 0:
        tau = context.settings[TIME_SCALE]
        dq, dv, size = view(pull, n, n), view(pull, 2 * n, n), view(pull, 3 * n, n)
        abi.correction_of(context)(t, q, v, p, view(pull, 0, n), dq, dv)
        part, rate = exclude_rounding(q, dq, size), exclude_rounding(v, dv, size)
        for j in range(n):
            a[j] += part * dq[j] / (tau * tau) + rate * 2.0 * dv[j] / tau
    return weak


@addressed(ft.RHS)
def evaluate_modified_rhs(context: Context, t: float, state: int, derivative: int) -> int:
    """The right-hand side in sliding modes, with stabilisation, and where stages are corrected."""
    taken = 0
    if context[ft.EACH_STAGE] != 0:
        taken = int(ft.correct_of(context)(context, t, state, ws.PARTITION))
    write_derivative(context, t, state, derivative)
    return taken
