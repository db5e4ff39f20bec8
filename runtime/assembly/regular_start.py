"""The start of a machine whose joints close at once, in compiled code.

Joints close by the method of `joint_closing`, for all constraints of a small machine. Nearly every
start is regular: Newton's method closes the joints, their Jacobian is far from losing rank, and
nothing is out of scale. Any other is left to `assemble`, which finds out what is wrong and says so.
Single runs and ensembles come by here, so that they begin with the same bits.
"""

from math import sqrt

import numpy as np

from runtime.assembly.joint_closing import CLOSED, DIGITS, PENALTIES, ROUGH
from runtime.assembly.start_values import Start
from runtime.core.arrays import EPS, Context, Integers, Vector, f8, i8, vector
from runtime.core.jit import ADDRESSES, addressed, addresses, compiled, inner
from runtime.core.kernel_abi import (
    acceleration_rhs_of,
    constraints_of,
    jacobian_of,
    velocity_rhs_of,
)
from runtime.linalg.least_norm import ITERATIONS, ROUNDING
from runtime.linalg.orthogonal_factors import (
    bound_singular_value,
    factor_cholesky,
    factor_rows,
    solve_cholesky,
    solve_least_norm,
)
from runtime.linalg.rank_policy import LOST, NO_PIVOT
from runtime.linalg.vectors import copy_vector, dot, is_finite, largest_magnitude
from runtime.mechanism.dense_equations import Equations
from runtime.mechanism.typical_sizes import (
    LEAD,
    LEADING,
    StartTable,
    lead_of,
    measure_size,
    write_row_scale,
    write_scale,
)

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
def fill_rows(context: Context, free: Integers, scale: Vector, by_rows: bool) -> int:
    """Write Φ_q of the free coordinates, in parts of `scale`; their number.

    Rows are in parts of their typical changes, `by_rows`, or in parts of their length.
    """
    rows, width = context.scaled_rows, 0
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
        width = fill_rows(context, context.free_q, context.change_scale, True)
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
        width = fill_rows(context, context.free_q, context.change_scale, True)
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


VELOCITY_CLOSED = 1e-9  # accuracy: residual of Φ_q v = ν, scaled, in parts of the largest speed
LARGEST = 1e100  # safety: lengths and angles above this overflow when they are squared
_TURNS = 1e7  # safety: rad; the sines of larger angles lose digits that closing a joint needs
# measured: weight of a coordinate without a value in the scene; the others have 1
_UNNAMED_WEIGHT = 1e-3
# safety: bound of the least singular value, in rows of unit length, of a Jacobian far from losing
# rank: the root of rounding is 1.5e-8, and a start near a singular position has 6e-6
_CLEAR = 10.0 * LOST


@inner
def is_in_scale(context: Context, q: Vector) -> bool:
    """Whether lengths can be squared, and angles are so small that their sines have digits."""
    for j in range(q.size):
        if not abs(q[j]) <= (_TURNS if context.of_length[j] == 0 else LARGEST):
            return False
    return True


@inner
def is_clear_of_dependence(context: Context, all_of_them: Integers) -> bool:
    """Whether Φ_q is far from losing rank, its columns scaled, its rows of unit length."""
    width = fill_rows(context, all_of_them, context.change_scale, False)
    for i in range(context.scaled_rows.shape[0]):
        length = sqrt(dot(context.scaled_rows[i], context.scaled_rows[i]))
        if not (0.0 < length < np.inf):
            return False
        for k in range(width):
            context.scaled_rows[i, k] /= length
    if not factor_rows(context.scaled_rows, width, context.lower, NO_PIVOT):
        return False
    return bound_singular_value(context.lower, context.gaps) > _CLEAR


@inner
def are_finite(context: Context, t: float, q: Vector, v: Vector, p: Vector) -> bool:
    """Whether Φ, Φ_q, ν and γ are; Φ_q is the last one."""
    finite = is_finite(context.slopes)
    constraints_of(context)(t, q, p, context.gaps)
    finite = finite and is_finite(context.gaps)
    acceleration_rhs_of(context)(t, q, v, p, context.gaps)
    finite = finite and is_finite(context.gaps)
    velocity_rhs_of(context)(t, q, p, context.gaps)
    return finite and is_finite(context.gaps)


