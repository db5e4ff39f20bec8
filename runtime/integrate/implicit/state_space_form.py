"""The equations of motion as implicit methods see them: their unknowns and derivatives.

The unknowns of a step are the f independent coordinates u of the partition in force and their
velocities. At every iterate the dependent coordinates and velocities follow from the constraints,
starting where the last iterate left them, and the accelerations from the equations of motion. What
is integrated is thus ü = G(t, u, u̇), and as the formulas for u̇ are linear, u is eliminated:
Newton's matrices are I - c G_u̇ - c² G_u of order f, with c real or complex (E. Hairer and
G. Wanner, Solving Ordinary Differential Equations II, section IV.8). Where nothing is recovered
from constraints, all coordinates are unknowns.
"""

from runtime.constraints.newton_return import FAILED
from runtime.core.array_types import Integers, Vector
from runtime.core.array_views import view
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    CORRECTING,
    DIFFERENTIATE,
    MODIFIED,
    correct_of,
    method_floats_of,
    method_integers_of,
    modes_of,
    parameters_of,
)
from runtime.core.jit import compiled, inner
from runtime.core.kernel_abi import accelerations_tangent_of, correction_tangent_of
from runtime.core.rhs import evaluate_accelerations
from runtime.core.run_record import ConstraintReturn, is_near_singularity, run_record
from runtime.core.workspace import (
    PARTITION,
    SIZE,
    first_half,
    positions,
    row_of,
    velocities,
    velocity_rates,
)
from runtime.integrate.implicit.method_memory import (
    C_FACTORED,
    COUNTS,
    CURRENT,
    FREEDOMS,
    IN,
    LINES,
    NUMBERS,
    OUT,
    PARTITIONED,
    SETTLED,
    SLOPE,
    line,
    matrix,
)
from runtime.integrate.implicit.stiffness_estimate import take_spectrum

# accuracy: relative change by which a right-hand side in sliding modes is differenced
_DIFFERENCE = 1e-7


@inner
def unknowns(context: Integers) -> int:
    """List the unknowns in `notes`; returns f. Derivatives for others are no longer current.

    They are the independent coordinates. Where steps are not brought back by partitioning, and near
    singular positions, where no coordinates are independent, they are all.
    """
    notes = method_integers_of(context)
    partition = row_of(context, PARTITION)
    n = context[COORDINATES]
    by_partition = (
        context[CONSTRAINT_COUNT] > 0 and context[CORRECTING] == ConstraintReturn.BY_PARTITION
    )
    notes[PARTITIONED] = 1 if by_partition and not is_near_singularity(context) else 0
    f = 0
    for j in range(n):
        if notes[PARTITIONED] == 0 or partition[j] == 0.0:
            if notes[COUNTS + f] != j:
                notes[COUNTS + f] = j
                notes[CURRENT] = 0
                notes[SETTLED] = 0
            f += 1
    if notes[FREEDOMS] != f:
        notes[FREEDOMS] = f
        notes[CURRENT] = 0
        notes[SETTLED] = 0
    return f


@inner
def arrive(context: Integers, t: float, state: int, derivative: int) -> int:
    """Complete the state in row `state` by its dependent half, and write its accelerations.

    Returns the iterations that took, or `FAILED`.
    """
    modes = modes_of(context)
    taken = 0
    if method_integers_of(context)[PARTITIONED] != 0:
        taken = correct_of(context)(context, t, state, PARTITION)
        if taken == FAILED:
            return FAILED
    q = positions(context, state)
    v = velocities(context, state)
    evaluate_accelerations(context, t, q, v, modes, velocity_rates(context, derivative))
    return taken


