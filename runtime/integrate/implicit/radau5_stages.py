"""The three stages of Radau IIA and Newton's method for them."""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core.array_types import Integers, Vector
from runtime.core.array_views import view
from runtime.core.function_table import COORDINATES, method_floats_of, method_integers_of
from runtime.core.jit import inner
from runtime.core.run_record import run_record
from runtime.core.workspace import Y0, Y1, K, row_of, velocity_rates
from runtime.integrate.implicit.bdf_history import GROW
from runtime.integrate.implicit.method_memory import (
    COUNTS,
    EQUAL,
    FREEDOMS,
    H_BASE,
    LOW,
    TOLERANCE,
    line,
    matrix,
)
from runtime.integrate.implicit.newton_matrices import DONE, GOING, converged
from runtime.integrate.implicit.radau5_coefficients import (
    A11,
    A12,
    A13,
    A21,
    A22,
    A23,
    A31,
    A32,
    A33,
    C1,
    C2,
    C_COMPLEX,
    C_IMAGINARY,
    C_REAL,
    I11,
    I12,
    I13,
    I21,
    I22,
    I23,
    I31,
    I32,
    I33,
    T11,
    T12,
    T13,
    T21,
    T22,
    T23,
    T31,
)
from runtime.integrate.implicit.state_space_form import arrive
from runtime.linalg.lu import solve

# Rows: the last step's polynomial; per stage the change of velocities; the right sides.
POLYNOMIAL, VELOCITIES, SIDES = 0, 3, 6
# Rows of the workspace after K: the stages' derivatives and states.
SLOPES, STATES = 2, 5

# measured: how far Newton's method is taken, over the tolerance of the user: steps are few
NEWTON = 5e-4
MOST_ITERATIONS = 7  # safety: Newton iterations of a step


@inner
def foresee(context: Integers, h: float) -> None:
    """Fill the states of the stages: the last step's polynomial continued, or a straight line."""
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    n = context[COORDINATES]
    length = 2 * n
    y0 = row_of(context, Y0)
    k0 = row_of(context, K)
    ratio = h / memory[H_BASE] if notes[EQUAL] > 0 else 0.0
    for stage in range(3):
        c = C1 if stage == 0 else (C2 if stage == 1 else 1.0)
        z = row_of(context, K + STATES + stage)
        if notes[EQUAL] == 0 or ratio > GROW:
            for i in range(length):
                z[i] = y0[i] + c * h * k0[i]
        else:
            x = 1.0 + c * ratio
            f1 = line(memory, POLYNOMIAL, n)
            f2, f3 = line(memory, POLYNOMIAL + 1, n), line(memory, POLYNOMIAL + 2, n)
            for i in range(length):
                # It passes the state at x = 1, which is where this step starts.
                z[i] = y0[i] + (x - 1.0) * (f1[i] - x * (f2[i] + x * f3[i]))


@inner
def curve(context: Integers, f2: Vector, f3: Vector) -> None:
    """Coefficients F2 and F3 of the polynomial through the start and the three stages."""
    length = 2 * context[COORDINATES]
    y0 = row_of(context, Y0)
    y1 = row_of(context, Y1)
    s1 = row_of(context, K + STATES)
    s2 = row_of(context, K + STATES + 1)
    for i in range(length):
        change = y1[i] - y0[i]
        one = ((s1[i] - y0[i]) / C1 - change) / (1.0 - C1)
        two = ((s2[i] - y0[i]) / C2 - change) / (1.0 - C2)
        f3[i] = (two - one) / (C2 - C1)
        f2[i] = one - C1 * f3[i]


@inner
def place(context: Integers, h: float, stage: int) -> None:
    """Set the unknowns of a stage from the changes of velocity of all three."""
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    n = context[COORDINATES]
    y0 = row_of(context, Y0)
    z = row_of(context, K + STATES + stage)
    low = line(memory, LOW, n)
    one, two, three = (
        line(memory, VELOCITIES, n),
        line(memory, VELOCITIES + 1, n),
        line(memory, VELOCITIES + 2, n),
    )
    for i in range(notes[FREEDOMS]):
        j = notes[COUNTS + i]
        if stage == 0:
            z[n + j] = y0[n + j] + (low[n + j] + one[i])
            change = C1 * y0[n + j] + A11 * one[i] + A12 * two[i] + A13 * three[i]
        elif stage == 1:
            z[n + j] = y0[n + j] + (low[n + j] + two[i])
            change = C2 * y0[n + j] + A21 * one[i] + A22 * two[i] + A23 * three[i]
        else:
            z[n + j] = y0[n + j] + (low[n + j] + three[i])
            change = y0[n + j] + A31 * one[i] + A32 * two[i] + A33 * three[i]
        z[j] = y0[j] + (low[j] + h * change)


