"""The three stages of Radau IIA: their prediction, their Newton step, and their polynomial."""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core.array_types import Integers, Matrix, Vector
from runtime.core.function_table import COORDINATES, method_floats_of, method_integers_of
from runtime.core.jit import inlined, inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import Y0, Y1, K, row_of, velocity_rates
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.newton_matrices import solve_complex, solve_real
from runtime.integrate.implicit.radau5_coefficients import (
    C_COMPLEX,
    C_IMAGINARY,
    C_REAL,
    T_INVERSE,
    A,
    C,
    T,
)
from runtime.integrate.implicit.state_space_form import evaluate

# Rows: the last step's polynomial; per stage the change of velocities; the right sides.
POLYNOMIAL, VELOCITIES, SIDES = 0, 3, 6
# Rows of the workspace after K: the stages' derivatives and states.
SLOPES, STATES = 2, 5

GROW = 10.0  # measured: ratio of two steps' lengths up to which the last one's polynomial foretells


@inlined
def combine(rows: Matrix, i: int, x: float, y: float, z: float) -> float:
    """Entry i of a matrix of order 3 times (x, y, z)."""
    return float(rows[i, 0] * x + rows[i, 1] * y + rows[i, 2] * z)


@inner
def predict_stages(context: Integers, h: float) -> None:
    """Fill the states of the stages: the last step's polynomial continued, or a straight line."""
    memory, notes = method_floats_of(context), method_integers_of(context)
    length = 2 * context[COORDINATES]
    y0, k0 = row_of(context, Y0), row_of(context, K)
    f1, f2 = mem.row(context, POLYNOMIAL), mem.row(context, POLYNOMIAL + 1)
    f3 = mem.row(context, POLYNOMIAL + 2)
    ratio = h / memory[mem.H_BASE] if notes[mem.EQUAL] > 0 else 0.0
    for stage in range(3):
        c = C[stage]
        z = row_of(context, K + STATES + stage)
        if notes[mem.EQUAL] == 0 or ratio > GROW:
            for i in range(length):
                z[i] = y0[i] + c * h * k0[i]
        else:
            x = 1.0 + c * ratio
            for i in range(length):
                # It passes the state at x = 1, which is where this step starts.
                z[i] = y0[i] + (x - 1.0) * (f1[i] - x * (f2[i] + x * f3[i]))


@inner
def write_polynomial(context: Integers, f2: Vector, f3: Vector) -> None:
    """Coefficients F2 and F3 of the polynomial through the start and the three stages."""
    y0, y1 = row_of(context, Y0), row_of(context, Y1)
    s1, s2 = row_of(context, K + STATES), row_of(context, K + STATES + 1)
    c1, c2 = C[0], C[1]
    for i in range(2 * context[COORDINATES]):
        change = y1[i] - y0[i]
        one = ((s1[i] - y0[i]) / c1 - change) / (1.0 - c1)
        two = ((s2[i] - y0[i]) / c2 - change) / (1.0 - c2)
        f3[i] = (two - one) / (c2 - c1)
        f2[i] = one - c1 * f3[i]


@inlined
def mean_velocity(context: Integers, stage: int, i: int, v: float) -> float:
    """Change of unknown i from the start to a stage, over h; `v` is its velocity at the start."""
    one, two = mem.row(context, VELOCITIES), mem.row(context, VELOCITIES + 1)
    three = mem.row(context, VELOCITIES + 2)
    return float(C[stage] * v + combine(A, stage, one[i], two[i], three[i]))


@inner
def set_stages(context: Integers, h: float) -> None:
    """Set the unknowns of all stages from their changes of velocity."""
    n, unknown = context[COORDINATES], mem.unknowns(context)
    y0, low = row_of(context, Y0), mem.row(context, mem.LOW)
    for stage in range(3):
        z, change = row_of(context, K + STATES + stage), mem.row(context, VELOCITIES + stage)
        for i in range(method_integers_of(context)[mem.FREEDOMS]):
            j = unknown[i]
            z[n + j] = y0[n + j] + (low[n + j] + change[i])
            z[j] = y0[j] + (low[j] + h * mean_velocity(context, stage, i, y0[n + j]))


@inner
def keep_rounding(context: Integers, h: float) -> None:
    """Keep what rounding cut off the unknowns at Y1, where they are as the last stage left them."""
    n, unknown = context[COORDINATES], mem.unknowns(context)
    y0, y1 = row_of(context, Y0), row_of(context, Y1)
    low, kept = mem.row(context, mem.LOW), mem.row(context, SIDES)
    three = mem.row(context, VELOCITIES + 2)
    for j in range(2 * n):
        kept[j] = 0.0
    for i in range(method_integers_of(context)[mem.FREEDOMS]):
        j = unknown[i]
        change = low[n + j] + three[i]
        if y1[n + j] == y0[n + j] + change:
            kept[n + j] = change - (y1[n + j] - y0[n + j])
        change = low[j] + h * mean_velocity(context, 2, i, y0[n + j])
        if y1[j] == y0[j] + change:
            kept[j] = change - (y1[j] - y0[j])
    for j in range(2 * n):
        low[j] = kept[j]


@inner
def start_stages(context: Integers, h: float) -> None:
    """Take the changes of velocity from the predicted stages, and set their positions by them."""
    n, unknown = context[COORDINATES], mem.unknowns(context)
    y0 = row_of(context, Y0)
    for stage in range(3):
        z, change = row_of(context, K + STATES + stage), mem.row(context, VELOCITIES + stage)
        for i in range(method_integers_of(context)[mem.FREEDOMS]):
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
def improve_stages(context: Integers, h: float) -> float:
    """Change the stages by a Newton step; its size over the tolerance.

    T⁻¹ times their three equations leaves one of them alone, and two that are one complex equation.
    """
    n, f = context[COORDINATES], method_integers_of(context)[mem.FREEDOMS]
    unknown, allowed = mem.unknowns(context), mem.row(context, mem.TOLERANCE)
    one, two = mem.row(context, VELOCITIES), mem.row(context, VELOCITIES + 1)
    three = mem.row(context, VELOCITIES + 2)
    real, pair = mem.row(context, SIDES), mem.row(context, SIDES + 1)
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
    solve_real(context, real)
    solve_complex(context, pair)
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
