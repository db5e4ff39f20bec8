"""Sliding modes: the shares of both vector fields that keep the motion on g = 0.

A function g is in sliding mode where the motion stays on g = 0: both fields push onto the surface
(A. F. Filippov, Differential Equations with Discontinuous Righthand Sides, 1988), friction sticks,
or a rigid contact is closed. With accelerations a⁰ and a¹ of modes 0 and 1 the motion has

    a = a⁰ + α (a¹ - a⁰),     dg/dt = 0,

the share α between bounds: 0 and 1; wider by the ratio of the coefficients where friction sticks.
A rigid contact has a¹ without its force and a⁰ with a unit of it; g̈ = 0 decides, and the reaction
is 1 - α units, from 0 to infinity. Friction in a joint has a⁰ without its force and a¹ with a unit
of it (`stiction_force`). Several functions slide by as many shares at once: forces of different
effects add up, so that the accelerations of one changed mode each are enough.
"""

import numpy as np

from runtime.core import function_table as ft
from runtime.core import kernel_abi as abi
from runtime.core.array_types import Integers, Vector
from runtime.core.jit import inner
from runtime.core.modes import FREE, SLIDING
from runtime.core.rounding import EPS
from runtime.hybrid.redundant_sliding import solve_least
from runtime.hybrid.stiction_force import choose_units, enlarge_unit, set_unit
from runtime.linalg.lu import solve_equilibrated
from runtime.linalg.rank_policy import SAME_HOLD
from runtime.linalg.vectors import axpy

CANCELLED = 64.0 * EPS  # accuracy: of the largest of some terms; a sum below it is their rounding

_UNITS = 3  # safety: changes of a unit of the stiction force


@inner
def evaluate_units(context: Integers, t: float, q: Vector, v: Vector, modes: Integers) -> int:
    """Fill the base, in which nothing slides, the change by each sliding function, and responses.

    For friction with an unknown stiction force the change is that by a unit of this force. Counts
    the sliding functions. Returns the weak pivot of the base, as `accelerations` does.
    """
    p, places = ft.parameters_of(context), ft.stiction_place_of(context)
    kernel_modes, sliding = ft.kernel_modes_of(context), ft.sliding_functions_of(context)
    count = 0
    for k in range(context[ft.SWITCHES]):
        kernel_modes[k] = SLIDING if modes[k] == FREE else modes[k]
        if places[k] >= 0:
            p[places[k]] = 0.0
        if modes[k] == SLIDING:
            kernel_modes[k] = SLIDING if places[k] >= 0 else 0
            sliding[count] = k
            count += 1
    context[ft.SLIDING_COUNT] = count
    base_a, base_lam = ft.base_accelerations_of(context), ft.base_multipliers_of(context)
    weak = int(abi.accelerations_of(context)(t, q, v, p, kernel_modes, base_a, base_lam))
    evaluate_response(context, t, q, v, base_a, ft.base_response_of(context))
    choose_units(context, t, q, v)
    for c in range(count):
        evaluate_unit(context, t, q, v, c)
    return weak


@inner
def evaluate_unit(context: Integers, t: float, q: Vector, v: Vector, c: int) -> None:
    """Fill the change of the motion by the `c`-th sliding function, and its response."""
    p, kernel_modes = ft.parameters_of(context), ft.kernel_modes_of(context)
    k, count = ft.sliding_functions_of(context)[c], context[ft.SLIDING_COUNT]
    matrix, base = ft.response_of(context), ft.base_response_of(context)
    column = ft.response_column_of(context)
    a, lam = ft.unit_accelerations_of(context)[c], ft.unit_multipliers_of(context)[c]
    set_unit(context, k, 1)
    abi.accelerations_of(context)(t, q, v, p, kernel_modes, a, lam)
    set_unit(context, k, 0)
    evaluate_response(context, t, q, v, a, column)
    for i in range(count):
        matrix[i * count + c] = column[i] - base[i]
    axpy(-1.0, ft.base_accelerations_of(context), a)
    axpy(-1.0, ft.base_multipliers_of(context), lam)


