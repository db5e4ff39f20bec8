"""Sliding modes: the shares of both vector fields that keep the motion on g = 0.

A function g is in sliding mode where the motion stays on g = 0: both fields push onto the surface
(A. F. Filippov, Differential Equations with Discontinuous Righthand Sides, 1988), friction sticks,
or a rigid contact is closed. With accelerations a⁰ and a¹ of modes 0 and 1 the motion has

    a = a⁰ + α (a¹ - a⁰),     dg/dt = 0,

the share α between bounds: 0 and 1; wider by the ratio of the coefficients where friction sticks.
A rigid contact has a¹ without its force and a⁰ with a unit of it; g̈ = 0 decides, and the reaction
is 1 - α units, from 0 to infinity; of a freewheel too, with dg/dt = 0. Friction in a joint has a⁰
without its force and a¹ with a unit of it (`rest_forces`). Several functions slide by as many
shares at once: forces of different effects add up, so that the accelerations of one changed mode
each are enough.

Reactions that depend on modes are the same convex combinations as accelerations, each mode with its
own multipliers; the others follow from the combined multipliers where they are linear in them.

Friction from reactions that slides while other functions stick, slide, or are closed is no linear
function of the forces that keep these at zero, since its normal force is the length of a reaction
which they change. Superposition of units is therefore no more than a first guess.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core.arrays import EPS, Context, Integers, Vector
from runtime.core.jit import addressed, inner
from runtime.core.kinds import FREE, SLIDING
from runtime.hybrid.rest_forces import (
    choose_units,
    enlarge_unit,
    is_clearly_driven,
    is_prescribed,
    is_unilateral,
    keep_resting,
    measure_forces,
    rest_mixed,
    set_unit,
    solve_least,
    write_forces,
)
from runtime.linalg.dense_elimination import solve_equilibrated
from runtime.linalg.rank_policy import SAME_HOLD
from runtime.linalg.vectors import axpy, copy_vector

CANCELLED = 64.0 * EPS  # accuracy: of the largest of some terms; a sum below it is their rounding

_UNITS = 3  # safety: changes of a unit of the stiction force

_TURNS = 40  # safety: corrections of shares if another friction slides
_AGREED = 1e-14  # accuracy: of a share; after smaller corrections friction obeys its law
_ROUNDED = 1e-10  # accuracy: the same, where corrections no longer become smaller


@inner
def evaluate_units(context: Context, t: float, q: Vector, v: Vector, modes: Integers) -> int:
    """Fill the base, in which nothing slides, the change by each sliding function, and responses.

    For friction with an unknown stiction force the change is that by a unit of this force. Counts
    the sliding functions. Returns the weak pivot of the base, as `accelerations` does.
    """
    p, places, kernel_modes = context.parameters, context.stiction_place, context.kernel_modes
    a, lam = context.base_accelerations, context.base_multipliers
    count = 0
    for k in range(context[ft.SWITCHES]):
        kernel_modes[k] = SLIDING if modes[k] == FREE else modes[k]
        if places[k] >= 0:
            p[places[k]] = 0.0
        if context.share_place[k] >= 0:
            p[context.share_place[k]] = 0.5  # of a friction that is free: none
        if modes[k] == SLIDING:
            kernel_modes[k] = SLIDING if places[k] >= 0 else 0
            context.sliding_functions[count] = k
            count += 1
    context[ft.SLIDING_COUNT] = count
    weak = 0
    for turn in range(2):
        weak = int(abi.accelerations_of(context)(t, q, v, p, kernel_modes, a, lam))
        evaluate_response(context, t, q, v, a, context.base_response)
        choose_units(context, t, q, v)
        for c in range(count):
            evaluate_unit(context, t, q, v, c)
        if turn == 1 or not rest_mixed(context):
            break
    return weak


@inner
def evaluate_unit(context: Context, t: float, q: Vector, v: Vector, c: int) -> None:
    """Fill the change of the motion by the `c`-th sliding function, and its response."""
    k, count = context.sliding_functions[c], context[ft.SLIDING_COUNT]
    a, lam = context.unit_accelerations[c], context.unit_multipliers[c]
    set_unit(context, k, 1)
    abi.accelerations_of(context)(t, q, v, context.parameters, context.kernel_modes, a, lam)
    set_unit(context, k, 0)
    evaluate_response(context, t, q, v, a, context.response_column)
    for i in range(count):
        context.response[i * count + c] = context.response_column[i] - context.base_response[i]
    if not is_clearly_driven(context, c):
        context.force_rates[k] = measure_forces(context, t, q, v, k)
        set_unit(context, k, 1)
        with_unit = measure_forces(context, t, q, v, k)
        set_unit(context, k, 0)
        context.force_rates[k] = max(with_unit, context.force_rates[k])
    axpy(-1.0, context.base_accelerations, a)
    axpy(-1.0, context.base_multipliers, lam)


@inner
def evaluate_response(
    context: Context, t: float, q: Vector, v: Vector, a: Vector, out: Vector
) -> None:
    """Write dg/dt, for a rigid contact g̈, of the functions in sliding mode."""
    rigid, rates, gaps = context.rigid, context.response_rates, context.response_gaps
    abi.switching_rates_of(context)(t, q, v, a, context.parameters, rates)
    if context[ft.RIGID_COUNT] > 0:
        abi.gap_accelerations_of(context)(t, q, v, a, context.parameters, gaps)
    for c in range(context[ft.SLIDING_COUNT]):
        k = context.sliding_functions[c]
        out[c] = gaps[rigid[k]] if rigid[k] >= 0 else rates[k]


@inner
def solve_shares(context: Context, t: float, q: Vector, v: Vector) -> None:
    """Write the shares of the functions in sliding mode; NaN where there are none.

    The matrix of responses changes only in the columns of units that prove too small.
    """
    grown = 0
    for _ in range(_UNITS):
        balance_shares(context)
        grown = 0
        for c in range(context[ft.SLIDING_COUNT]):
            if enlarge_unit(context, context.sliding_functions[c]):
                evaluate_unit(context, t, q, v, c)
                grown += 1
        if grown == 0:
            break
    if grown > 0:
        balance_shares(context)


@inner
def balance_shares(context: Context) -> None:
    """Solve for the shares with which dg/dt (of contacts g̈) of all sliding functions is zero."""
    solve_responses(context, context.response, 0.5, 1.0)
    for c in range(context[ft.SLIDING_COUNT]):
        context.share[context.sliding_functions[c]] = context.right_side[c]


@inner
def solve_responses(context: Context, matrix: Vector, rest: float, level: float) -> None:
    """Write the shares with which the responses of `matrix` cancel the base's into RIGHT_SIDE.

    What rests has the share `rest`. Of many solutions it is that nearest to `level` times the
    middle of the bounds; NaN where there are none.
    """
    s, count = context[ft.SWITCHES], context[ft.SLIDING_COUNT]
    right, copy = context.right_side, context.response_copy
    high, middle, reach = context.share_high, context.response_rates, context.response_column
    for i in range(count):
        right[i] = -context.base_response[i]
    for i in range(count * count):
        copy[i] = matrix[i]
    keep_resting(context, rest)
    if solve_equilibrated(copy, right, count, context.response_pivots, SAME_HOLD) != 0:
        for c in range(count):
            k = context.sliding_functions[c]
            # A contact without a force has its upper bound as its share, and no lower one.
            alone = is_unilateral(context, k)
            middle[c] = high[k] if alone else 0.5 * (context.share_low[k] + high[k])
            reach[c] = 1.0 if alone else 0.5 * (high[k] - context.share_low[k])
            if context.stiction_place[k] >= 0:
                middle[c], reach[c] = 0.0, context.stiction_units[s + k] / context.stiction_units[k]
            middle[c] *= level
        for i in range(count):
            right[i] = -context.base_response[i]
            for c in range(count):
                copy[i * count + c] = matrix[i * count + c]
                right[i] -= matrix[i * count + c] * middle[c]
        keep_resting(context, 0.0)
        failed = solve_least(context, SAME_HOLD)
        for i in range(count):
            right[i] = right[i] + middle[i] if failed == 0 else np.nan


@inner
def add_units(context: Context, j: int, start: float) -> tuple[float, float]:
    """`start` and the accelerations of coordinate j by all units times `right_side`; sum, maximum.

    The maximum is that of the terms.
    """
    total, largest = start, abs(start)
    for c in range(context[ft.SLIDING_COUNT]):
        part = context.right_side[c] * context.unit_accelerations[c, j]
        total += part
        largest = max(largest, abs(part))
    return total, largest


@inner
def combine_accelerations(context: Context, a: Vector) -> None:
    """Write the base and the shares of the units into `a`, which may be the base itself.

    The shares must just have been solved for.
    """
    for j in range(a.size):
        total, largest = add_units(context, j, context.base_accelerations[j])
        # Rounding that cancelling terms leave would make a machine at rest creep. NaN stays.
        a[j] = 0.0 if abs(total) <= CANCELLED * largest else total


@inner
def mix_reactions(context: Context, t: float, q: Vector, v: Vector, lam: Vector) -> None:
    """Fill REACTION for the combined multipliers `lam`, which must just have been evaluated.

    Friction that follows from a reaction is no linear function of them, and is mixed itself.
    """
    p, modes, sliding = context.parameters, context.kernel_modes, context.sliding_functions
    base, other = context.base_reaction, context.unit_reaction
    base_lam, mixed = context.given_multipliers, context.mixed_multipliers
    count, linear = context[ft.SLIDING_COUNT], context[ft.LINEAR_REACTIONS] != 0
    gather_prescribed(context)
    abi.reactions_of(context)(t, q, v, p, lam if linear else base_lam, base)
    abi.switched_reactions_of(context)(t, q, v, p, modes, base_lam, base)
    copy_vector(base, context.reaction)
    for c in range(count):
        if is_prescribed(context, sliding[c]):
            continue
        for i in range(base_lam.size):
            mixed[i] = base_lam[i] + context.unit_multipliers[c, i]
        set_unit(context, sliding[c], 1)
        copy_vector(base, other)
        if not linear:
            abi.reactions_of(context)(t, q, v, p, mixed, other)
        abi.switched_reactions_of(context)(t, q, v, p, modes, mixed, other)
        set_unit(context, sliding[c], 0)
        for i in range(base.size):
            context.reaction[i] += context.share[sliding[c]] * (other[i] - base[i])


@inner
def gather_prescribed(context: Context) -> None:
    """Fill GIVEN_MULTIPLIERS, of all that kernels take from `p`, and put it there."""
    copy_vector(context.base_multipliers, context.given_multipliers)
    for c in range(context[ft.SLIDING_COUNT]):
        k = context.sliding_functions[c]
        if is_prescribed(context, k):
            axpy(context.share[k], context.unit_multipliers[c], context.given_multipliers)
        else:
            set_unit(context, k, 0)
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
