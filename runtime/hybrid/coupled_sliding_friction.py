"""Friction from reactions that slides while other functions stick, slide, or are closed.

It is no linear function of the forces that keep these at zero, since its normal force is the length
of a reaction which they change. Superposition of units is therefore no more than a first guess.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core.array_types import Context, Vector
from runtime.core.jit import inner
from runtime.hybrid.filippov_shares import evaluate_response, evaluate_unit, solve_responses
from runtime.hybrid.stiction_force import is_prescribed, write_forces
from runtime.linalg.vectors import axpy

_TURNS = 40  # safety: corrections of shares beside friction that slides
_AGREED = 1e-14  # accuracy: of a share; with smaller corrections friction is on its law
_ROUNDED = 1e-10  # accuracy: the same, where corrections no longer become smaller


@inner
def evaluate_prescribed(context: Context, t: float, q: Vector, v: Vector) -> None:
    """Evaluate the motion with the present shares as its base, and its response.

    The changes by functions whose share kernels do not take are evaluated anew, and mixed.
    """
    a, lam, count = context.base_accelerations, context.base_multipliers, context[ft.SLIDING_COUNT]
    write_forces(context)
    abi.accelerations_of(context)(t, q, v, context.parameters, context.kernel_modes, a, lam)
    evaluate_response(context, t, q, v, a, context.base_response)
    for c in range(count):
        if not is_prescribed(context, context.sliding_functions[c]):
            evaluate_unit(context, t, q, v, c)
            for i in range(count):
                context.response_secant[i * count + c] = context.response[i * count + c]
    for c in range(count):
        k = context.sliding_functions[c]
        if not is_prescribed(context, k):
            for i in range(count):
                context.base_response[i] += context.share[k] * context.response[i * count + c]


@inner
def put_friction_on_law(context: Context, t: float, q: Vector, v: Vector) -> None:
    """Solve for the shares with which friction that slides meanwhile is exactly on its law.

    It follows from reactions, so that superposition is only the first of these steps. The kernels
    take forces and shares from `p` and solve friction with them; what is left of dg/dt (of contacts
    g̈) corrects the shares, with C. G. Broyden's updates of the matrix of responses (Mathematics of
    Computation 19, 1965). The base then becomes what with the shares of the units is this motion.
    Shares are NaN where no forces are found.
    """
    if context[ft.SUPERPOSES] != 0:
        return
    count, sliding, share = context[ft.SLIDING_COUNT], context.sliding_functions, context.share
    secant, change, given = context.response_secant, context.right_side, 0
    for c in range(count):
        given += 1 if is_prescribed(context, sliding[c]) else 0
    if given == 0:
        return
    for i in range(count * count):
        secant[i] = context.response[i]
    former = np.inf
    for turn in range(_TURNS):
        evaluate_prescribed(context, t, q, v)
        if turn > 0:
            norm = 0.0
            for c in range(count):
                change[c] /= 1.0 + abs(share[sliding[c]])
                norm += change[c] ** 2
            for c in range(count):
                factor = change[c] / (norm * (1.0 + abs(share[sliding[c]]))) if norm > 0.0 else 0.0
                if is_prescribed(context, sliding[c]):
                    for i in range(count):
                        secant[i * count + c] += factor * context.base_response[i]
        solve_responses(context, secant, 0.0, 0.0)
        moved = 0.0
        for c in range(count):
            part = abs(change[c]) / (1.0 + abs(share[sliding[c]]))
            moved = moved if part <= moved or np.isnan(moved) else part
        on_law = moved <= _AGREED or (moved <= _ROUNDED and moved > 0.5 * former)
        if on_law or not np.isfinite(moved) or turn == _TURNS - 1:
            break
        former = moved
        for c in range(count):
            share[sliding[c]] += change[c]
    for c in range(count):
        k = sliding[c]
        if is_prescribed(context, k):
            axpy(-share[k], context.unit_accelerations[c], context.base_accelerations)
            axpy(-share[k], context.unit_multipliers[c], context.base_multipliers)
        # The last correction, of the size of rounding, is along the units.
        share[k] = share[k] + change[c] if on_law else np.nan
        change[c] = share[k]  # as after any solution for the shares
