"""The stiction force: the unknown force that keeps a joint with friction at rest.

A combination of the fields of sliding to either side would keep it at rest as well, but where one
of them jams, that field does not exist. Therefore kernels in mode 2 take a given force in the place
of this friction: zero, which is the base, and one unit. Everything is linear in the force, so that
any unit serves which rounding permits; whether friction can bear the force is decided by its limit,
μ_s N.
"""

import numpy as np

from runtime.core import function_table as ft
from runtime.core import kernel_abi as abi
from runtime.core.array_types import Integers, Vector
from runtime.core.jit import inner
from runtime.core.modes import SLIDING
from runtime.linalg.vectors import copy_vector, is_finite

PRESCRIBED = SLIDING  # the mode in which kernels take the stiction force from p

# accuracy: units in a force above which their rounding would show; another unit is taken
_COARSE = 8.0


@inner
def set_unit(context: Integers, k: int, mode: int) -> None:
    """Set function `k` to mode 0 or 1; its stiction force to zero or to a unit against g."""
    place = ft.stiction_place_of(context)[k]
    if place >= 0:
        unit = ft.stiction_units_of(context)[k]
        ft.parameters_of(context)[place] = -unit if mode != 0 else 0.0
    else:
        ft.kernel_modes_of(context)[k] = mode


@inner
def write_forces(context: Integers) -> None:
    """Write the stiction forces into `p`, for kernels in mode 2."""
    p, sliding = ft.parameters_of(context), ft.sliding_functions_of(context)
    places, share = ft.stiction_place_of(context), ft.share_of(context)
    unit = ft.stiction_units_of(context)
    for c in range(context[ft.SLIDING_COUNT]):
        k = sliding[c]
        if places[k] >= 0:
            p[places[k]] = -share[k] * unit[k]


@inner
def suspend_friction(context: Integers) -> None:
    """Set all frictions with an unknown stiction force to a force of zero, by `modes`."""
    p, modes = ft.parameters_of(context), ft.modes_of(context)
    places = ft.stiction_place_of(context)
    for k in range(context[ft.SWITCHES]):
        if places[k] >= 0:
            p[places[k]] = 0.0
            modes[k] = PRESCRIBED


@inner
def find_jamming_friction(context: Integers, t: float, q: Vector, v: Vector, a: Vector) -> int:
    """The friction that jams in sliding: without it, and those before it, `a` is finite; or -1.

    For states without accelerations under `modes`; `a` and `lam` are overwritten.
    """
    p, modes = ft.parameters_of(context), ft.modes_of(context)
    places, kernel_modes = ft.stiction_place_of(context), ft.kernel_modes_of(context)
    copy_vector(modes, kernel_modes)
    for k in range(context[ft.SWITCHES]):
        if places[k] < 0 or modes[k] == PRESCRIBED:
            continue
        p[places[k]] = 0.0
        kernel_modes[k] = PRESCRIBED
        abi.accelerations_of(context)(t, q, v, p, kernel_modes, a, ft.multipliers_of(context))
        if is_finite(a):
            return k
    return -1


@inner
def choose_units(context: Integers, t: float, q: Vector, v: Vector) -> None:
    """Fill the units of the stiction forces, and the friction limits in the base.

    The limit serves as the unit: it has the size of the forces in the machine.
    """
    p, s, count = ft.parameters_of(context), context[ft.SWITCHES], context[ft.SLIDING_COUNT]
    sliding, places = ft.sliding_functions_of(context), ft.stiction_place_of(context)
    limits, unit = ft.limits_of(context), ft.stiction_units_of(context)
    reaction, lam = ft.reaction_of(context), ft.base_multipliers_of(context)
    first = 0
    while first < count and places[sliding[first]] < 0:
        first += 1
    if first == count:
        return
    abi.reactions_of(context)(t, q, v, p, lam, reaction)
    modes = ft.kernel_modes_of(context)
    abi.switched_reactions_of(context)(t, q, v, p, modes, lam, reaction)
    for c in range(first, count):
        k = sliding[c]
        if places[k] >= 0:
            limit = reaction[limits[2 * k + 1]]
            unit[s + k] = limit
            unit[k] = limit if limit > 0.0 and np.isfinite(limit) else 1.0


@inner
def enlarge_unit(context: Integers, k: int) -> bool:
    """Enlarge the unit of function `k` where it is too small a part of its force; whether it was.

    A share of NaN may come from a unit that is lost in the rounding of the base.
    """
    if ft.stiction_place_of(context)[k] < 0:
        return False
    unit, share = ft.stiction_units_of(context), ft.share_of(context)[k]
    if not np.isfinite(share):
        lost = unit[k] < 1.0
        unit[k] = max(unit[k], 1.0)
        return bool(lost)
    if abs(share) > _COARSE:
        unit[k] *= abs(share)
        return True
    return False
