"""Explicit Runge-Kutta method of order 8(5,3) with dense output of order 7.

The method is J. R. Dormand and P. J. Prince's; the coefficients, the error estimate that joins one
of order 5 with one of order 3, and the dense output with its three further stages are those of
E. Hairer, S. P. Nørsett and G. Wanner, Solving Ordinary Differential Equations I, sections II.5 and
II.6, and of Hairer's program of the same name. Stage numbers count from 1, as there; stage 13 is
the derivative at the end of the step and the first of the next.
"""

import numpy as np

from runtime.core.dense_output import hermite_rows
from runtime.core.function_table import COORDINATES, DENSE, ERROR, STAGES
from runtime.core.jit import addressed
from runtime.core.rhs import slope
from runtime.core.signatures import Integers
from runtime.core.workspace import ATOL, STAGE, Y0, Y1, F, K, row_of
from runtime.integrate.explicit import dop853_coefficients as c
from runtime.integrate.explicit.stateless import accepted, restart
from runtime.integrate.step_control import propose

__all__ = ["accepted", "dense", "error", "propose", "restart", "stages"]

ORDER = 8
ERROR_ORDER = 7
STAGE_CALLS = 11  # calls of accelerations in `stages`
LAST = 12  # row, after K, of the derivative at the end of the step
DENSE_ROWS = 8
DENSE_CALLS = 3
# Step control: proportional part, and share of the length that the error permits. Beside 0.03 and
# 0.9 they reject 8 % of the steps and not 13 %, and cost 3 % less at equal error. With still larger
# ones the controller aims so far below the tolerance that it meets rounding there.
BETA, SAFETY = 0.04, 0.88
# Where in a step the equations are evaluated, its dense output included.
NODES = (
    *(0.0, c.C2, c.C3, c.C4, c.C5, c.C6, c.C7, c.C8, c.C9, c.C10, c.C11, 1.0),
    *(c.C14, c.C15, c.C16),
)
SHRINK, GROW = 0.333, 6.0  # limits of the change of a step's length


@addressed(STAGES)
def stages(context: Integers, t: float, h: float) -> int:
    """Take the step from Y0 with derivative K to Y1, not yet corrected."""
    length = 2 * context[COORDINATES]
    y0 = row_of(context, Y0)
    y1 = row_of(context, Y1)
    z = row_of(context, STAGE)
    k1 = row_of(context, K)
    k2 = row_of(context, K + 1)
    k3 = row_of(context, K + 2)
    k4 = row_of(context, K + 3)
    k5 = row_of(context, K + 4)
    k6 = row_of(context, K + 5)
    k7 = row_of(context, K + 6)
    k8 = row_of(context, K + 7)
    k9 = row_of(context, K + 8)
    k10 = row_of(context, K + 9)
    k11 = row_of(context, K + 10)
    k12 = row_of(context, K + 11)
    taken = 0
    for j in range(length):
        z[j] = y0[j] + h * (c.A2_1 * k1[j])
    taken += slope(context, t + c.C2 * h, STAGE, K + 1)
    for j in range(length):
        z[j] = y0[j] + h * (c.A3_1 * k1[j] + c.A3_2 * k2[j])
    taken += slope(context, t + c.C3 * h, STAGE, K + 2)
    for j in range(length):
        z[j] = y0[j] + h * (c.A4_1 * k1[j] + c.A4_3 * k3[j])
    taken += slope(context, t + c.C4 * h, STAGE, K + 3)
    for j in range(length):
        z[j] = y0[j] + h * (c.A5_1 * k1[j] + c.A5_3 * k3[j] + c.A5_4 * k4[j])
    taken += slope(context, t + c.C5 * h, STAGE, K + 4)
    for j in range(length):
        z[j] = y0[j] + h * (c.A6_1 * k1[j] + c.A6_4 * k4[j] + c.A6_5 * k5[j])
    taken += slope(context, t + c.C6 * h, STAGE, K + 5)
    for j in range(length):
        z[j] = y0[j] + h * (c.A7_1 * k1[j] + c.A7_4 * k4[j] + c.A7_5 * k5[j] + c.A7_6 * k6[j])
    taken += slope(context, t + c.C7 * h, STAGE, K + 6)
    for j in range(length):
        z[j] = y0[j] + h * (
            c.A8_1 * k1[j] + c.A8_4 * k4[j] + c.A8_5 * k5[j] + c.A8_6 * k6[j] + c.A8_7 * k7[j]
        )
    taken += slope(context, t + c.C8 * h, STAGE, K + 7)
    for j in range(length):
        z[j] = y0[j] + h * (
            c.A9_1 * k1[j]
            + c.A9_4 * k4[j]
            + c.A9_5 * k5[j]
            + c.A9_6 * k6[j]
            + c.A9_7 * k7[j]
            + c.A9_8 * k8[j]
        )
    taken += slope(context, t + c.C9 * h, STAGE, K + 8)
    for j in range(length):
        z[j] = y0[j] + h * (
            c.A10_1 * k1[j]
            + c.A10_4 * k4[j]
            + c.A10_5 * k5[j]
            + c.A10_6 * k6[j]
            + c.A10_7 * k7[j]
            + c.A10_8 * k8[j]
            + c.A10_9 * k9[j]
        )
    taken += slope(context, t + c.C10 * h, STAGE, K + 9)
    for j in range(length):
        z[j] = y0[j] + h * (
            c.A11_1 * k1[j]
            + c.A11_4 * k4[j]
            + c.A11_5 * k5[j]
            + c.A11_6 * k6[j]
            + c.A11_7 * k7[j]
            + c.A11_8 * k8[j]
            + c.A11_9 * k9[j]
            + c.A11_10 * k10[j]
        )
    taken += slope(context, t + c.C11 * h, STAGE, K + 10)
    for j in range(length):
        z[j] = y0[j] + h * (
            c.A12_1 * k1[j]
            + c.A12_4 * k4[j]
            + c.A12_5 * k5[j]
            + c.A12_6 * k6[j]
            + c.A12_7 * k7[j]
            + c.A12_8 * k8[j]
            + c.A12_9 * k9[j]
            + c.A12_10 * k10[j]
            + c.A12_11 * k11[j]
        )
    taken += slope(context, t + h, STAGE, K + 11)
    for j in range(length):
        y1[j] = y0[j] + h * (
            c.B1 * k1[j]
            + c.B6 * k6[j]
            + c.B7 * k7[j]
            + c.B8 * k8[j]
            + c.B9 * k9[j]
            + c.B10 * k10[j]
            + c.B11 * k11[j]
            + c.B12 * k12[j]
        )
    return taken


