"""Reactions in sliding modes, and the margin of sticking friction.

Reactions that depend on modes are the same convex combinations as accelerations, each mode with its
own multipliers; the others follow from the combined multipliers.
"""

from runtime.core import function_table as ft
from runtime.core import kernel_abi as abi
from runtime.core.array_types import Integers, Vector
from runtime.core.jit import addressed, inner
from runtime.hybrid.stiction_force import apply_unit, remove_unit, write_forces


@inner
def mix_reactions(context: Integers, t: float, q: Vector, v: Vector, lam: Vector) -> None:
    """Fill REACTION for the combined multipliers `lam`, which must just have been evaluated."""
    p, base_multipliers = ft.parameters_of(context), ft.base_multipliers_of(context)
    unit_multipliers, m = ft.unit_multipliers_of(context), context[ft.CONSTRAINT_COUNT]
    rows, count = context[ft.REACTION_ROWS], context[ft.SLIDING_COUNT]
    kernel_modes, sliding = ft.kernel_modes_of(context), ft.sliding_functions_of(context)
    share = ft.share_of(context)
    out, base, other = (
        ft.reaction_of(context),
        ft.base_reaction_of(context),
        ft.unit_reaction_of(context),
    )
    multipliers = ft.mixed_multipliers_of(context)
    for c in range(count):
        remove_unit(context, sliding[c])
    abi.reactions_of(context)(t, q, v, p, lam, out)
    for i in range(rows):
        base[i] = out[i]
    abi.switched_reactions_of(context)(
        t, q, v, p, kernel_modes, ft.base_multipliers_of(context), base
    )
    for i in range(rows):
        out[i] = base[i]
    for c in range(count):
        for i in range(m):
            multipliers[i] = base_multipliers[i] + unit_multipliers[c * m + i]
        apply_unit(context, sliding[c])
        for i in range(rows):
            other[i] = base[i]
        abi.switched_reactions_of(context)(t, q, v, p, kernel_modes, multipliers, other)
        remove_unit(context, sliding[c])
        for i in range(rows):
            out[i] += share[sliding[c]] * (other[i] - base[i])
    write_forces(context, count)


@addressed(ft.FRICTION_MARGIN)
def compute_friction_margin(context: Integers, t: float, q: Vector, v: Vector, k: int) -> float:
    """1 - |S|/(μ_s N): the part of its limit that sticking friction `k` leaves; 1 without a limit.

    Where the normal force depends on friction itself, bounds of the share do not show when it
    breaks loose: the stiction force S must be compared with μ_s N. The accelerations must just
    have been evaluated.
    """
    lam, limits = ft.multipliers_of(context), ft.limits_of(context)
    force, limit = limits[2 * k], limits[2 * k + 1]
    if force < 0:
        return 1.0
    mix_reactions(context, t, q, v, lam)
    reaction = ft.reaction_of(context)
    if not reaction[limit] > 0.0:
        return -1.0
    return float(1.0 - abs(reaction[force]) / reaction[limit])
