"""The equations of motion as implicit methods see them: unknowns, derivatives, how stiff they are.

The unknowns of a step are the f independent coordinates u of the partition in force and their
velocities. At every iterate the dependent coordinates and velocities follow from the constraints,
starting where the last iterate left them, and the accelerations from the equations of motion. What
is integrated is thus ü = G(t, u, u̇), and as the formulas for u̇ are linear, u is eliminated:
Newton's matrices are I - c G_u̇ - c² G_u of order f, with c real or complex (E. Hairer and
G. Wanner, Solving Ordinary Differential Equations II, section IV.8). Where nothing is recovered
from constraints, all coordinates are unknowns.
"""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, view
from runtime.core.jit import compiled, inner
from runtime.core.kernel_abi import accelerations_tangent_of, correction_tangent_of
from runtime.core.loop_record import ConstraintReturn, is_near_singularity, run_record
from runtime.core.state_derivative import evaluate_accelerations
from runtime.integrate.implicit import method_memory as mem
from runtime.linalg.vectors import axpy, copy_vector, largest_ratio

_POWERS = 8  # safety: iterations of the power method before the mean, and within it
_QUIET = 0.5  # measured: h ρ with which an explicit method is at ease
_LONG = 30  # measured: steps at ease until the run returns to it


@inner
def stiffness(context: Context, h: float) -> float:
    """Largest row of h² |G_u| + h |G_u̇|, each entry relative to the sizes of its coordinates."""
    n, f = context[ft.COORDINATES], context.method_integers[mem.FREEDOMS]
    unknown, size = mem.unknowns(context), ws.row_of(context, ws.SIZE)
    by_u, by_rate = mem.derivative(context, mem.BY_U), mem.derivative(context, mem.BY_RATE)
    largest = 0.0
    for i in range(f):
        total = 0.0
        for k in range(f):
            row, column = unknown[i], unknown[k]
            total += h * h * abs(by_u[i, k]) * size[column] / size[row]
            total += h * abs(by_rate[i, k]) * size[n + column] / size[n + row]
        largest = max(largest, total)
    return float(largest)


@inner
def estimate_spectrum(context: Context) -> None:
    """Find the largest |λ| of u̇ = y, ẏ = G_u u + G_u̇ y, and the damping of what belongs to it.

    The power method: the mean growth of an even number of iterations, as u and y have other units
    and their sizes change in turn. Three iterates in a row give a and b in λ² = a λ + b.
    """
    memory, f = context.method_floats, context.method_integers[mem.FREEDOMS]
    by_u, by_rate = mem.derivative(context, mem.BY_U), mem.derivative(context, mem.BY_RATE)
    rows = mem.rows(context)
    x, y, z = rows[mem.IN], rows[mem.OUT], rows[mem.SLOPE]
    memory[mem.STIFFNESS], memory[mem.DAMPING] = 0.0, 1.0
    for i in range(f):
        x[i] = 1.0 + 0.1 * i
        y[i] = 1.0 - 0.3 * i
    grown = 0.0
    xx, xy, yy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0
    for iteration in range(2 * _POWERS):
        largest = 0.0
        xx, xy, yy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(f):
            z[i] = 0.0
            for k in range(f):
                z[i] += by_u[i, k] * x[k] + by_rate[i, k] * y[k]
        for i in range(f):
            xx += x[i] * x[i]
            xy += x[i] * y[i]
            yy += y[i] * y[i]
            xz += x[i] * z[i]
            yz += y[i] * z[i]
            x[i], y[i] = y[i], z[i]
            largest = max(largest, abs(x[i]), abs(y[i]))
        if not (largest > 0.0 and np.isfinite(largest)):
            return
        for i in range(f):
            x[i] /= largest
            y[i] /= largest
        if iteration >= _POWERS:
            grown += np.log(largest)
    memory[mem.STIFFNESS] = np.exp(grown / _POWERS)
    independent = xx * yy - xy * xy
    if independent > 1e-10 * xx * yy:
        a = (xx * yz - xy * xz) / independent
        b = (yy * xz - xy * yz) / independent
    elif f == 1:
        a, b = by_rate[0, 0], by_u[0, 0]
    else:
        return
    if a * a + 4.0 * b < 0.0:
        memory[mem.STIFFNESS] = np.sqrt(-b)
        memory[mem.DAMPING] = -0.5 * a / np.sqrt(-b)


@inner
def suits_explicit(context: Context, h: float) -> int:
    """1 where an explicit method could long have taken the same steps, and may be chosen."""
    r, notes = run_record(context), context.method_integers
    quiet = r.automatic != 0 and h * context.method_floats[mem.STIFFNESS] < _QUIET
    notes[mem.CALM] = notes[mem.CALM] + 1 if quiet else 0
    if notes[mem.CALM] < _LONG * r.patience:
        return 0
    notes[mem.CALM] = 0
    return 1


_DIFFERENCE = 1e-7  # accuracy: relative change that differences a right-hand side in sliding modes


