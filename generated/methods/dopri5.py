# Generated from codegen/tableaus/dopri5.py.
# Do not edit: change the tableau, then run python -m codegen methods
"""Explicit Runge-Kutta method of order 5(4) with dense output of order 4.

The pair is J. R. Dormand and P. J. Prince's (A family of embedded Runge-Kutta formulae, Journal of
Computational and Applied Mathematics 6, 1980); the dense output, L. F. Shampine's (Some practical
Runge-Kutta formulas, Mathematics of Computation 46, 1986), and its constants are those of
E. Hairer, S. P. Nørsett and G. Wanner, Solving Ordinary Differential Equations I, section II.6.
k_7, the derivative at the end, is the first stage of the next step.

On the imaginary axis it is stable up to one radian a step, where its estimate of the error is less
than a thousandth: at looser tolerances accuracy alone does not keep a vibration from growing, and
`stability_limit` does.
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

EDGE = 0.0004  # accuracy: as the tableau says
POWERS = np.array([
    0.0016666666666666668, 0.008333333333333333, 0.041666666666666664, 0.16666666666666666, 0.5,
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
        z[j] = y0[j] + h * (0.2 * k1[j])
    taken += evaluate_rhs(context, t + 0.2 * h, ws.STAGE, ws.K + 1)
    for j in range(length):
        z[j] = y0[j] + h * (0.075 * k1[j] + 0.225 * k2[j])
    taken += evaluate_rhs(context, t + 0.3 * h, ws.STAGE, ws.K + 2)
    for j in range(length):
        z[j] = y0[j] + h * (
            0.9777777777777777 * k1[j] - 3.7333333333333334 * k2[j] + 3.5555555555555554 * k3[j]
        )
    taken += evaluate_rhs(context, t + 0.8 * h, ws.STAGE, ws.K + 3)
    for j in range(length):
        z[j] = y0[j] + h * (
            2.9525986892242035 * k1[j] - 11.595793324188385 * k2[j] + 9.822892851699436 * k3[j]
            - 0.2908093278463649 * k4[j]
        )
    taken += evaluate_rhs(context, t + 0.8888888888888888 * h, ws.STAGE, ws.K + 4)
    for j in range(length):
        z[j] = y0[j] + h * (
            2.8462752525252526 * k1[j] - 10.757575757575758 * k2[j] + 8.906422717743473 * k3[j]
            + 0.2784090909090909 * k4[j] - 0.2735313036020583 * k5[j]
        )
    taken += evaluate_rhs(context, t + h, ws.STAGE, ws.K + 5)
    for j in range(length):
        y1[j] = y0[j] + h * (
            0.09114583333333333 * k1[j] + 0.44923629829290207 * k3[j] + 0.6510416666666666 * k4[j]
            - 0.322376179245283 * k5[j] + 0.13095238095238096 * k6[j]
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
    k3 = ws.row_of(context, ws.K + 2)
    k4 = ws.row_of(context, ws.K + 3)
    k5 = ws.row_of(context, ws.K + 4)
    k6 = ws.row_of(context, ws.K + 5)
    k7 = ws.row_of(context, ws.K + 6)
    total = 0.0
    for j in range(length):
        estimate = h * (
            0.0012326388888888888 * k1[j] - 0.0042527702905061394 * k3[j]
            + 0.03697916666666667 * k4[j] - 0.05086379716981132 * k5[j] + 0.0419047619047619 * k6[j]
            - 0.025 * k7[j]
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
    k3 = ws.row_of(context, ws.K + 2)
    k4 = ws.row_of(context, ws.K + 3)
    k5 = ws.row_of(context, ws.K + 4)
    k6 = ws.row_of(context, ws.K + 5)
    k7 = ws.row_of(context, ws.K + 6)
    hermite_rows(context, h, ws.K + 6)
    f4 = ws.row_of(context, ws.F + 4)
    for j in range(length):
        f4[j] = h * (
            -1.1270175653862835 * k1[j] + 2.675424484351598 * k3[j] - 5.685526961588504 * k4[j]
            + 3.5219323679207912 * k5[j] - 1.7672812570757455 * k6[j] + 2.382468931778144 * k7[j]
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
    nodes=(0.0, 0.2, 0.3, 0.8, 0.8888888888888888, 1.0, 1.0),
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
