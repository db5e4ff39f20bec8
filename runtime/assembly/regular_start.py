"""The start of a machine whose joints close at once, in compiled code.

Nearly every start is regular: Newton's method closes the joints, their Jacobian is far from losing
rank, and nothing is out of scale. Any other is left to `assemble`, which finds out what is wrong
and says so. Single runs and ensembles come by here, so that they begin with the same bits.
"""

from math import sqrt

import numpy as np

from runtime.assembly.regular_closing import (
    FAR,
    IRREGULAR,
    REGULAR,
    close_joints,
    fill_rows,
    lead,
    measure_gaps,
    move,
)
from runtime.assembly.start_values import Start
from runtime.core.arrays import Context, Integers, Vector, f8, i8, vector
from runtime.core.jit import ADDRESSES, addresses, compiled, inner
from runtime.core.kernel_abi import acceleration_rhs_of, constraints_of, velocity_rhs_of
from runtime.linalg.orthogonal_factors import bound_singular_value, factor_rows, solve_least_norm
from runtime.linalg.rank_policy import LOST, NO_PIVOT
from runtime.linalg.vectors import copy_vector, dot, is_finite, largest_magnitude
from runtime.mechanism.dense_equations import Equations
from runtime.mechanism.start_table import LEAD, StartTable
from runtime.mechanism.typical_sizes import measure_size, write_row_scale, write_scale

VELOCITY_CLOSED = 1e-9  # accuracy: residual of Φ_q v = ν, scaled, in parts of the largest speed
LARGEST = 1e100  # safety: lengths and angles above this overflow when they are squared
_TURNS = 1e7  # safety: rad; the sines of larger angles lose digits that closing a joint needs
# measured: weight of a coordinate that the scene names no value of; the others have 1
_UNNAMED_WEIGHT = 1e-3
# safety: bound of the least singular value, rows of unit length, of a Jacobian that is far from
# losing rank: its square root of rounding is 1.5e-8, the distance of a start that is near 6e-6
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
    width = fill_rows(context, all_of_them, False)
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
    width = fill_rows(context, context.free_v, True)
    if width > 0 and not factor_rows(context.scaled_rows, width, context.lower, NO_PIVOT):
        return False
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
            move(v, context.move_step, context.free_v, context.change_scale, context.moved)
            copy_vector(context.moved, v)
    speed = 1.0
    for j in range(v.size):
        speed = max(speed, abs(v[j] / context.change_scale[j]))
    return largest_magnitude(context.gaps) <= VELOCITY_CLOSED * speed and is_finite(context.gaps)


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


def let_lead(made: StartTable) -> None:
    """Let starts be far from closed joints; most are not, and do without compiling this."""
    made.table[LEAD] = addresses([lead])[0]


def weights(start: Start) -> Vector:
    """How much the coordinates of a start weigh, (n,): little, where no value is given."""
    return np.where(start.given_q, 1.0, _UNNAMED_WEIGHT)


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
