"""Ways in from Python to hybrid dynamics that compiled code alone calls; numba keeps them.

The state lies in row Y0, its modes in the table; accelerations are written into row DELTA.
"""

from runtime.core import function_table_slots as ft
from runtime.core import state_derivative
from runtime.core import workspace_rows as ws
from runtime.core.arrays import f8, i8, integers, none
from runtime.core.jit import compiled
from runtime.hybrid import filippov_shares, mode_consistency, rest_forces, sliding_motion


@compiled(i8(integers, f8))
def solve_least(context, slack):
    return rest_forces.solve_least(context, slack)


@compiled(i8(integers, f8))
def evaluate_accelerations(context, t):
    modes, a = context.modes, context.first_scratch
    mode_consistency.count_sliding(context, modes)
    q, v = context.q0, context.v0
    return state_derivative.evaluate_accelerations(context, t, q, v, modes, a)


@compiled(f8(integers, f8, i8))
def compute_margin(context, t, k):
    q, v = context.q0, context.v0
    return sliding_motion.compute_margin(context, t, q, v, k)


@compiled(none(integers, f8))
def mix_reactions(context, t):
    q, v = context.q0, context.v0
    filippov_shares.mix_reactions(context, t, q, v, context.multipliers)


@compiled(i8(integers, f8, f8))
def select_modes(context, t, ahead):
    return ft.select_modes_of(context)(context, 0, t, ahead, ws.Y0)


@compiled(i8(integers, f8, f8))
def initialize_modes(context, t, ahead):
    return ft.initialize_modes_of(context)(context, 0, t, ahead, ws.Y0)
