"""Friction in a joint that sticks: the force that holds it is sought by itself.

What lies between the fields of sliding to either side holds the joint as well, but where one of
them jams there is no such field. So the kernels are asked, in mode 2, for the field with a given
force in the place of this friction: none, which is the base, and one unit. Everything is linear in
the force, so that any unit serves which rounding lets pass; whether the friction can bear the force
is for its limit to say, μ_s N.
"""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.function_table import (
    SWITCHES,
    base_multipliers_of,
    kernel_modes_of,
    limits_of,
    modes_of,
    multipliers_of,
    parameters_of,
    reaction_of,
    share_of,
    sliding_functions_of,
    stiction_place_of,
    stiction_units_of,
)
from runtime.core.jit import inner
from runtime.core.kernel_abi import accelerations_of, reactions_of, switched_reactions_of

FREE_MODE = 3
"""Of a friction whose force is sought: it exerts none, and is not held."""

GIVEN_MODE = 2
"""Of such a friction, as the kernels take it: the force is what stands in p."""

# accuracy: units in a force above which their rounding would show; another unit is taken
_COARSE = 8.0


@inner
def engage(context: Integers, k: int) -> None:
    """Have the kernels exert one unit of what holds function `k`: its mode 1, or a unit of force.

    The unit acts against g, as friction does in mode 1.
    """
    p = parameters_of(context)
    place = stiction_place_of(context)[k]
    if place >= 0:
        p[place] = -stiction_units_of(context)[k]
    else:
        kernel_modes_of(context)[k] = 1


@inner
def release(context: Integers, k: int) -> None:
    """Have the kernels exert nothing of what holds function `k`: its mode 0, or no force."""
    p = parameters_of(context)
    place = stiction_place_of(context)[k]
    if place >= 0:
        p[place] = 0.0
    else:
        kernel_modes_of(context)[k] = 0


@inner
def exert(context: Integers, count: int) -> None:
    """Leave in `p` the forces that hold, for kernels that are called with the mode 2."""
    p = parameters_of(context)
    held = sliding_functions_of(context)
    sought, share = stiction_place_of(context), share_of(context)
    unit = stiction_units_of(context)
    for c in range(count):
        if sought[held[c]] >= 0:
            p[sought[held[c]]] = -share[held[c]] * unit[held[c]]


@inner
def at_rest(context: Integers) -> None:
    """Have the kernels exert nothing of all frictions whose force is sought, by `modes`."""
    p = parameters_of(context)
    modes = modes_of(context)
    sought = stiction_place_of(context)
    for k in range(context[SWITCHES]):
        if sought[k] >= 0:
            p[sought[k]] = 0.0
            modes[k] = GIVEN_MODE


@inner
def finite(a: Vector) -> bool:
    """Whether all of `a` are numbers."""
    found = True
    for j in range(a.size):
        found = found and np.isfinite(a[j])
    return bool(found)


@inner
def jams(context: Integers, t: float, q: Vector, v: Vector, a: Vector) -> int:
    """A friction that slides, without which, and those before it, there are accelerations; or -1.

    To be called where there are none under `modes`; `a` and `lam` are overwritten.
    """
    p = parameters_of(context)
    modes = modes_of(context)
    lam = multipliers_of(context)
    s = context[SWITCHES]
    sought = stiction_place_of(context)
    plain = kernel_modes_of(context)
    for k in range(s):
        plain[k] = modes[k]
    for k in range(s):
        if sought[k] < 0 or modes[k] == GIVEN_MODE:
            continue
        p[sought[k]] = 0.0
        plain[k] = GIVEN_MODE
        accelerations_of(context)(t, q, v, p, plain, a, lam)
        if finite(a):
            return k
    return -1


@inner
def choose_units(context: Integers, t: float, q: Vector, v: Vector, count: int) -> None:
    """Fill UNIT: the units of the forces that are sought, and what they bear in the base.

    The one is taken for the other: it has the size of the forces in the machine.
    """
    p = parameters_of(context)
    s = context[SWITCHES]
    plain = kernel_modes_of(context)
    held, sought = sliding_functions_of(context), stiction_place_of(context)
    limits, unit = limits_of(context), stiction_units_of(context)
    any_sought = False
    for c in range(count):
        any_sought = any_sought or sought[held[c]] >= 0
    if not any_sought:
        return
    room, lam = reaction_of(context), base_multipliers_of(context)
    reactions_of(context)(t, q, v, p, lam, room)
    switched_reactions_of(context)(t, q, v, p, plain, lam, room)
    for c in range(count):
        k = held[c]
        if sought[k] >= 0:
            bears = room[limits[2 * k + 1]]
            unit[s + k] = bears
            unit[k] = bears if bears > 0.0 and np.isfinite(bears) else 1.0


@inner
def outgrown(context: Integers, k: int) -> bool:
    """Whether function `k` is held by a force of which its unit is too small a part; then it grows.

    A share that is no number may come from a unit that is lost in the rounding of the base.
    """
    if stiction_place_of(context)[k] < 0:
        return False
    unit, share = stiction_units_of(context), share_of(context)[k]
    if not np.isfinite(share):
        lost = unit[k] < 1.0
        unit[k] = max(unit[k], 1.0)
        return bool(lost)
    if abs(share) > _COARSE:
        unit[k] *= abs(share)
        return True
    return False
