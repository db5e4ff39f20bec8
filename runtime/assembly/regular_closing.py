"""Close the joints of a regular start, in compiled code; see `regular_start`.

It is the method of `joint_closing`, for all constraints of a small machine.
"""

import numpy as np

from runtime.assembly.joint_closing import CLOSED, DIGITS, PENALTIES, ROUGH
from runtime.core.arrays import EPS, Context, Integers, Vector
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import constraints_of, jacobian_of
from runtime.linalg.least_norm import ITERATIONS, ROUNDING
from runtime.linalg.orthogonal_factors import (
    factor_cholesky,
    factor_rows,
    solve_cholesky,
    solve_least_norm,
)
from runtime.linalg.rank_policy import NO_PIVOT
from runtime.linalg.vectors import copy_vector, largest_magnitude
from runtime.mechanism.start_table import LEAD, LEADING, lead_of

IRREGULAR, REGULAR, FAR = 0, 1, 2
"""What a start is: far from closed joints, where nothing leads to them."""
_SMALL = 1e-5  # measured: scaled step that ends a minimisation
_DAMPED = 40  # safety: steps of Levenberg and Marquardt for a penalty


@inner
def measure_gaps(context: Context, t: float, q: Vector, p: Vector) -> float:
    """Write the scaled constraints; their largest, infinite where one is no number."""
    constraints_of(context)(t, q, p, context.gaps)
    largest = 0.0
    for i in range(context.gaps.size):
        context.gaps[i] /= context.row_scale[i]
        size = abs(context.gaps[i])
        largest = max(largest, size if np.isfinite(size) else np.inf)
    return largest


@inner
def fill_rows(context: Context, free: Integers, by_rows: bool) -> int:
    """Write the scaled Φ_q of the free coordinates; their number.

    Rows are in parts of their typical changes, `by_rows`, or in parts of their length.
    """
    rows, scale, width = context.scaled_rows, context.change_scale, 0
    rows[:, :] = 0.0
    for j in range(free.size):  # places of the columns
        context.move_step[j] = width
        width += free[j]
    for e in range(context.slopes.size):
        i, j = context.slope_rows[e], context.slope_columns[e]
        if free[j] != 0:
            unit = context.row_scale[i] if by_rows else 1.0
            rows[i, int(context.move_step[j])] = context.slopes[e] * scale[j] / unit
    return width


@inner
def move(q: Vector, step: Vector, free: Integers, scale: Vector, out: Vector) -> None:
    """Write q moved by a step of the scaled free coordinates."""
    place = 0
    for j in range(q.size):
        out[j] = q[j]
        if free[j] != 0:
            out[j] += step[place] * scale[j]
            place += 1


@inner
def penalised(context: Context, q: Vector, penalty: float) -> float:
    """(q - q0)ᵀ W (q - q0) + r Φᵀ Φ, its gaps known."""
    total = 0.0
    for j in range(q.size):
        if context.free_q[j] != 0:
            total += (
                context.move_weight[j] * ((q[j] - context.origin[j]) / context.change_scale[j]) ** 2
            )
    for i in range(context.gaps.size):
        total += penalty * context.gaps[i] ** 2
    return total


@inner
def fill_normal(context: Context, q: Vector, penalty: float, width: int) -> None:
    """Write the normal matrix and the right side, from the rows of Φ_q and the gaps."""
    normal, rows, place = context.normal, context.scaled_rows, 0
    for j in range(q.size):
        if context.free_q[j] != 0:
            away = (q[j] - context.origin[j]) / context.change_scale[j]
            context.move_right[place] = -context.move_weight[j] * away
            normal[place, : place + 1] = 0.0
            normal[place, place] = context.move_weight[j]
            place += 1
    for i in range(context.gaps.size):
        for a in range(width):
            if rows[i, a] != 0.0:
                context.move_right[a] -= penalty * rows[i, a] * context.gaps[i]
                for b in range(a + 1):
                    normal[a, b] += penalty * rows[i, a] * rows[i, b]


