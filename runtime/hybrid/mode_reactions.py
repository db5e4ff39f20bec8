"""Reactions in sliding modes, and the margin of sticking friction.

Reactions that depend on modes are the same convex combinations as accelerations, each mode with its
own multipliers; the others follow from the combined multipliers.
"""

from runtime.core import function_table as ft
from runtime.core import kernel_abi as abi
from runtime.core.array_types import Context, Vector
from runtime.core.jit import addressed, inner
from runtime.hybrid.stiction_force import set_unit, write_forces
from runtime.linalg.vectors import copy_vector


@inner
def mix_reactions(context: Context, t: float, q: Vector, v: Vector, lam: Vector) -> None:
    """Fill REACTION for the combined multipliers `lam`, which must just have been evaluated."""
    p, modes, sliding = context.parameters, context.kernel_modes, context.sliding_functions
    base, other = context.base_reaction, context.unit_reaction
    base_lam, mixed = context.base_multipliers, context.mixed_multipliers
    count = context[ft.SLIDING_COUNT]
    for c in range(count):
        set_unit(context, sliding[c], 0)
    abi.reactions_of(context)(t, q, v, p, lam, base)
    abi.switched_reactions_of(context)(t, q, v, p, modes, base_lam, base)
    copy_vector(base, context.reaction)
    for c in range(count):
        for i in range(base_lam.size):
            mixed[i] = base_lam[i] + context.unit_multipliers[c, i]
        set_unit(context, sliding[c], 1)
        copy_vector(base, other)
        abi.switched_reactions_of(context)(t, q, v, p, modes, mixed, other)
        set_unit(context, sliding[c], 0)
        for i in range(base.size):
            context.reaction[i] += context.share[sliding[c]] * (other[i] - base[i])
    write_forces(context)


@addressed(ft.FRICTION_MARGIN)
def compute_friction_margin(context: Context, t: float, q: Vector, v: Vector, k: int) -> float:
    """1 - |S|/(μ_s N): the part of its limit that sticking friction `k` leaves; 1 without a limit.

    Where the normal force depends on friction itself, bounds of the share do not show when it
    breaks loose: the stiction force S must be compared with μ_s N. The accelerations must just
    have been evaluated.
    """
    force, limit = context.limits[2 * k], context.limits[2 * k + 1]
    if force < 0:
        return 1.0
    mix_reactions(context, t, q, v, context.multipliers)
    reaction = context.reaction
    if not reaction[limit] > 0.0:
        return -1.0
    return float(1.0 - abs(reaction[force]) / reaction[limit])