@addressed(ERROR)
def error(context: Integers, h: float, rtol: float) -> float:
    """Estimated error of the step over its tolerance, root mean square over q and v."""
    length = 2 * context[COORDINATES]
    y0 = row_of(context, Y0)
    y1 = row_of(context, Y1)
    atol = row_of(context, ATOL)
    k1 = row_of(context, K)
    k6 = row_of(context, K + 5)
    k7 = row_of(context, K + 6)
    k8 = row_of(context, K + 7)
    k9 = row_of(context, K + 8)
    k10 = row_of(context, K + 9)
    k11 = row_of(context, K + 10)
    k12 = row_of(context, K + 11)
    fifth = 0.0
    third = 0.0
    for j in range(length):
        tolerance = atol[j] + rtol * max(abs(y0[j]), abs(y1[j]))
        sum5 = (
            c.E1 * k1[j]
            + c.E6 * k6[j]
            + c.E7 * k7[j]
            + c.E8 * k8[j]
            + c.E9 * k9[j]
            + c.E10 * k10[j]
            + c.E11 * k11[j]
            + c.E12 * k12[j]
        )
        sum3 = (
            c.B1 * k1[j]
            + c.B6 * k6[j]
            + c.B7 * k7[j]
            + c.B8 * k8[j]
            + c.B9 * k9[j]
            + c.B10 * k10[j]
            + c.B11 * k11[j]
            + c.B12 * k12[j]
            - c.H1 * k1[j]
            - c.H9 * k9[j]
            - c.H12 * k12[j]
        )
        ratio5 = sum5 / tolerance
        ratio3 = sum3 / tolerance
        fifth += ratio5 * ratio5
        third += ratio3 * ratio3
    both = fifth + 0.01 * third
    if both == 0.0:  # also where what is left of a velocity at rest is too small to be squared
        return 0.0
    return float(h * fifth / np.sqrt(both * length))


