"""What holds a switching function at zero: the share of each field, and the motion along both.

A function g is *held* where the motion stays on g = 0: both fields push onto the surface
(A. F. Filippov, Differential Equations with Discontinuous Righthand Sides, 1988), friction sticks,
or a rigid contact is closed. With accelerations a⁰ and a¹ of modes 0 and 1 the motion has

    a = a⁰ + α (a¹ - a⁰),     dg/dt = 0,

the share α between bounds: 0 and 1; wider by the ratio of the coefficients where friction sticks.
A rigid contact has a¹ without its force and a⁰ with a unit of it; g̈ = 0 decides, and the reaction
is 1 - α units, from 0 to infinity. Friction in a joint has a⁰ without its force and a¹ with a unit
of it (`sought`). Several are held by as many shares at once: forces of different
effects add up, so that the accelerations of one changed mode each are enough.
"""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.array_views import view
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    RIGID_COUNT,
    SWITCHES,
    base_accelerations_of,
    base_multipliers_of,
    base_response_of,
    kernel_modes_of,
    parameters_of,
    response_column_of,
    response_copy_of,
    response_gaps_of,
    response_of,
    response_rates_of,
    right_side_of,
    rigid_of,
    share_high_of,
    share_low_of,
    share_of,
    sliding_functions_of,
    stiction_place_of,
    stiction_units_of,
    unit_accelerations_of,
    unit_multipliers_of,
)
from runtime.core.jit import inner
from runtime.core.kernel_abi import accelerations_of, gap_accelerations_of, switching_rates_of
from runtime.core.rounding import EPS
from runtime.hybrid.degenerate_sliding import least
from runtime.hybrid.stiction_force import (
    FREE_MODE,
    choose_units,
    engage,
    outgrown,
    release,
)
from runtime.linalg.lu import solve_equilibrated
from runtime.linalg.rank_policy import SAME_HOLD

CANCELLED = 64.0 * EPS
"""accuracy: of the largest of some terms; a sum below it is their rounding."""

HELD_MODE = 2
"""A mode that is neither 0 nor 1: the motion stays on the surface."""

_UNITS = 3  # safety: attempts at a unit of the size of the force


@inner
def units(context: Integers, t: float, q: Vector, v: Vector, modes: Integers) -> int:
    """Fill WORK: fields with nothing held, then with one mode changed each, and what they do.

    In the place of a mode that friction whose force is sought would change, a unit of this force.
    WORK holds, with c the number of modes that are held: accelerations and multipliers of the base
    (n + m); the change by each (c rows of n + m, room for s); the matrix of d(dg/dt) or d(g̈), by
    rows (s × s); the same of the base (s). Returns what `accelerations` says of the base.
    """
    p = parameters_of(context)
    s = context[SWITCHES]
    plain = kernel_modes_of(context)
    held = sliding_functions_of(context)
    sought = stiction_place_of(context)
    count = 0
    for k in range(s):
        plain[k] = HELD_MODE if modes[k] == FREE_MODE else modes[k]
        if sought[k] >= 0:
            p[sought[k]] = 0.0
        if modes[k] == HELD_MODE:
            plain[k] = HELD_MODE if sought[k] >= 0 else 0
            held[count] = k
            count += 1
    base_a, base_lam = base_accelerations_of(context), base_multipliers_of(context)
    weak = int(accelerations_of(context)(t, q, v, p, plain, base_a, base_lam))
    base = base_response_of(context)
    respond(context, t, q, v, base_a, held, count, base)
    choose_units(context, t, q, v, count)
    for c in range(count):
        unit(context, t, q, v, count, c)
    return weak


@inner
def unit(context: Integers, t: float, q: Vector, v: Vector, count: int, c: int) -> None:
    """Fill the `c`-th change of the field, and what it does, in WORK, where the base stands."""
    p = parameters_of(context)
    base_accelerations = base_accelerations_of(context)
    base_multipliers = base_multipliers_of(context)
    n, m = context[COORDINATES], context[CONSTRAINT_COUNT]
    plain = kernel_modes_of(context)
    held = sliding_functions_of(context)
    matrix = response_of(context)
    base = base_response_of(context)
    column = response_column_of(context)
    unit_a = view(unit_accelerations_of(context), c * n, n)
    unit_lam = view(unit_multipliers_of(context), c * m, m)
    engage(context, held[c])
    accelerations_of(context)(t, q, v, p, plain, unit_a, unit_lam)
    release(context, held[c])
    respond(context, t, q, v, unit_a, held, count, column)
    for i in range(count):
        matrix[i * count + c] = column[i] - base[i]
    for j in range(n):
        unit_a[j] -= base_accelerations[j]
    for i in range(m):
        unit_lam[i] -= base_multipliers[i]


@inner
def respond(
    context: Integers,
    t: float,
    q: Vector,
    v: Vector,
    a: Vector,
    held: Integers,
    count: int,
    out: Vector,
) -> None:
    """Write dg/dt, for a rigid contact g̈, of the `count` functions that are held."""
    p = parameters_of(context)
    r = context[RIGID_COUNT]
    rigid = rigid_of(context)
    rates = response_rates_of(context)
    gaps = response_gaps_of(context)
    switching_rates_of(context)(t, q, v, a, p, rates)
    if r > 0:
        gap_accelerations_of(context)(t, q, v, a, p, gaps)
    for c in range(count):
        k = held[c]
        out[c] = gaps[rigid[k]] if rigid[k] >= 0 else rates[k]


@inner
def shares(context: Integers, t: float, q: Vector, v: Vector, count: int) -> None:
    """Shares by which the `count` functions are held, into SHARE; not a number where none do.

    The matrix that `units` left is kept, but for the columns of units that prove too small.
    """
    held = sliding_functions_of(context)
    for _ in range(_UNITS):
        balanced(context, count)
        grown = 0
        for c in range(count):
            if outgrown(context, held[c]):
                unit(context, t, q, v, count, c)
                grown += 1
        if grown == 0:
            return
    balanced(context, count)


@inner
def balanced(context: Integers, count: int) -> None:
    """The shares with which nothing that is held changes, by the matrix that stands in WORK."""
    s = context[SWITCHES]
    held = sliding_functions_of(context)
    rigid = rigid_of(context)
    sought, forces = stiction_place_of(context), stiction_units_of(context)
    share = share_of(context)
    matrix = response_of(context)
    base = base_response_of(context)
    right = right_side_of(context)
    copy = response_copy_of(context)
    for i in range(count):
        right[i] = -base[i]
    for i in range(count * count):
        copy[i] = matrix[i]
    if solve_equilibrated(copy, right, count, SAME_HOLD) != 0:
        low, high = share_low_of(context), share_high_of(context)
        middle = response_rates_of(context)
        reach = response_column_of(context)
        for c in range(count):
            k = held[c]
            # A contact without a force has its upper bound as its share, and no lower one.
            middle[c] = high[k] if rigid[k] >= 0 else 0.5 * (low[k] + high[k])
            reach[c] = 1.0 if rigid[k] >= 0 else 0.5 * (high[k] - low[k])
            if sought[k] >= 0:
                middle[c], reach[c] = 0.0, forces[s + k] / forces[k]
        for i in range(count):
            right[i] = -base[i]
            for c in range(count):
                copy[i * count + c] = matrix[i * count + c]
                right[i] -= matrix[i * count + c] * middle[c]
        found = least(context, copy, right, count, reach, SAME_HOLD)
        for i in range(count):
            right[i] = right[i] + middle[i] if found == 0 else np.nan
    for c in range(count):
        share[held[c]] = right[c]
