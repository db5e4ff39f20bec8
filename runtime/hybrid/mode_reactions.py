"""Reactions between two modes, and what friction that sticks can bear.

Rows of reactions that a mode decides mix as the accelerations do, each mode with its own
multipliers; the others follow from the mixed multipliers.
"""

from runtime.core.array_types import Integers, Vector
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    LIMIT,
    REACTION_ROWS,
    SLIDING_COUNT,
    base_multipliers_of,
    base_reaction_of,
    kernel_modes_of,
    limits_of,
    mixed_multipliers_of,
    multipliers_of,
    parameters_of,
    reaction_of,
    share_of,
    sliding_functions_of,
    unit_multipliers_of,
    unit_reaction_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import reactions_of, switched_reactions_of
from runtime.hybrid.stiction_force import engage, exert, release


@inner
def mix(context: Integers, t: float, q: Vector, v: Vector, lam: Vector) -> None:
    """Fill REACTION with all rows for the mixed multipliers `lam`; `bent` must just have run."""
    p = parameters_of(context)
    base_multipliers = base_multipliers_of(context)
    unit_multipliers = unit_multipliers_of(context)
    m = context[CONSTRAINT_COUNT]
    rows, count = context[REACTION_ROWS], context[SLIDING_COUNT]
    plain = kernel_modes_of(context)
    held = sliding_functions_of(context)
    share = share_of(context)
    out, base, other = reaction_of(context), base_reaction_of(context), unit_reaction_of(context)
    own = mixed_multipliers_of(context)
    for c in range(count):
        release(context, held[c])
    reactions_of(context)(t, q, v, p, lam, out)
    for i in range(rows):
        base[i] = out[i]
    switched_reactions_of(context)(t, q, v, p, plain, base_multipliers_of(context), base)
    for i in range(rows):
        out[i] = base[i]
    for c in range(count):
        for i in range(m):
            own[i] = base_multipliers[i] + unit_multipliers[c * m + i]
        engage(context, held[c])
        for i in range(rows):
            other[i] = base[i]
        switched_reactions_of(context)(t, q, v, p, plain, own, other)
        release(context, held[c])
        for i in range(rows):
            out[i] += share[held[c]] * (other[i] - base[i])
    exert(context, count)


@addressed(LIMIT)
def limited(context: Integers, t: float, q: Vector, v: Vector, k: int) -> float:
    """How much of what friction `k` can bear is left, in parts of it; 1 where nothing says.

    Where the force that presses depends on friction itself, bounds of the share alone do not tell
    when it tears loose: the force must be compared with what it may be, μ_s N. `bent` must just
    have run.
    """
    lam = multipliers_of(context)
    limits = limits_of(context)
    force, limit = limits[2 * k], limits[2 * k + 1]
    if force < 0:
        return 1.0
    mix(context, t, q, v, lam)
    room = reaction_of(context)
    if not room[limit] > 0.0:
        return -1.0
    return float(1.0 - abs(room[force]) / room[limit])