@addressed(DENSE)
def dense(context: Integers, t: float, h: float) -> int:
    """Fill the coefficient rows of the dense output of the step from Y0 to Y1."""
    length = 2 * context[COORDINATES]
    y0 = row_of(context, Y0)
    z = row_of(context, STAGE)
    k1 = row_of(context, K)
    k6 = row_of(context, K + 5)
    k7 = row_of(context, K + 6)
    k8 = row_of(context, K + 7)
    k9 = row_of(context, K + 8)
    k10 = row_of(context, K + 9)
    k11 = row_of(context, K + 10)
    k12 = row_of(context, K + 11)
    k13 = row_of(context, K + 12)
    k14 = row_of(context, K + 13)
    k15 = row_of(context, K + 14)
    k16 = row_of(context, K + 15)
    taken = 0
    for j in range(length):
        z[j] = y0[j] + h * (
            c.A14_1 * k1[j]
            + c.A14_7 * k7[j]
            + c.A14_8 * k8[j]
            + c.A14_9 * k9[j]
            + c.A14_10 * k10[j]
            + c.A14_11 * k11[j]
            + c.A14_12 * k12[j]
            + c.A14_13 * k13[j]
        )
    taken += slope(context, t + c.C14 * h, STAGE, K + 13)
    for j in range(length):
        z[j] = y0[j] + h * (
            c.A15_1 * k1[j]
            + c.A15_6 * k6[j]
            + c.A15_7 * k7[j]
            + c.A15_8 * k8[j]
            + c.A15_11 * k11[j]
            + c.A15_12 * k12[j]
            + c.A15_13 * k13[j]
            + c.A15_14 * k14[j]
        )
    taken += slope(context, t + c.C15 * h, STAGE, K + 14)
    for j in range(length):
        z[j] = y0[j] + h * (
            c.A16_1 * k1[j]
            + c.A16_6 * k6[j]
            + c.A16_7 * k7[j]
            + c.A16_8 * k8[j]
            + c.A16_9 * k9[j]
            + c.A16_13 * k13[j]
            + c.A16_14 * k14[j]
            + c.A16_15 * k15[j]
        )
    taken += slope(context, t + c.C16 * h, STAGE, K + 15)
    hermite_rows(context, h, K + LAST)
    f4 = row_of(context, F + 4)
    f5 = row_of(context, F + 5)
    f6 = row_of(context, F + 6)
    f7 = row_of(context, F + 7)
    for j in range(length):
        f4[j] = h * (
            c.D4_1 * k1[j]
            + c.D4_6 * k6[j]
            + c.D4_7 * k7[j]
            + c.D4_8 * k8[j]
            + c.D4_9 * k9[j]
            + c.D4_10 * k10[j]
            + c.D4_11 * k11[j]
            + c.D4_12 * k12[j]
            + c.D4_13 * k13[j]
            + c.D4_14 * k14[j]
            + c.D4_15 * k15[j]
            + c.D4_16 * k16[j]
        )
        f5[j] = h * (
            c.D5_1 * k1[j]
            + c.D5_6 * k6[j]
            + c.D5_7 * k7[j]
            + c.D5_8 * k8[j]
            + c.D5_9 * k9[j]
            + c.D5_10 * k10[j]
            + c.D5_11 * k11[j]
            + c.D5_12 * k12[j]
            + c.D5_13 * k13[j]
            + c.D5_14 * k14[j]
            + c.D5_15 * k15[j]
            + c.D5_16 * k16[j]
        )
        f6[j] = h * (
            c.D6_1 * k1[j]
            + c.D6_6 * k6[j]
            + c.D6_7 * k7[j]
            + c.D6_8 * k8[j]
            + c.D6_9 * k9[j]
            + c.D6_10 * k10[j]
            + c.D6_11 * k11[j]
            + c.D6_12 * k12[j]
            + c.D6_13 * k13[j]
            + c.D6_14 * k14[j]
            + c.D6_15 * k15[j]
            + c.D6_16 * k16[j]
        )
        f7[j] = h * (
            c.D7_1 * k1[j]
            + c.D7_6 * k6[j]
            + c.D7_7 * k7[j]
            + c.D7_8 * k8[j]
            + c.D7_9 * k9[j]
            + c.D7_10 * k10[j]
            + c.D7_11 * k11[j]
            + c.D7_12 * k12[j]
            + c.D7_13 * k13[j]
            + c.D7_14 * k14[j]
            + c.D7_15 * k15[j]
            + c.D7_16 * k16[j]
        )
    return taken