@inner
def find_velocities(context: Context, t: float, p: Vector, q: Vector, v: Vector) -> bool:
    """Move free velocities as little as Φ_q v = ν allows; false where these do not reach it."""
    scale = context.speed_scale
    for j in range(v.size):
        scale[j] = context.change_scale[j] * context.ease_v[j]
    width = fill_rows(context, context.free_v, scale, True)
    if width > 0 and not factor_rows(context.scaled_rows, width, context.lower, NO_PIVOT):
        return False
    given = 0.0
    for j in range(v.size):
        given = max(given, abs(v[j] / context.change_scale[j]))
    for turn in range(4):
        velocity_rhs_of(context)(t, q, p, context.phi)
        for i in range(context.gaps.size):
            context.gaps[i] = -context.phi[i]
        for e in range(context.slopes.size):
            context.gaps[context.slope_rows[e]] += context.slopes[e] * v[context.slope_columns[e]]
        for i in range(context.gaps.size):
            context.gaps[i] /= -context.row_scale[i]
        if turn < 3 and width > 0:
            solve_least_norm(
                context.scaled_rows, width, context.lower, context.gaps, context.move_step
            )
            move(v, context.move_step, context.free_v, scale, context.moved)
            copy_vector(context.moved, v)
    speed = 0.0
    for j in range(v.size):
        speed = max(speed, abs(v[j] / context.change_scale[j]))
    for i in range(context.phi.size):
        given = max(given, abs(context.phi[i] / context.row_scale[i]))
    if CLOSED * speed > given:  # a coefficient has been divided by that is zero but for rounding
        return False
    speed = max(speed, 1.0)
    return largest_magnitude(context.gaps) <= VELOCITY_CLOSED * speed and is_finite(context.gaps)


@compiled(i8(ADDRESSES, f8, vector, vector))
def place_counted(context: Context, t: float, p: Vector, q: Vector) -> int:
    """Write what joints count and nobody gives as the bodies stand at q: angles within half a turn.

    Rows are h·d - s, and 2 (Δ_h cos θ/2 - Δ_0 sin θ/2); see `codegen.elements.space.joints`.
    """
    for j in range(q.size):
        if not context.ease_q[j] > 1.0:
            continue
        row = context.counted[j] - 1
        q[j] = 0.0
        constraints_of(context)(t, q, p, context.phi)
        gap = context.phi[row]
        if not abs(gap) > CLOSED:
            continue
        if context.of_length[j] == 0:
            q[j] = np.pi
            constraints_of(context)(t, q, p, context.phi)
            turn = -context.phi[row]
            gap = 2.0 * np.arctan2(gap if turn >= 0.0 else -gap, abs(turn))
        q[j] = gap
    return 0


@compiled(i8(ADDRESSES, f8, vector, vector, vector))
def assemble_regular(context: Context, t: float, p: Vector, q: Vector, v: Vector) -> int:
    """Overwrite start values by the assembled state: REGULAR, or what stands against it."""
    if not is_in_scale(context, q):
        return IRREGULAR
    size = measure_size(context, t, q, p)
    write_scale(context, size, context.change_scale)
    write_row_scale(context, t, q, p, size)
    largest = measure_gaps(context, t, q, p)
    if not largest <= LARGEST or not largest_magnitude(context.slopes) <= LARGEST:
        return IRREGULAR
    if not (is_finite(context.slopes) and is_finite(context.row_scale)):
        return IRREGULAR
    closing = close_joints(context, t, p, q)
    if closing != REGULAR:
        return closing
    if not is_in_scale(context, q):
        return IRREGULAR
    if not is_clear_of_dependence(context, context.every):
        return IRREGULAR
    context.moved[:] = 0.0
    if not are_finite(context, t, q, context.moved, p):
        return IRREGULAR
    if not find_velocities(context, t, p, q, v):
        return IRREGULAR
    return REGULAR if are_finite(context, t, q, v, p) else IRREGULAR


def allow(made: StartTable, start: Start) -> None:
    """Write into a table what is free in a start, and how much it weighs."""
    made.arrays["free_q"][:], made.arrays["free_v"][:] = ~start.fixed_q, ~start.fixed_v
    made.arrays["move_weight"][:] = weights(start)
    made.arrays["ease_q"][:], made.arrays["ease_v"][:] = start.ease


def let_lead(made: StartTable) -> None:
    """Let starts be far from closed joints; most are not, and do without compiling this."""
    made.table[LEAD] = addresses([lead])[0]


def weights(start: Start) -> Vector:
    """How much the coordinates of a start weigh, (n,): little, where no value is given."""
    found: Vector = np.where(start.given_q, 1.0, _UNNAMED_WEIGHT) / start.ease[0] ** 2
    return found


def find_regular_start(
    equations: Equations, t: float, start: Start
) -> tuple[Vector, Vector, Vector] | None:
    """The assembled state (q, v) and typical changes of coordinates, (n,) each.

    None where the start is not regular.
    """
    description = equations.description
    if equations.is_large or description.analysis == "equilibrium" or equations.m > equations.n:
        return None
    made = equations.start
    allow(made, start)
    q, v = start.q.copy(), start.v.copy()
    found = assemble_regular(made.table, t, equations.p, q, v)
    if found == FAR:
        let_lead(made)
        found = assemble_regular(made.table, t, equations.p, q, v)
    return (q, v, made.arrays["change_scale"].copy()) if found == REGULAR else None
