# Generated from codegen/tableaus/tsit5.py.
# Do not edit: change the tableau, then run python -m codegen methods
"""Explicit Runge-Kutta method of order 5(4) with dense output of order 4.

The pair and its dense output are Ch. Tsitouras's (Runge-Kutta pairs of order 5(4) satisfying only
the first column simplifying assumption, Computers & Mathematics with Applications 62, 2011). k_7,
the derivative at the end, is the first stage of the next step. At equal cost its errors are as
large as those of dopri5, or smaller by up to a factor of seven at tight tolerances.

On the imaginary axis it is stable up to half a radian a step only, and hardly unstable up to one:
at loose tolerances `stability_limit` keeps vibrations within that half, and the steps of dopri5,
stable up to one radian, are longer.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Integers
from runtime.core.dense_output import hermite_rows
from runtime.core.jit import addressed
from runtime.core.state_derivative import evaluate_rhs
from runtime.integrate import stability_limit
from runtime.integrate.method import Method

EDGE = 5e-06  # accuracy: as the tableau says
POWERS = np.array([
    0.0014322113248073478, 0.008333333333333333, 0.041666666666666664, 0.16666666666666666, 0.5,
    1.0, 1.0
])


@addressed(ft.STAGES)
def stages(context: Integers, t: float, h: float) -> int:
    """Take the step from Y0 with derivative K to Y1, not yet corrected."""
    length = 2 * context[ft.COORDINATES]
    y0 = ws.row_of(context, ws.Y0)
    y1 = ws.row_of(context, ws.Y1)
    z = ws.row_of(context, ws.STAGE)
    k1 = ws.row_of(context, ws.K)
    k2 = ws.row_of(context, ws.K + 1)
    k3 = ws.row_of(context, ws.K + 2)
    k4 = ws.row_of(context, ws.K + 3)
    k5 = ws.row_of(context, ws.K + 4)
    k6 = ws.row_of(context, ws.K + 5)
    taken = 0
    for j in range(length):
        z[j] = y0[j] + h * (0.161 * k1[j])
    taken += evaluate_rhs(context, t + 0.161 * h, ws.STAGE, ws.K + 1)
    for j in range(length):
        z[j] = y0[j] + h * (-0.008480655492356989 * k1[j] + 0.335480655492357 * k2[j])
    taken += evaluate_rhs(context, t + 0.327 * h, ws.STAGE, ws.K + 2)
    for j in range(length):
        z[j] = y0[j] + h * (
            2.8971530571054935 * k1[j] - 6.359448489975075 * k2[j] + 4.3622954328695815 * k3[j]
        )
    taken += evaluate_rhs(context, t + 0.9 * h, ws.STAGE, ws.K + 3)
    for j in range(length):
        z[j] = y0[j] + h * (
            5.325864828439257 * k1[j] - 11.748883564062828 * k2[j] + 7.4955393428898365 * k3[j]
            - 0.09249506636175525 * k4[j]
        )
    taken += evaluate_rhs(context, t + 0.9800255409045097 * h, ws.STAGE, ws.K + 4)
    for j in range(length):
        z[j] = y0[j] + h * (
            5.86145544294642 * k1[j] - 12.92096931784711 * k2[j] + 8.159367898576159 * k3[j]
            - 0.071584973281401 * k4[j] - 0.028269050394068383 * k5[j]
        )
    taken += evaluate_rhs(context, t + h, ws.STAGE, ws.K + 5)
    for j in range(length):
        y1[j] = y0[j] + h * (
            0.09646076681806523 * k1[j] + 0.01 * k2[j] + 0.4798896504144996 * k3[j]
            + 1.379008574103742 * k4[j] - 3.290069515436081 * k5[j] + 2.324710524099774 * k6[j]
        )
    return taken


@addressed(ft.ERROR)
def error(context: Integers, h: float, rtol: float) -> float:
    """Estimated error of the step over its tolerance, root mean square over q and v."""
    length = 2 * context[ft.COORDINATES]
    y0 = ws.row_of(context, ws.Y0)
    y1 = ws.row_of(context, ws.Y1)
    atol = ws.row_of(context, ws.ATOL)
    k1 = ws.row_of(context, ws.K)
    k2 = ws.row_of(context, ws.K + 1)
    k3 = ws.row_of(context, ws.K + 2)
    k4 = ws.row_of(context, ws.K + 3)
    k5 = ws.row_of(context, ws.K + 4)
    k6 = ws.row_of(context, ws.K + 5)
    k7 = ws.row_of(context, ws.K + 6)
    total = 0.0
    for j in range(length):
        estimate = h * (
            0.0017800110522257714 * k1[j] + 0.0008164344596567469 * k2[j]
            - 0.007880878010261995 * k3[j] + 0.1447110071732629 * k4[j] - 0.5823571654525552 * k5[j]
            + 0.45808210592918697 * k6[j] - 0.015151515151515152 * k7[j]
        )
        ratio = estimate / (atol[j] + rtol * max(abs(y0[j]), abs(y1[j])))
        total += ratio * ratio
    if stability_limit.permits_growth(rtol, length, EDGE):
        stability_limit.observe(context, ws.K + 6)
    return float(np.sqrt(total / length))


@addressed(ft.DENSE)
def dense(context: Integers, t: float, h: float) -> int:
    """Fill the coefficient rows of the dense output of the step from Y0 to Y1."""
    length = 2 * context[ft.COORDINATES]
    k1 = ws.row_of(context, ws.K)
    k2 = ws.row_of(context, ws.K + 1)
    k3 = ws.row_of(context, ws.K + 2)
    k4 = ws.row_of(context, ws.K + 3)
    k5 = ws.row_of(context, ws.K + 4)
    k6 = ws.row_of(context, ws.K + 5)
    k7 = ws.row_of(context, ws.K + 6)
    hermite_rows(context, h, ws.K + 6)
    f4 = ws.row_of(context, ws.F + 4)
    for j in range(length):
        f4[j] = h * (
            -1.0530884977290216 * k1[j] + 0.1017 * k2[j] + 2.490627285651253 * k3[j]
            - 16.548102889244902 * k4[j] + 47.37952196281928 * k5[j] - 34.87065786149661 * k6[j]
            + 2.5 * k7[j]
        )
    return 0


@addressed(ft.PROPOSE)
def propose(context: Integers, h: float) -> float:
    """Ratio of the next step's length to this accepted one's."""
    return float(stability_limit.stable_ratio(context, h, POWERS, EDGE))


METHOD = Method(
    estimate_order=5,
    stage_calls=5,
    last=6,
    dense_rows=5,
    dense_calls=0,
    nodes=(0.0, 0.161, 0.327, 0.9, 0.9800255409045097, 1.0, 1.0),
    beta=0.04,
    safety=0.9,
    shrink=0.2,
    grow=10.0,
    stages=stages,
    error=error,
    dense=dense,
    propose=propose,
    accepted=stability_limit.idle,
    restart=stability_limit.restart,
    memory=stability_limit.memory,
)
