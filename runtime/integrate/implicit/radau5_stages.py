"""The three stages of Radau IIA of order 5: coefficients, prediction, Newton step, polynomial.

The coefficients are from E. Hairer and G. Wanner, Solving Ordinary Differential Equations II,
sections IV.5 and IV.8, and, for the transformation, from Hairer's program RADAU5.
"""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core.arrays import Context, Integers, Matrix, Vector
from runtime.core.function_table_slots import COORDINATES
from runtime.core.jit import inlined, inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import Y0, Y1, K, row_of, velocity_rates
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.newton_matrices import solve_factored
from runtime.integrate.implicit.state_space_form import evaluate
from runtime.linalg.vectors import copy_vector

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

GROW = 10.0  # measured: ratio of two steps' lengths up to which the last one's polynomial foretells


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
    n, unknown, rows = context[COORDINATES], mem.unknowns(context), mem.rows(context)
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
    n, unknown, rows = context[COORDINATES], mem.unknowns(context), mem.rows(context)
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
    n, unknown, y0 = context[COORDINATES], mem.unknowns(context), row_of(context, Y0)
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
    n, f = context[COORDINATES], context.method_integers[mem.FREEDOMS]
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
