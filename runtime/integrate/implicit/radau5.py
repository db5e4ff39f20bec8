"""Radau IIA method of order 5 with exact derivatives, for the independent coordinates.

Formulas, coefficients, error estimate and step control are those of E. Hairer and G. Wanner,
Solving Ordinary Differential Equations II, sections IV.5 and IV.8; the transformation is that of
Hairer's program RADAU5. With it Newton's method for the three stages needs one real and one complex
matrix, of order f each (see `state_space_form`): the positions of the stages are linear in their
velocities, hold exactly at every iterate, and leave only the equation of the accelerations.

The estimate is of order h⁴ and the error of order h⁶, so that an estimate which is kept at the
tolerance gives errors that shrink faster than it. As in Hairer's program the tolerance is
therefore mapped: what the estimate is held to is `share` times what was asked.
"""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core import function_table_slots as ft
from runtime.core.arrays import EPS, Context, Integers, Matrix, Vector, view
from runtime.core.dense_output import hermite_rows
from runtime.core.jit import addressed, compiled, inlined, inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import STAGE, Y0, Y1, F, K, row_of, velocity_rates
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit import simplified_newton as newton
from runtime.integrate.implicit.simplified_newton import (
    factor_complex,
    factor_real,
    filtered_error,
    solve_factored,
)
from runtime.integrate.implicit.state_space_form import (
    differentiate,
    evaluate,
    list_unknowns,
    stiffness,
    suits_explicit,
)
from runtime.linalg.vectors import axpy, copy_vector

# formula: nodes and weights of the method
_S = 6.0**0.5
C = np.array([(4.0 - _S) / 10.0, (4.0 + _S) / 10.0, 1.0])
A = np.array([
    [(88 - 7 * _S) / 360, (296 - 169 * _S) / 1800, (-2 + 3 * _S) / 225],
    [(296 + 169 * _S) / 1800, (88 + 7 * _S) / 360, (-2 - 3 * _S) / 225],
    [(16 - _S) / 36, (16 + _S) / 36, 1 / 9],
])  # fmt: skip
# Weights of the error estimate, of changes of velocities; those of positions go with E A.
E = np.array([(-13 - 7 * _S) / 3, (-13 + 7 * _S) / 3, -1 / 3])
E_A = E @ A
# Eigenvalues of the inverse of A, and what makes it block diagonal: T⁻¹ A⁻¹ T.
REAL = 3.0 + 3.0 ** (2 / 3) - 3.0 ** (1 / 3)
COMPLEX = 3.0 + 0.5 * (3.0 ** (1 / 3) - 3.0 ** (2 / 3))
IMAGINARY = 0.5 * (3.0 ** (5 / 6) + 3.0 ** (7 / 6))
T = np.array([
    [9.1232394870892942792e-2, -0.14125529502095420843, -3.0029194105147424492e-2],
    [0.24171793270710701896, 0.20412935229379993199, 0.38294211275726193779],
    [0.96604818261509293619, 1.0, 0.0],
])  # fmt: skip
T_INVERSE = np.array([
    [4.3255798900631553510, 0.33919925181580986954, 0.54177053993587487119],
    [-4.1787185915519047273, -0.32768282076106238708, 0.47662355450055045196],
    [-0.50287263494578687595, 2.5719269498556054292, -0.59603920482822492497],
])  # fmt: skip
# 1 / (COMPLEX ± i IMAGINARY): the matrices' c over h.
_NORM = COMPLEX**2 + IMAGINARY**2
C_REAL, C_COMPLEX, C_IMAGINARY = 1.0 / REAL, COMPLEX / _NORM, -IMAGINARY / _NORM

# Rows: the last step's polynomial; per stage the change of velocities; the right sides.
POLYNOMIAL, VELOCITIES, SIDES = 0, 3, 6
# Rows of the workspace after K: the stages' derivatives and states.
SLOPES, STATES = 2, 5

_NEWTON = 5e-4  # measured: tolerance of Newton's method over that of the user; steps are few
_MOST_ITERATIONS = 7  # safety: Newton iterations of a step
_SLOWEST = 0.99  # safety: ratio of two Newton steps from which on the iteration ends
_SAME = 1.2  # measured: a step that could grow by less keeps its length, and its matrices
_SMOOTH = 10.0  # measured: h² |G_u| + h |G_u̇| up to which accelerations add a sixth of their error
GROW = 10.0  # measured: ratio of two steps up to which the last polynomial predicts the next one


@inlined
def combine(weights: Matrix, i: int, x: float, y: float, z: float) -> float:
    """Entry i of a matrix of order 3 times (x, y, z)."""
    return float(weights[i, 0] * x + weights[i, 1] * y + weights[i, 2] * z)