@inner
def carry(
    context: Integers, t: float, state: int, dq: Vector, dv: Vector, out_q: Vector, out_v: Vector
) -> None:
    """Complete a change of independent coordinates and velocities by the dependent ones' change.

    `dq` and `dv` are zero on the dependent coordinates on entry.
    """
    p = parameters_of(context)
    n = dq.size
    if method_integers_of(context)[PARTITIONED] == 0:
        return
    tangent = correction_tangent_of(context)
    q = positions(context, state)
    v = velocities(context, state)
    weights = first_half(context, PARTITION)
    tangent(t, q, v, p, weights, dq, dv, out_q, out_v)
    for j in range(n):
        dq[j] += out_q[j]
    tangent(t, q, v, p, weights, dq, dv, out_q, out_v)
    for j in range(n):
        dv[j] += out_v[j]


@inner
def along(
    context: Integers, t: float, state: int, dq: Vector, dv: Vector, da: Vector, free: Vector
) -> None:
    """Derivative of the accelerations at the state in row `state` along (dq, dv).

    Exact for the machine's own equations; along a surface of switching conditions, and with terms
    that stabilize, a difference. `free` is overwritten.
    """
    p = parameters_of(context)
    modes = modes_of(context)
    n = dq.size
    q = positions(context, state)
    v = velocities(context, state)
    if context[MODIFIED] == 0:
        accelerations_tangent_of(context)(t, q, v, p, modes, dq, dv, da)
        return
    size = row_of(context, SIZE)
    largest = 0.0
    for j in range(n):
        largest = max(largest, abs(dq[j]) / size[j], abs(dv[j]) / size[n + j])
    if largest == 0.0:
        for j in range(n):
            da[j] = 0.0
        return
    step = _DIFFERENCE / largest
    before = view(free, 0, n)
    moved = view(free, n, n)
    evaluate_accelerations(context, t, q, v, modes, before)
    for j in range(n):
        moved[j] = q[j]
        q[j] += step * dq[j]
        da[j] = v[j]
        v[j] += step * dv[j]
    # The state is put back before the accelerations overwrite what keeps its velocities.
    keep_q, keep_v = moved, da
    after = view(free, 2 * n, n)
    evaluate_accelerations(context, t, q, v, modes, after)
    for j in range(n):
        q[j] = keep_q[j]
        v[j] = keep_v[j]
    for j in range(n):
        da[j] = (after[j] - before[j]) / step


@compiled(DIFFERENTIATE)
def differentiate(context: Integers, t: float, state: int) -> int:
    """Write G_u and G_u̇ at the state in row `state`, which is on the constraints.

    With e_k the change of one unknown, δq = H e_k and the change of dependent velocities that it
    causes are tangents of the recovery of dependent coordinates.
    """
    n = context[COORDINATES]
    memory, notes = method_floats_of(context), method_integers_of(context)
    f = notes[FREEDOMS]
    by_u, by_rate = matrix(memory, 0, n), matrix(memory, 1, n)
    dq, dv = view(line(memory, IN, n), 0, n), view(line(memory, IN, n), n, n)
    out_q, out_v = view(line(memory, OUT, n), 0, n), view(line(memory, OUT, n), n, n)
    da = view(line(memory, SLOPE, n), 0, n)
    # The complex matrix, factored after this, lends room of 3 n.
    free = view(memory, NUMBERS + 2 * n * LINES + 3 * n * n, 4 * n * n)
    for k in range(f):
        for j in range(n):
            dq[j] = 0.0
            dv[j] = 0.0
        dq[notes[COUNTS + k]] = 1.0
        carry(context, t, state, dq, dv, out_q, out_v)
        along(context, t, state, dq, dv, da, free)
        for i in range(f):
            by_u[i * f + k] = da[notes[COUNTS + i]]
        for j in range(n):
            dv[j] = dq[j]
            dq[j] = 0.0
        along(context, t, state, dq, dv, da, free)
        for i in range(f):
            by_rate[i * f + k] = da[notes[COUNTS + i]]
    notes[CURRENT] = 1
    memory[C_FACTORED] = 0.0
    run_record(context).jacobians += 1
    take_spectrum(context, n)
    return 0
