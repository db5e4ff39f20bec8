"""The stiction force: the unknown force that keeps a joint with friction at rest.

A combination of the fields of sliding to either side would keep it at rest as well, but where one
of them jams, that field does not exist. Therefore kernels in mode 2 take a given force in the place
of this friction: zero, which is the base, and one unit. Everything is linear in the force, so that
any unit serves which rounding permits; whether friction can bear the force is decided by its limit,
μ_s N.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core.arrays import Context, Vector
from runtime.core.jit import inner
from runtime.core.kinds import MIXED, SLIDING
from runtime.linalg.vectors import copy_vector, is_finite

PRESCRIBED = SLIDING  # the mode in which kernels take the stiction force from p

_COARSE = 8.0  # accuracy: units in a force above which their rounding would show


@inner
def set_unit(context: Context, k: int, mode: int) -> None:
    """Set function `k` to mode 0 or 1; its stiction force to zero or to a unit against g.

    Mixed conditions at rest stay so, in the mode 2 of their kernels.
    """
    place = context.stiction_place[k]
    if place >= 0:
        unit = context.stiction_units[k]
        context.parameters[place] = -unit if mode != 0 else 0.0
    elif context.boundary[k] != MIXED or context.kernel_modes[k] != SLIDING:
        context.kernel_modes[k] = mode


@inner
def is_prescribed(context: Context, k: int) -> bool:
    """Whether kernels take from `p` what keeps function `k` at zero."""
    return bool(context.stiction_place[k] >= 0 or context.share_place[k] >= 0)


@inner
def write_forces(context: Context) -> None:
    """Write the stiction forces, and shares that kernels take, into `p`, for kernels in mode 2."""
    for c in range(context[ft.SLIDING_COUNT]):
        k = context.sliding_functions[c]
        place, share_place = context.stiction_place[k], context.share_place[k]
        if place >= 0:
            context.parameters[place] = -context.share[k] * context.stiction_units[k]
        if share_place >= 0:
            context.parameters[share_place] = context.share[k]
            context.kernel_modes[k] = PRESCRIBED


@inner
def suspend_friction(context: Context) -> None:
    """Set all frictions with an unknown stiction force to a force of zero, by `modes`."""
    for k in range(context[ft.SWITCHES]):
        if context.stiction_place[k] >= 0:
            context.parameters[context.stiction_place[k]] = 0.0
            context.modes[k] = PRESCRIBED


@inner
def find_jamming_friction(context: Context, t: float, q: Vector, v: Vector, a: Vector) -> int:
    """The friction that jams in sliding: without it, and those before it, `a` is finite; or -1.

    For states without accelerations under `modes`; `a` and `lam` are overwritten.
    """
    p, kernel_modes = context.parameters, context.kernel_modes
    copy_vector(context.modes, kernel_modes)
    for k in range(context[ft.SWITCHES]):
        if context.stiction_place[k] < 0 or context.modes[k] == PRESCRIBED:
            continue
        p[context.stiction_place[k]] = 0.0
        kernel_modes[k] = PRESCRIBED
        abi.accelerations_of(context)(t, q, v, p, kernel_modes, a, context.multipliers)
        if is_finite(a):
            return k
    return -1


@inner
def choose_units(context: Context, t: float, q: Vector, v: Vector) -> None:
    """Fill the units of the stiction forces, and the friction limits in the base.

    The limit serves as the unit: it has the size of the forces in the machine.
    """
    s, count = context[ft.SWITCHES], context[ft.SLIDING_COUNT]
    p, lam, reaction = context.parameters, context.base_multipliers, context.reaction
    first = 0
    while first < count and context.stiction_place[context.sliding_functions[first]] < 0:
        first += 1
    if first == count:
        return
    abi.reactions_of(context)(t, q, v, p, lam, reaction)
    abi.switched_reactions_of(context)(t, q, v, p, context.kernel_modes, lam, reaction)
    for c in range(first, count):
        k = context.sliding_functions[c]
        if context.stiction_place[k] >= 0:
            limit = reaction[context.limits[2 * k + 1]]
            context.stiction_units[s + k] = limit
            context.stiction_units[k] = limit if limit > 0.0 and np.isfinite(limit) else 1.0


@inner
def enlarge_unit(context: Context, k: int) -> bool:
    """Enlarge the unit of function `k` where it is too small a part of its force; whether it was.

    A share of NaN may come from a unit that is lost in the rounding of the base.
    """
    if context.stiction_place[k] < 0:
        return False
    unit, share = context.stiction_units, context.share[k]
    if not np.isfinite(share):
        lost = unit[k] < 1.0
        unit[k] = max(unit[k], 1.0)
        return bool(lost)
    if abs(share) > _COARSE:
        unit[k] *= abs(share)
        return True
    return False