@inner
def predict_stages(context: Context, h: float) -> None:
    """Fill the states of the stages: the last step's polynomial continued, or a straight line."""
    memory, notes, rows = context.method_floats, context.method_integers, mem.rows(context)
    y0, k0 = row_of(context, Y0), row_of(context, K)
    f1, f2, f3 = rows[POLYNOMIAL], rows[POLYNOMIAL + 1], rows[POLYNOMIAL + 2]
    ratio = h / memory[mem.H_BASE] if notes[mem.EQUAL] > 0 else np.inf
    for stage in range(3):
        c, z = C[stage], row_of(context, K + STATES + stage)
        for i in range(z.size):
            if ratio > GROW:
                z[i] = y0[i] + c * h * k0[i]
            else:
                # It passes the state at x = 1, which is where this step starts.
                x = 1.0 + c * ratio
                z[i] = y0[i] + (x - 1.0) * (f1[i] - x * (f2[i] + x * f3[i]))


@inner
def write_polynomial(context: Integers, f2: Vector, f3: Vector) -> None:
    """Coefficients F2 and F3 of the polynomial through the start and the three stages."""
    y0, y1 = row_of(context, Y0), row_of(context, Y1)
    s1, s2 = row_of(context, K + STATES), row_of(context, K + STATES + 1)
    c1, c2 = C[0], C[1]
    for i in range(y0.size):
        change = y1[i] - y0[i]
        one = ((s1[i] - y0[i]) / c1 - change) / (1.0 - c1)
        two = ((s2[i] - y0[i]) / c2 - change) / (1.0 - c2)
        f3[i] = (two - one) / (c2 - c1)
        f2[i] = one - c1 * f3[i]


@inlined
def mean_velocity(context: Integers, stage: int, i: int, v: float) -> float:
    """Change of unknown i from the start to a stage, over h; `v` is its velocity at the start."""
    z = mem.rows(context)
    one, two, three = z[VELOCITIES, i], z[VELOCITIES + 1, i], z[VELOCITIES + 2, i]
    return float(C[stage] * v + combine(A, stage, one, two, three))


@inner
def set_stages(context: Context, h: float) -> None:
    """Set the unknowns of all stages from their changes of velocity."""
    n, unknown, rows = context[ft.COORDINATES], mem.unknowns(context), mem.rows(context)
    y0, low = row_of(context, Y0), rows[mem.LOW]
    for stage in range(3):
        z, change = row_of(context, K + STATES + stage), rows[VELOCITIES + stage]
        for i in range(context.method_integers[mem.FREEDOMS]):
            j = unknown[i]
            z[n + j] = y0[n + j] + (low[n + j] + change[i])
            z[j] = y0[j] + (low[j] + h * mean_velocity(context, stage, i, y0[n + j]))


@inner
def keep_rounding(context: Context, h: float) -> None:
    """Keep what rounding cut off the unknowns at Y1, where they are as the last stage left them."""
    n, unknown, rows = context[ft.COORDINATES], mem.unknowns(context), mem.rows(context)
    y0, y1 = row_of(context, Y0), row_of(context, Y1)
    before, low, last = rows[SIDES], rows[mem.LOW], rows[VELOCITIES + 2]
    copy_vector(low, before)
    low.fill(0.0)
    for i in range(context.method_integers[mem.FREEDOMS]):
        j = unknown[i]
        change = before[n + j] + last[i]
        if y1[n + j] == y0[n + j] + change:
            low[n + j] = change - (y1[n + j] - y0[n + j])
        change = before[j] + h * mean_velocity(context, 2, i, y0[n + j])
        if y1[j] == y0[j] + change:
            low[j] = change - (y1[j] - y0[j])


@inner
def start_stages(context: Context, h: float) -> None:
    """Take the changes of velocity from the predicted stages, and set their positions by them."""
    n, unknown, y0 = context[ft.COORDINATES], mem.unknowns(context), row_of(context, Y0)
    for stage in range(3):
        z, change = row_of(context, K + STATES + stage), mem.rows(context)[VELOCITIES + stage]
        for i in range(context.method_integers[mem.FREEDOMS]):
            j = n + unknown[i]
            change[i] = z[j] - y0[j]
    set_stages(context, h)


@inner
def evaluate_stages(context: Integers, t: float, h: float) -> int:
    """Complete the stages and write their accelerations; iterations that took, or `FAILED`."""
    taken = 0
    for stage in range(3):
        result = evaluate(context, t + C[stage] * h, K + STATES + stage, K + SLOPES + stage)
        if result == FAILED:
            return FAILED
        taken += result
        run_record(context).rhs += 1
    return taken