@inner
def evaluate_response(
    context: Integers, t: float, q: Vector, v: Vector, a: Vector, out: Vector
) -> None:
    """Write dg/dt, for a rigid contact g̈, of the functions in sliding mode."""
    p, sliding = ft.parameters_of(context), ft.sliding_functions_of(context)
    rigid, rates = ft.rigid_of(context), ft.response_rates_of(context)
    gaps = ft.response_gaps_of(context)
    abi.switching_rates_of(context)(t, q, v, a, p, rates)
    if context[ft.RIGID_COUNT] > 0:
        abi.gap_accelerations_of(context)(t, q, v, a, p, gaps)
    for c in range(context[ft.SLIDING_COUNT]):
        k = sliding[c]
        out[c] = gaps[rigid[k]] if rigid[k] >= 0 else rates[k]


@inner
def solve_shares(context: Integers, t: float, q: Vector, v: Vector) -> None:
    """Write the shares of the functions in sliding mode; NaN where there are none.

    The matrix of responses changes only in the columns of units that prove too small.
    """
    sliding = ft.sliding_functions_of(context)
    for _ in range(_UNITS):
        balance_shares(context)
        grown = 0
        for c in range(context[ft.SLIDING_COUNT]):
            if enlarge_unit(context, sliding[c]):
                evaluate_unit(context, t, q, v, c)
                grown += 1
        if grown == 0:
            return
    balance_shares(context)


@inner
def balance_shares(context: Integers) -> None:
    """Solve for the shares with which dg/dt (of contacts g̈) of all sliding functions is zero."""
    s, count = context[ft.SWITCHES], context[ft.SLIDING_COUNT]
    sliding = ft.sliding_functions_of(context)
    share, matrix = ft.share_of(context), ft.response_of(context)
    base, right = ft.base_response_of(context), ft.right_side_of(context)
    copy, rigid = ft.response_copy_of(context), ft.rigid_of(context)
    for i in range(count):
        right[i] = -base[i]
    for i in range(count * count):
        copy[i] = matrix[i]
    if solve_equilibrated(copy, right, count, SAME_HOLD) != 0:
        places, forces = ft.stiction_place_of(context), ft.stiction_units_of(context)
        low, high = ft.share_low_of(context), ft.share_high_of(context)
        middle, reach = ft.response_rates_of(context), ft.response_column_of(context)
        for c in range(count):
            k = sliding[c]
            # A contact without a force has its upper bound as its share, and no lower one.
            middle[c] = high[k] if rigid[k] >= 0 else 0.5 * (low[k] + high[k])
            reach[c] = 1.0 if rigid[k] >= 0 else 0.5 * (high[k] - low[k])
            if places[k] >= 0:
                middle[c], reach[c] = 0.0, forces[s + k] / forces[k]
        for i in range(count):
            right[i] = -base[i]
            for c in range(count):
                copy[i * count + c] = matrix[i * count + c]
                right[i] -= matrix[i * count + c] * middle[c]
        failed = solve_least(context, copy, right, count, reach, SAME_HOLD)
        for i in range(count):
            right[i] = right[i] + middle[i] if failed == 0 else np.nan
    for c in range(count):
        share[sliding[c]] = right[c]


@inner
def combine_accelerations(context: Integers, a: Vector) -> None:
    """Write the base and the shares of the units into `a`, which may be the base itself."""
    base, units = ft.base_accelerations_of(context), ft.unit_accelerations_of(context)
    share, sliding = ft.share_of(context), ft.sliding_functions_of(context)
    for j in range(base.size):
        total, largest = base[j], abs(base[j])
        for c in range(context[ft.SLIDING_COUNT]):
            part = share[sliding[c]] * units[c, j]
            total += part
            largest = max(largest, abs(part))
        # Rounding that cancelling terms leave would make a machine at rest creep. NaN stays.
        a[j] = 0.0 if abs(total) <= CANCELLED * largest else total
