"""Radau IIA method of order 5 with exact derivatives, for the independent coordinates.

Formulas, transformation, error estimate and step control are those of E. Hairer and G. Wanner,
Solving Ordinary Differential Equations II, section IV.8. With the transformation of the three
stages Newton's method needs one real and one complex matrix, of order f each (see
`state_space_form`): the positions of the stages are linear in their velocities, hold exactly at
every iterate, and leave only the equation of the accelerations.

The estimate is of order h⁴ and the error of order h⁶, so that an estimate which is kept at the
tolerance gives errors that shrink faster than it. As in Hairer's program the tolerance is
therefore mapped: what the estimate is held to is `share` times what was asked.
"""

from runtime.constraints.newton_return import FAILED
from runtime.core import function_table_slots as ft
from runtime.core.arrays import EPS, Context, Integers, Vector, view
from runtime.core.dense_output import hermite_rows
from runtime.core.jit import addressed, compiled, inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import STAGE, Y0, Y1, F, K, row_of
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit import radau5_stages as rs
from runtime.integrate.implicit import simplified_newton as newton
from runtime.integrate.implicit.newton_matrices import factor_complex, factor_real, filtered_error
from runtime.integrate.implicit.radau5_stages import E_A, E
from runtime.integrate.implicit.state_space_form import differentiate, evaluate, list_unknowns
from runtime.integrate.implicit.stiffness_estimate import stiffness, suits_explicit
from runtime.linalg.vectors import axpy, copy_vector

_NEWTON = 5e-4  # measured: how far Newton's method is taken, over the tolerance: steps are few
_MOST_ITERATIONS = 7  # safety: Newton iterations of a step
_SLOWEST = 0.99  # safety: ratio of two Newton steps from which on the iteration is given up
_SAME = 1.2  # measured: a step that could grow by less keeps its length, and its matrices
_SMOOTH = 10.0  # measured: h² |G_u| + h |G_u̇| up to which accelerations add a sixth of their error


@inner
def share(rtol: float) -> float:
    """What the estimate is held to, over the tolerance asked: errors of a run go with h⁵."""
    return float(0.1 * rtol**-0.2)


@inner
def predict(context: Integers, h: float) -> int:
    """Predict the stages, whose dependent halves are not final, and set the tolerance by them."""
    rs.predict_stages(context, h)
    part, end = share(run_record(context).rtol), row_of(context, K + rs.STATES + 2)
    newton.set_tolerance(context, part, _NEWTON, 0, h * rs.C_REAL, end)
    rs.start_stages(context, h)
    return 0


@inner
def linearize(context: Integers, t: float) -> int:
    """Take the derivatives at the start of the step."""
    return int(differentiate(context, t, Y0))


@inner
def factor(context: Integers, h: float) -> int:
    """Factor both matrices; not 0 where one is singular."""
    singular = factor_real(context, h * rs.C_REAL)
    return int(singular + factor_complex(context, h * rs.C_COMPLEX, h * rs.C_IMAGINARY))


iterate = newton.newton_iteration(rs.evaluate_stages, rs.improve_stages, _MOST_ITERATIONS, _SLOWEST)
solve_step = newton.step_solver(predict, linearize, factor, iterate)


@inner
def embedded_error(context: Context, t: float, h: float, k0: Vector) -> float:
    """Size of the filtered error c (k0 + Σ e z / h) of the embedded formula of order 3.

    The error itself is left in row IN of METHOD_FLOATS.
    """
    n, unknown, rows = context[ft.COORDINATES], mem.unknowns(context), mem.rows(context)
    y0, s1 = row_of(context, Y0), row_of(context, K + rs.STATES)
    s2, s3 = row_of(context, K + rs.STATES + 1), row_of(context, K + rs.STATES + 2)
    one, two, three = rows[rs.VELOCITIES], rows[rs.VELOCITIES + 1], rows[rs.VELOCITIES + 2]
    rates, raw, c = rows[mem.SLOPE], rows[rs.SIDES], h * rs.C_REAL
    for i in range(context.method_integers[mem.FREEDOMS]):
        # The changes of positions are h (c u̇ + A Δu̇), and Σ e c = -1: nothing large cancels.
        j = unknown[i]
        z = E_A[0] * one[i] + E_A[1] * two[i] + E_A[2] * three[i]
        rates[n + i] = c * ((k0[j] - y0[n + j]) + z)
        z = E[0] * one[i] + E[1] * two[i] + E[2] * three[i]
        rates[i] = c * k0[n + j] + rs.C_REAL * z
    for j in range(n):
        z = E[0] * (s1[j] - y0[j]) + E[1] * (s2[j] - y0[j]) + E[2] * (s3[j] - y0[j])
        raw[j] = c * k0[j] + rs.C_REAL * z
    return float(filtered_error(context, t, Y0, c, raw))