@inner
def improve_stages(context: Context, h: float) -> float:
    """Change the stages by a Newton step; its size over the tolerance.

    T⁻¹ times their three equations leaves one of them alone, and two that are one complex equation.
    """
    n, f = context[ft.COORDINATES], context.method_integers[mem.FREEDOMS]
    unknown, rows = mem.unknowns(context), mem.rows(context)
    one, two, three = rows[VELOCITIES], rows[VELOCITIES + 1], rows[VELOCITIES + 2]
    real, pair, allowed = rows[SIDES], rows[SIDES + 1], rows[mem.TOLERANCE]
    a1, a2 = velocity_rates(context, K + SLOPES), velocity_rates(context, K + SLOPES + 1)
    a3 = velocity_rates(context, K + SLOPES + 2)
    for i in range(f):
        j = unknown[i]
        re = h * combine(T_INVERSE, 1, a1[j], a2[j], a3[j])
        im = h * combine(T_INVERSE, 2, a1[j], a2[j], a3[j])
        of_real = h * C_REAL * combine(T_INVERSE, 0, a1[j], a2[j], a3[j])
        real[i] = of_real - combine(T_INVERSE, 0, one[i], two[i], three[i])
        of_real = C_COMPLEX * re - C_IMAGINARY * im
        pair[i] = of_real - combine(T_INVERSE, 1, one[i], two[i], three[i])
        of_imaginary = C_COMPLEX * im + C_IMAGINARY * re
        pair[f + i] = of_imaginary - combine(T_INVERSE, 2, one[i], two[i], three[i])
    solve_factored(context, mem.REAL, real)
    solve_factored(context, mem.COMPLEX, pair)
    total = 0.0
    for i in range(f):
        j = unknown[i]
        d1 = combine(T, 0, real[i], pair[i], pair[f + i])
        d2 = combine(T, 1, real[i], pair[i], pair[f + i])
        d3 = combine(T, 2, real[i], pair[i], pair[f + i])
        one[i] += d1
        two[i] += d2
        three[i] += d3
        scale = allowed[n + j]
        total += (d1 / scale) ** 2 + (d2 / scale) ** 2 + (d3 / scale) ** 2
        for stage in range(3):
            total += (h * combine(A, stage, d1, d2, d3) / allowed[j]) ** 2
    set_stages(context, h)
    return float(np.sqrt(total / max(1, 6 * f)))


@inner
def share(rtol: float) -> float:
    """What the estimate is held to, over the tolerance asked: errors of a run go with h⁵."""
    return float(0.1 * rtol**-0.2)


@inner
def predict(context: Integers, h: float) -> int:
    """Predict the stages, whose dependent halves are not final, and set the tolerance by them."""
    predict_stages(context, h)
    part, end = share(run_record(context).rtol), row_of(context, K + STATES + 2)
    newton.set_tolerance(context, part, _NEWTON, 0, h * C_REAL, end)
    start_stages(context, h)
    return 0


@inner
def linearize(context: Integers, t: float) -> int:
    """Take the derivatives at the start of the step."""
    return int(differentiate(context, t, Y0))


@inner
def factor(context: Integers, h: float) -> int:
    """Factor both matrices; not 0 where one is singular."""
    singular = factor_real(context, h * C_REAL)
    return int(singular + factor_complex(context, h * C_COMPLEX, h * C_IMAGINARY))


iterate = newton.newton_iteration(evaluate_stages, improve_stages, _MOST_ITERATIONS, _SLOWEST)
solve_step = newton.step_solver(predict, linearize, factor, iterate)


@inner
def embedded_error(context: Context, t: float, h: float, k0: Vector) -> float:
    """Size of the filtered error c (k0 + Σ e z / h) of the embedded formula of order 3.

    The error itself is left in row IN of METHOD_FLOATS.
    """
    n, unknown, rows = context[ft.COORDINATES], mem.unknowns(context), mem.rows(context)
    y0, s1 = row_of(context, Y0), row_of(context, K + STATES)
    s2, s3 = row_of(context, K + STATES + 1), row_of(context, K + STATES + 2)
    one, two, three = rows[VELOCITIES], rows[VELOCITIES + 1], rows[VELOCITIES + 2]
    rates, raw, c = rows[mem.SLOPE], rows[SIDES], h * C_REAL
    for i in range(context.method_integers[mem.FREEDOMS]):
        # The changes of positions are h (c u̇ + A Δu̇), and Σ e c = -1: nothing large cancels.
        j = unknown[i]
        z = E_A[0] * one[i] + E_A[1] * two[i] + E_A[2] * three[i]
        rates[n + i] = c * ((k0[j] - y0[n + j]) + z)
        z = E[0] * one[i] + E[1] * two[i] + E[2] * three[i]
        rates[i] = c * k0[n + j] + C_REAL * z
    for j in range(n):
        z = E[0] * (s1[j] - y0[j]) + E[1] * (s2[j] - y0[j]) + E[2] * (s3[j] - y0[j])
        raw[j] = c * k0[j] + C_REAL * z
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
        copy_vector(row_of(context, K + STATES + 2), row_of(context, Y1))
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
    keep_rounding(context, h)
    for i in range(y0.size):
        rows[POLYNOMIAL, i] = y1[i] - y0[i]
    write_polynomial(context, rows[POLYNOMIAL + 1], rows[POLYNOMIAL + 2])
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
        write_polynomial(context, f2, f3)
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