@inner
def keep_low(context: Integers, h: float) -> None:
    """Keep what rounding cut off the unknowns at Y1, where they are as the last stage left them."""
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    n = context[COORDINATES]
    length = 2 * n
    y0 = row_of(context, Y0)
    y1 = row_of(context, Y1)
    low, kept = line(memory, LOW, n), line(memory, SIDES, n)
    one, two, three = (
        line(memory, VELOCITIES, n),
        line(memory, VELOCITIES + 1, n),
        line(memory, VELOCITIES + 2, n),
    )
    for j in range(length):
        kept[j] = 0.0
    for i in range(notes[FREEDOMS]):
        j = notes[COUNTS + i]
        change = low[n + j] + three[i]
        if y1[n + j] == y0[n + j] + change:
            kept[n + j] = change - (y1[n + j] - y0[n + j])
        change = y0[n + j] + A31 * one[i] + A32 * two[i] + A33 * three[i]
        change = low[j] + h * change
        if y1[j] == y0[j] + change:
            kept[j] = change - (y1[j] - y0[j])
    for j in range(length):
        low[j] = kept[j]


@inner
def newton(context: Integers, t: float, h: float) -> int:
    """Solve for the three stages; their dependent halves are not final.

    Returns calls of `correction`, or `FAILED` where the iteration does not converge.
    """
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    r = run_record(context)
    n = context[COORDINATES]
    f = notes[FREEDOMS]
    y0 = row_of(context, Y0)
    one, two, three = (
        line(memory, VELOCITIES, n),
        line(memory, VELOCITIES + 1, n),
        line(memory, VELOCITIES + 2, n),
    )
    real, pair = line(memory, SIDES, n), line(memory, SIDES + 1, n)
    a1 = velocity_rates(context, K + SLOPES)
    a2 = velocity_rates(context, K + SLOPES + 1)
    a3 = velocity_rates(context, K + SLOPES + 2)
    allowed = line(memory, TOLERANCE, n)
    for i in range(f):
        j = n + notes[COUNTS + i]
        one[i] = row_of(context, K + STATES)[j] - y0[j]
        two[i] = row_of(context, K + STATES + 1)[j] - y0[j]
        three[i] = row_of(context, K + STATES + 2)[j] - y0[j]
    for stage in range(3):
        place(context, h, stage)
    taken = 0
    before = 0.0
    for iteration in range(MOST_ITERATIONS):
        for stage in range(3):
            c = C1 if stage == 0 else (C2 if stage == 1 else 1.0)
            result = arrive(context, t + c * h, K + STATES + stage, K + SLOPES + stage)
            if result == FAILED:
                return FAILED
            taken += result
            r.rhs += 1
        r.iterations += 1
        for i in range(f):
            j = notes[COUNTS + i]
            real[i] = h * C_REAL * (I11 * a1[j] + I12 * a2[j] + I13 * a3[j]) - (
                I11 * one[i] + I12 * two[i] + I13 * three[i]
            )
            re = h * (I21 * a1[j] + I22 * a2[j] + I23 * a3[j])
            im = h * (I31 * a1[j] + I32 * a2[j] + I33 * a3[j])
            pair[i] = (
                C_COMPLEX * re - C_IMAGINARY * im - (I21 * one[i] + I22 * two[i] + I23 * three[i])
            )
            pair[f + i] = (
                C_COMPLEX * im + C_IMAGINARY * re - (I31 * one[i] + I32 * two[i] + I33 * three[i])
            )
        solve(matrix(memory, 2, n), f, view(notes, COUNTS + n, n), real)
        solve(matrix(memory, 3, n), 2 * f, view(notes, COUNTS + 2 * n, 2 * n), pair)
        total = 0.0
        for i in range(f):
            j = notes[COUNTS + i]
            d1 = T11 * real[i] + T12 * pair[i] + T13 * pair[f + i]
            d2 = T21 * real[i] + T22 * pair[i] + T23 * pair[f + i]
            d3 = T31 * real[i] + pair[i]
            one[i] += d1
            two[i] += d2
            three[i] += d3
            scale = allowed[n + j]
            total += (d1 / scale) ** 2 + (d2 / scale) ** 2 + (d3 / scale) ** 2
            scale = allowed[j] / h
            total += ((A11 * d1 + A12 * d2 + A13 * d3) / scale) ** 2
            total += ((A21 * d1 + A22 * d2 + A23 * d3) / scale) ** 2
            total += ((A31 * d1 + A32 * d2 + A33 * d3) / scale) ** 2
        for stage in range(3):
            place(context, h, stage)
        size = np.sqrt(total / max(1, 6 * f))
        left = MOST_ITERATIONS - 1 - iteration
        reached = converged(context, iteration, left, size, before, 0.99)
        if reached != GOING:
            return taken if reached == DONE else FAILED
        before = size
    return FAILED