@inner
def minimise(context: Context, t: float, p: Vector, penalty: float, q: Vector) -> None:
    """Levenberg-Marquardt on the penalised sum of squares, from q, which it moves."""
    damping = 1e-6
    measure_gaps(context, t, q, p)
    current = penalised(context, q, penalty)
    for _ in range(_DAMPED):
        jacobian_of(context)(t, q, p, context.slopes)
        width = fill_rows(context, context.free_q, True)
        measure_gaps(context, t, q, p)
        fill_normal(context, q, penalty, width)
        for a in range(width):
            context.normal[a, a] += damping * (context.normal[a, a] + 1e-12)
        if not factor_cholesky(context.normal[:width, :width]):
            return
        solve_cholesky(context.normal[:width, :width], context.move_right[:width])
        move(q, context.move_right, context.free_q, context.change_scale, context.moved)
        measure_gaps(context, t, context.moved, p)
        after = penalised(context, context.moved, penalty)
        if after < current:
            copy_vector(context.moved, q)
            current, damping = after, max(damping * 0.2, 1e-12)
            if largest_magnitude(context.move_right[:width]) < _SMALL:
                return
        else:
            damping *= 8.0
            if damping > 1e8:
                return


@inner
def refine(context: Context, t: float, p: Vector, q: Vector) -> bool:
    """Newton's method by steps of least norm; false where the rows do not permit one."""
    best = measure_gaps(context, t, q, p)
    for _ in range(ITERATIONS):
        if best <= ROUNDING:
            return True
        jacobian_of(context)(t, q, p, context.slopes)
        width = fill_rows(context, context.free_q, True)
        measure_gaps(context, t, q, p)
        if not factor_rows(context.scaled_rows, width, context.lower, NO_PIVOT):
            return False
        for i in range(context.gaps.size):
            context.gaps[i] = -context.gaps[i]
        solve_least_norm(context.scaled_rows, width, context.lower, context.gaps, context.move_step)
        move(q, context.move_step, context.free_q, context.change_scale, context.moved)
        largest = measure_gaps(context, t, context.moved, p)
        if not largest < best:
            return True
        copy_vector(context.moved, q)
        slow = largest > 0.9 * best
        best = largest
        if slow:
            return True
    return True


@inner
def is_closed(context: Context, t: float, p: Vector, q: Vector) -> bool:
    """Whether all joints close, but for the last digits of coordinates far from the origin."""
    terms = context.steepest
    measure_gaps(context, t, q, p)
    jacobian_of(context)(t, q, p, context.slopes)
    terms[:] = 0.0
    for e in range(context.slopes.size):
        i = context.slope_rows[e]
        terms[i] += abs(context.slopes[e]) / context.row_scale[i] * abs(q[context.slope_columns[e]])
    for i in range(context.gaps.size):
        if not abs(context.gaps[i]) - DIGITS * EPS * terms[i] <= CLOSED:
            return False
    return True


@addressed(LEADING)
def lead(context: Context, t: float, p: Vector, q: Vector) -> int:
    """Bring q near to closed joints, by growing penalties."""
    copy_vector(q, context.origin)
    for penalty in PENALTIES:
        minimise(context, t, p, penalty, q)
    return 0


@inner
def close_joints(context: Context, t: float, p: Vector, q: Vector) -> int:
    """Move the free coordinates until all joints close: REGULAR, or what stands against it."""
    any_free = False
    for j in range(q.size):
        any_free = any_free or context.free_q[j] != 0
    if any_free and context.gaps.size > 0:
        if measure_gaps(context, t, q, p) > ROUGH:
            if context[LEAD] == 0:
                return FAR
            lead_of(context)(context, t, p, q)
        if not refine(context, t, p, q):
            return IRREGULAR
    return REGULAR if is_closed(context, t, p, q) else IRREGULAR
