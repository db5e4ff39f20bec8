"""The equations of motion as implicit methods see them: their unknowns and derivatives.

The unknowns of a step are the f independent coordinates u of the partition in force and their
velocities. At every iterate the dependent coordinates and velocities follow from the constraints,
starting where the last iterate left them, and the accelerations from the equations of motion. What
is integrated is thus ü = G(t, u, u̇), and as the formulas for u̇ are linear, u is eliminated:
Newton's matrices are I - c G_u̇ - c² G_u of order f, with c real or complex (E. Hairer and
G. Wanner, Solving Ordinary Differential Equations II, section IV.8). Where nothing is recovered
from constraints, all coordinates are unknowns.
"""

from runtime.constraints.newton_return import FAILED, WEAK
from runtime.core.array_views import view
from runtime.core.function_table import (
    BENDS,
    CONSTRAINT_COUNT,
    CORRECTING,
    accelerations_tangent_of,
    correct_of,
    correction_tangent_of,
)
from runtime.core.jit import compiled, inner
from runtime.core.rhs import field
from runtime.core.signatures import DIFFERENTIATE, Integers, Vector
from runtime.core.workspace import FREE, MISSING, PARTITION, ROWS, SIZE, Run
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
    counts,
    floats,
    line,
    matrix,
)
from runtime.integrate.implicit.stiffness_estimate import take_spectrum

BY_PARTITION = 1  # the number CORRECTING of a machine whose steps are corrected by partitioning
# accuracy: relative change by which a right-hand side in sliding modes is differenced
_DIFFERENCE = 1e-7


@inner
def unknowns(machine: Integers, w: Vector, run: Run, notes: Integers) -> int:
    """List the unknowns in `notes`; returns f. Derivatives for others are no longer current.

    They are the independent coordinates. Where steps are not brought back by partitioning, and near
    singular positions, where no coordinates are independent, they are all.
    """
    n = w.size // (2 * ROWS)
    by_partition = machine[CONSTRAINT_COUNT] > 0 and machine[CORRECTING] == BY_PARTITION
    singular = FREE < run[0].plan < MISSING
    notes[PARTITIONED] = 1 if by_partition and not singular else 0
    f = 0
    for j in range(n):
        if notes[PARTITIONED] == 0 or w[PARTITION * 2 * n + j] == 0.0:
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
def arrive(
    machine: Integers,
    t: float,
    state: int,
    derivative: int,
    w: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """Complete the state in row `state` by its dependent half, and write its accelerations.

    Returns the iterations that took, or `FAILED`.
    """
    n = w.size // (2 * ROWS)
    taken = 0
    if counts(machine, n)[PARTITIONED] != 0:
        taken = correct_of(machine)(machine, t, state, PARTITION, w, p)
        if taken == FAILED:
            return FAILED
        taken %= WEAK
    q = view(w, state * 2 * n, n)
    v = view(w, state * 2 * n + n, n)
    field(machine, t, q, v, p, modes, view(w, derivative * 2 * n + n, n), lam)
    return taken


@inner
def carry(
    machine: Integers,
    t: float,
    state: int,
    dq: Vector,
    dv: Vector,
    out_q: Vector,
    out_v: Vector,
    w: Vector,
    p: Vector,
) -> None:
    """Complete a change of independent coordinates and velocities by the dependent ones' change.

    `dq` and `dv` are zero on the dependent coordinates on entry.
    """
    n = dq.size
    if counts(machine, n)[PARTITIONED] == 0:
        return
    tangent = correction_tangent_of(machine)
    q = view(w, state * 2 * n, n)
    v = view(w, state * 2 * n + n, n)
    weights = view(w, PARTITION * 2 * n, n)
    tangent(t, q, v, p, weights, dq, dv, out_q, out_v)
    for j in range(n):
        dq[j] += out_q[j]
    tangent(t, q, v, p, weights, dq, dv, out_q, out_v)
    for j in range(n):
        dv[j] += out_v[j]


@inner
def along(
    machine: Integers,
    t: float,
    state: int,
    dq: Vector,
    dv: Vector,
    da: Vector,
    free: Vector,
    w: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> None:
    """Derivative of the accelerations at the state in row `state` along (dq, dv).

    Exact for the machine's own equations; along a surface of switching conditions, and with terms
    that stabilize, a difference. `free` is overwritten.
    """
    n = dq.size
    q = view(w, state * 2 * n, n)
    v = view(w, state * 2 * n + n, n)
    if machine[BENDS] == 0:
        accelerations_tangent_of(machine)(t, q, v, p, modes, dq, dv, da)
        return
    size = view(w, SIZE * 2 * n, 2 * n)
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
    field(machine, t, q, v, p, modes, before, lam)
    for j in range(n):
        moved[j] = q[j]
        q[j] += step * dq[j]
        da[j] = v[j]
        v[j] += step * dv[j]
    # The state is put back before the accelerations overwrite what keeps its velocities.
    keep_q, keep_v = moved, da
    after = view(free, 2 * n, n)
    field(machine, t, q, v, p, modes, after, lam)
    for j in range(n):
        q[j] = keep_q[j]
        v[j] = keep_v[j]
    for j in range(n):
        da[j] = (after[j] - before[j]) / step


@compiled(DIFFERENTIATE)
def differentiate(
    machine: Integers,
    t: float,
    state: int,
    w: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """Write G_u and G_u̇ at the state in row `state`, which is on the constraints.

    With e_k the change of one unknown, δq = H e_k and the change of dependent velocities that it
    causes are tangents of the recovery of dependent coordinates.
    """
    n = w.size // (2 * ROWS)
    memory, notes = floats(machine, n), counts(machine, n)
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
        carry(machine, t, state, dq, dv, out_q, out_v, w, p)
        along(machine, t, state, dq, dv, da, free, w, p, modes, lam)
        for i in range(f):
            by_u[i * f + k] = da[notes[COUNTS + i]]
        for j in range(n):
            dv[j] = dq[j]
            dq[j] = 0.0
        along(machine, t, state, dq, dv, da, free, w, p, modes, lam)
        for i in range(f):
            by_rate[i * f + k] = da[notes[COUNTS + i]]
    notes[CURRENT] = 1
    memory[C_FACTORED] = 0.0
    run[0].jacobians += 1
    take_spectrum(memory, notes, n)
    return 0