@inner
def list_unknowns(context: Context) -> int:
    """List the unknowns in `notes`; returns f. Derivatives for others are no longer current.

    They are the independent coordinates. Where steps are not brought back by partitioning, and near
    singular positions, where no coordinates are independent, they are all.
    """
    notes, unknown = context.method_integers, mem.unknowns(context)
    partition = ws.row_of(context, ws.PARTITION)
    constrained = context[ft.CONSTRAINT_COUNT] > 0 and not is_near_singularity(context)
    by_partition = context[ft.CORRECTING] == ConstraintReturn.BY_PARTITION
    notes[mem.PARTITIONED] = 1 if constrained and by_partition else 0
    f, changed = 0, False
    for j in range(context[ft.COORDINATES]):
        if notes[mem.PARTITIONED] == 0 or partition[j] == 0.0:
            changed = changed or unknown[f] != j
            unknown[f] = j
            f += 1
    if changed or notes[mem.FREEDOMS] != f:
        notes[mem.FREEDOMS] = f
        notes[mem.CURRENT] = 0
        notes[mem.SETTLED] = 0
    return f


@inner
def evaluate(context: Context, t: float, state: int, derivative: int) -> int:
    """Complete the state in row `state` by its dependent half, and write its accelerations.

    Fills the acceleration half of row `derivative` alone; the caller counts `rhs`. Returns the
    iterations that took, or `FAILED`.
    """
    taken = 0
    if context.method_integers[mem.PARTITIONED] != 0:
        taken = ft.correct_of(context)(context, t, state, ws.PARTITION)
        if taken == FAILED:
            return FAILED
    q, v = ws.positions(context, state), ws.velocities(context, state)
    a = ws.velocity_rates(context, derivative)
    evaluate_accelerations(context, t, q, v, context.modes, a)
    return taken


@inner
def complete_direction(context: Context, t: float, state: int) -> None:
    """Complete a change of independent coordinates and velocities by the dependent ones' change.

    Row IN holds the change, zero on the dependent coordinates on entry; row OUT is overwritten.
    """
    if context.method_integers[mem.PARTITIONED] == 0:
        return
    tangent, p = correction_tangent_of(context), context.parameters
    q, v = ws.positions(context, state), ws.velocities(context, state)
    weights = context.correction_weights
    dq, dv = mem.half(context, mem.IN, 0), mem.half(context, mem.IN, 1)
    out_q, out_v = mem.half(context, mem.OUT, 0), mem.half(context, mem.OUT, 1)
    tangent(t, q, v, p, weights, dq, dv, out_q, out_v)
    axpy(1.0, out_q, dq)
    tangent(t, q, v, p, weights, dq, dv, out_q, out_v)
    axpy(1.0, out_v, dv)


@inner
def differentiate_along(context: Context, t: float, state: int) -> None:
    """Derivative of the accelerations at row `state` along row IN, into the first half of SLOPE.

    Exact for the machine's own equations; along a surface of switching conditions, and with terms
    that stabilize, a difference.
    """
    modes = context.modes
    q, v = ws.positions(context, state), ws.velocities(context, state)
    dq, dv = mem.half(context, mem.IN, 0), mem.half(context, mem.IN, 1)
    da, n = mem.half(context, mem.SLOPE, 0), context[ft.COORDINATES]
    if context[ft.MODIFIED] == 0:
        p = context.parameters
        accelerations_tangent_of(context)(t, q, v, p, modes, dq, dv, da)
        return
    largest = largest_ratio(mem.rows(context)[mem.IN], ws.row_of(context, ws.SIZE))
    if largest == 0.0:
        da.fill(0.0)
        return
    step = _DIFFERENCE / largest
    # The complex matrix, factored after this, lends room of 3 n.
    free = mem.factors(context, mem.COMPLEX)
    before, kept_q, after = view(free, 0, n), view(free, n, n), view(free, 2 * n, n)
    evaluate_accelerations(context, t, q, v, modes, before)
    copy_vector(q, kept_q)
    copy_vector(v, da)
    axpy(step, dq, q)
    axpy(step, dv, v)
    evaluate_accelerations(context, t, q, v, modes, after)
    copy_vector(kept_q, q)
    copy_vector(da, v)
    for j in range(n):
        da[j] = (after[j] - before[j]) / step


@compiled(ft.DIFFERENTIATE)
def differentiate(context: Context, t: float, state: int) -> int:
    """Write G_u and G_u̇ at the state in row `state`, which is on the constraints.

    With e_k the change of one unknown, δq = H e_k and the change of dependent velocities that it
    causes are tangents of the recovery of dependent coordinates.
    """
    notes, unknown = context.method_integers, mem.unknowns(context)
    by_u, by_rate = mem.derivative(context, mem.BY_U), mem.derivative(context, mem.BY_RATE)
    dq, dv = mem.half(context, mem.IN, 0), mem.half(context, mem.IN, 1)
    da, f = mem.half(context, mem.SLOPE, 0), notes[mem.FREEDOMS]
    for k in range(f):
        dq.fill(0.0)
        dv.fill(0.0)
        dq[unknown[k]] = 1.0
        complete_direction(context, t, state)
        differentiate_along(context, t, state)
        for i in range(f):
            by_u[i, k] = da[unknown[i]]
        copy_vector(dq, dv)
        dq.fill(0.0)
        differentiate_along(context, t, state)
        for i in range(f):
            by_rate[i, k] = da[unknown[i]]
    notes[mem.CURRENT] = 1
    context.method_floats[mem.FACTORED_FOR] = 0.0
    run_record(context).jacobians += 1
    estimate_spectrum(context)
    return 0