@inner
def estimate_error(context: Context, t: float, h: float) -> float:
    """Error over the tolerance; where it is too large at a first step or again, filtered twice."""
    r, n = run_record(context), context[ft.COORDINATES]
    first = context.method_integers[mem.EQUAL] == 0
    size = embedded_error(context, t, h, row_of(context, K))
    if not (size >= 1.0 and (r.rejected_before != 0 or first)):
        return size
    z, slope = row_of(context, STAGE), row_of(context, K + mem.LAST)
    copy_vector(row_of(context, Y0), z)
    axpy(1.0, mem.rows(context)[mem.IN], z)
    if evaluate(context, t, STAGE, K + mem.LAST) == FAILED:
        return size
    r.rhs += 1
    copy_vector(view(z, n, n), slope)
    return embedded_error(context, t, h, slope)


@addressed(ft.STAGES)
def stages(context: Context, t: float, h: float) -> int:
    """Take the step from Y0 to Y1, of which the dependent half is not yet corrected."""
    list_unknowns(context)
    taken = solve_step(context, t, h)
    if taken != FAILED:
        copy_vector(row_of(context, K + rs.STATES + 2), row_of(context, Y1))
        context.method_floats[mem.STEP_ERROR] = estimate_error(context, t, h)
    return taken


@addressed(ft.PROPOSE)
def propose(context: Context, h: float) -> float:
    """Ratio of the next step's length to this accepted one's.

    The predictive controller of K. Gustafsson; a step that could grow by little keeps its length,
    and with it the factored matrices.
    """
    r, memory = run_record(context), context.method_floats
    notes, now = context.method_integers, max(r.error, 1e-10)
    ratio = now**-0.25
    if notes[mem.EQUAL] > 0:
        predicted = h / memory[mem.H_BASE] * (memory[mem.ERROR_BASE] / now) ** 0.25 * ratio
        ratio = min(ratio, predicted)
    spared = 2 * _MOST_ITERATIONS + 1
    ratio *= r.safety * spared / (spared - 1 + notes[mem.ITERATIONS])
    if r.rejected_before != 0:
        ratio = min(ratio, 1.0)
    if 1.0 <= ratio <= _SAME:
        return 1.0
    return float(max(r.shrink, min(r.grow, ratio)))


@compiled(ft.HOOK)
def accepted(context: Context, t: float, h: float) -> int:
    """Keep the step's polynomial, from which the next one's stages are predicted."""
    y0, y1, rows = row_of(context, Y0), row_of(context, Y1), mem.rows(context)
    memory = context.method_floats
    rs.keep_rounding(context, h)
    for i in range(y0.size):
        rows[rs.POLYNOMIAL, i] = y1[i] - y0[i]
    rs.write_polynomial(context, rows[rs.POLYNOMIAL + 1], rows[rs.POLYNOMIAL + 2])
    memory[mem.H_BASE] = h
    memory[mem.ERROR_BASE] = max(1e-2, run_record(context).error)
    context.method_integers[mem.EQUAL] += 1
    return int(suits_explicit(context, h))


@compiled(ft.HOOK)
def restart(context: Context, t: float, h: float) -> int:
    """Forget the past: the motion goes on under other equations."""
    notes = context.method_integers
    mem.rows(context)[mem.LOW].fill(0.0)
    notes[mem.EQUAL] = notes[mem.CURRENT] = 0
    return 0


@addressed(ft.DENSE)
def dense(context: Integers, t: float, h: float) -> int:
    """Fill the coefficient rows of the dense output of the step from Y0 to Y1.

    The collocation polynomial is of degree three. Where the equations are not stiff over the step,
    the accelerations at its ends are as good as the states, and a polynomial through positions,
    velocities and accelerations is of the method's own order; where they are stiff, errors of the
    state would be magnified in them.
    """
    n = context[ft.COORDINATES]
    y0, y1 = row_of(context, Y0), row_of(context, Y1)
    k0, k1 = row_of(context, K), row_of(context, K + mem.LAST)
    f1, f2, f3 = row_of(context, F + 1), row_of(context, F + 2), row_of(context, F + 3)
    f4, f5 = row_of(context, F + 4), row_of(context, F + 5)
    f4.fill(0.0)
    f5.fill(0.0)
    hermite_rows(context, h, K + mem.LAST)
    if stiffness(context, h) > _SMOOTH:
        rs.write_polynomial(context, f2, f3)
        return 0
    for i in range(n):
        j = n + i
        f4[i] = 0.5 * h * h * k0[j] + f2[i] - f3[i]
        f5[i] = 0.5 * h * h * k1[j] + f2[i] + 2.0 * f3[i] - f4[i]
        # The velocity's integral over the step is the change of position, but for rounding.
        mean = (y1[i] - y0[i]) / h
        f4[j] = 30.0 * (mean - y0[j] - f1[j] / 2.0 - f2[j] / 6.0 - f3[j] / 12.0)
        if abs(f4[j]) < 30.0 * EPS * ((abs(y0[i]) + abs(y1[i])) / h + abs(y0[j])):
            f4[j] = 0.0
    return 0


METHOD = newton.implicit_method(
    estimate_order=4,
    grow=8.0,  # measured: largest ratio of the lengths of two steps
    stages=stages,
    dense=dense,
    propose=propose,
    accepted=accepted,
    restart=restart,
)
