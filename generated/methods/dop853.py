# Generated from codegen/tableaus/dop853.py.
# Do not edit: change the tableau, then run python -m codegen methods
"""Explicit Runge-Kutta method of order 8(5,3) with dense output of order 7.

The method is J. R. Dormand and P. J. Prince's; the coefficients, the error estimate that joins one
of order 5 with one of order 3, and the dense output with its three further stages are those of
E. Hairer, S. P. Nørsett and G. Wanner, Solving Ordinary Differential Equations I, sections II.5 and
II.6, and of Hairer's program of the same name. Stage numbers count from 1, as there; stage 13 is
the derivative at the end of the step and the first of the next.
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
from runtime.integrate.step_control import propose


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
    k7 = ws.row_of(context, ws.K + 6)
    k8 = ws.row_of(context, ws.K + 7)
    k9 = ws.row_of(context, ws.K + 8)
    k10 = ws.row_of(context, ws.K + 9)
    k11 = ws.row_of(context, ws.K + 10)
    k12 = ws.row_of(context, ws.K + 11)
    taken = 0
    for j in range(length):
        z[j] = y0[j] + h * (0.05260015195876773 * k1[j])
    taken += evaluate_rhs(context, t + 0.05260015195876773 * h, ws.STAGE, ws.K + 1)
    for j in range(length):
        z[j] = y0[j] + h * (0.0197250569845379 * k1[j] + 0.0591751709536137 * k2[j])
    taken += evaluate_rhs(context, t + 0.0789002279381516 * h, ws.STAGE, ws.K + 2)
    for j in range(length):
        z[j] = y0[j] + h * (0.02958758547680685 * k1[j] + 0.08876275643042054 * k3[j])
    taken += evaluate_rhs(context, t + 0.1183503419072274 * h, ws.STAGE, ws.K + 3)
    for j in range(length):
        z[j] = y0[j] + h * (
            0.2413651341592667 * k1[j] - 0.8845494793282861 * k3[j] + 0.924834003261792 * k4[j]
        )
    taken += evaluate_rhs(context, t + 0.2816496580927726 * h, ws.STAGE, ws.K + 4)
    for j in range(length):
        z[j] = y0[j] + h * (
            0.037037037037037035 * k1[j] + 0.17082860872947386 * k4[j] + 0.12546768756682242 * k5[j]
        )
    taken += evaluate_rhs(context, t + 0.3333333333333333 * h, ws.STAGE, ws.K + 5)
    for j in range(length):
        z[j] = y0[j] + h * (
            0.037109375 * k1[j] + 0.17025221101954405 * k4[j] + 0.06021653898045596 * k5[j]
            - 0.017578125 * k6[j]
        )
    taken += evaluate_rhs(context, t + 0.25 * h, ws.STAGE, ws.K + 6)
    for j in range(length):
        z[j] = y0[j] + h * (
            0.03709200011850479 * k1[j] + 0.17038392571223998 * k4[j] + 0.10726203044637328 * k5[j]
            - 0.015319437748624402 * k6[j] + 0.008273789163814023 * k7[j]
        )
    taken += evaluate_rhs(context, t + 0.3076923076923077 * h, ws.STAGE, ws.K + 7)
    for j in range(length):
        z[j] = y0[j] + h * (
            0.6241109587160757 * k1[j] - 3.3608926294469414 * k4[j] - 0.868219346841726 * k5[j]
            + 27.59209969944671 * k6[j] + 20.154067550477894 * k7[j] - 43.48988418106996 * k8[j]
        )
    taken += evaluate_rhs(context, t + 0.6512820512820513 * h, ws.STAGE, ws.K + 8)
    for j in range(length):
        z[j] = y0[j] + h * (
            0.47766253643826434 * k1[j] - 2.4881146199716677 * k4[j] - 0.590290826836843 * k5[j]
            + 21.230051448181193 * k6[j] + 15.279233632882423 * k7[j] - 33.28821096898486 * k8[j]
            - 0.020331201708508627 * k9[j]
        )
    taken += evaluate_rhs(context, t + 0.6 * h, ws.STAGE, ws.K + 9)
    for j in range(length):
        z[j] = y0[j] + h * (
            -0.9371424300859873 * k1[j] + 5.186372428844064 * k4[j] + 1.0914373489967295 * k5[j]
            - 8.149787010746927 * k6[j] - 18.52006565999696 * k7[j] + 22.739487099350505 * k8[j]
            + 2.4936055526796523 * k9[j] - 3.0467644718982196 * k10[j]
        )
    taken += evaluate_rhs(context, t + 0.8571428571428571 * h, ws.STAGE, ws.K + 10)
    for j in range(length):
        z[j] = y0[j] + h * (
            2.273310147516538 * k1[j] - 10.53449546673725 * k4[j] - 2.0008720582248625 * k5[j]
            - 17.9589318631188 * k6[j] + 27.94888452941996 * k7[j] - 2.8589982771350235 * k8[j]
            - 8.87285693353063 * k9[j] + 12.360567175794303 * k10[j] + 0.6433927460157636 * k11[j]
        )
    taken += evaluate_rhs(context, t + h, ws.STAGE, ws.K + 11)
    for j in range(length):
        y1[j] = y0[j] + h * (
            0.054293734116568765 * k1[j] + 4.450312892752409 * k6[j] + 1.8915178993145003 * k7[j]
            - 5.801203960010585 * k8[j] + 0.3111643669578199 * k9[j] - 0.1521609496625161 * k10[j]
            + 0.20136540080403034 * k11[j] + 0.04471061572777259 * k12[j]
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
    k6 = ws.row_of(context, ws.K + 5)
    k7 = ws.row_of(context, ws.K + 6)
    k8 = ws.row_of(context, ws.K + 7)
    k9 = ws.row_of(context, ws.K + 8)
    k10 = ws.row_of(context, ws.K + 9)
    k11 = ws.row_of(context, ws.K + 10)
    k12 = ws.row_of(context, ws.K + 11)
    high, low = 0.0, 0.0
    for j in range(length):
        inverse = 1.0 / (atol[j] + rtol * max(abs(y0[j]), abs(y1[j])))
        ratio = inverse * (
            0.01312004499419488 * k1[j] - 1.2251564463762044 * k6[j] - 0.4957589496572502 * k7[j]
            + 1.6643771824549864 * k8[j] - 0.35032884874997366 * k9[j] + 0.3341791187130175 * k10[j]
            + 0.08192320648511571 * k11[j] - 0.022355307863886294 * k12[j]
        )
        high += ratio * ratio
        ratio = inverse * (
            -0.18980075407240762 * k1[j] + 4.450312892752409 * k6[j] + 1.8915178993145003 * k7[j]
            - 5.801203960010585 * k8[j] - 0.42268232132379197 * k9[j] - 0.1521609496625161 * k10[j]
            + 0.20136540080403034 * k11[j] + 0.022651792198360825 * k12[j]
        )
        low += ratio * ratio
    both = high + 0.01 * low
    if both == 0.0:  # also where a ratio is too small to be squared
        return 0.0
    return float(h * high / np.sqrt(both * length))


@addressed(ft.DENSE)
def dense(context: Integers, t: float, h: float) -> int:
    """Fill the coefficient rows of the dense output of the step from Y0 to Y1."""
    length = 2 * context[ft.COORDINATES]
    y0 = ws.row_of(context, ws.Y0)
    z = ws.row_of(context, ws.STAGE)
    k1 = ws.row_of(context, ws.K)
    k6 = ws.row_of(context, ws.K + 5)
    k7 = ws.row_of(context, ws.K + 6)
    k8 = ws.row_of(context, ws.K + 7)
    k9 = ws.row_of(context, ws.K + 8)
    k10 = ws.row_of(context, ws.K + 9)
    k11 = ws.row_of(context, ws.K + 10)
    k12 = ws.row_of(context, ws.K + 11)
    k13 = ws.row_of(context, ws.K + 12)
    k14 = ws.row_of(context, ws.K + 13)
    k15 = ws.row_of(context, ws.K + 14)
    k16 = ws.row_of(context, ws.K + 15)
    taken = 0
    for j in range(length):
        z[j] = y0[j] + h * (
            0.056167502283047954 * k1[j] + 0.25350021021662483 * k7[j] - 0.2462390374708025 * k8[j]
            - 0.12419142326381637 * k9[j] + 0.15329179827876568 * k10[j]
            + 0.00820105229563469 * k11[j] + 0.007567897660545699 * k12[j] - 0.008298 * k13[j]
        )
    taken += evaluate_rhs(context, t + 0.1 * h, ws.STAGE, ws.K + 13)
    for j in range(length):
        z[j] = y0[j] + h * (
            0.03183464816350214 * k1[j] + 0.028300909672366776 * k6[j]
            + 0.053541988307438566 * k7[j] - 0.05492374857139099 * k8[j]
            - 0.00010834732869724932 * k11[j] + 0.0003825710908356584 * k12[j]
            - 0.00034046500868740456 * k13[j] + 0.1413124436746325 * k14[j]
        )
    taken += evaluate_rhs(context, t + 0.2 * h, ws.STAGE, ws.K + 14)
    for j in range(length):
        z[j] = y0[j] + h * (
            -0.42889630158379194 * k1[j] - 4.697621415361164 * k6[j] + 7.683421196062599 * k7[j]
            + 4.06898981839711 * k8[j] + 0.3567271874552811 * k9[j] - 0.0013990241651590145 * k13[j]
            + 2.9475147891527724 * k14[j] - 9.15095847217987 * k15[j]
        )
    taken += evaluate_rhs(context, t + 0.7777777777777778 * h, ws.STAGE, ws.K + 15)
    hermite_rows(context, h, ws.K + 12)
    f4 = ws.row_of(context, ws.F + 4)
    f5 = ws.row_of(context, ws.F + 5)
    f6 = ws.row_of(context, ws.F + 6)
    f7 = ws.row_of(context, ws.F + 7)
    for j in range(length):
        f4[j] = h * (
            -8.428938276109013 * k1[j] + 0.5667149535193777 * k6[j] - 3.0689499459498917 * k7[j]
            + 2.38466765651207 * k8[j] + 2.117034582445028 * k9[j] - 0.871391583777973 * k10[j]
            + 2.2404374302607883 * k11[j] + 0.6315787787694688 * k12[j]
            - 0.08899033645133331 * k13[j] + 18.148505520854727 * k14[j]
            - 9.194632392478356 * k15[j] - 4.436036387594894 * k16[j]
        )
        f5[j] = h * (
            10.427508642579134 * k1[j] + 242.28349177525817 * k6[j] + 165.20045171727028 * k7[j]
            - 374.5467547226902 * k8[j] - 22.113666853125306 * k9[j] + 7.733432668472264 * k10[j]
            - 30.674084731089398 * k11[j] - 9.332130526430229 * k12[j] + 15.697238121770845 * k13[j]
            - 31.139403219565178 * k14[j] - 9.35292435884448 * k15[j] + 35.81684148639408 * k16[j]
        )
        f6[j] = h * (
            19.985053242002433 * k1[j] - 387.0373087493518 * k6[j] - 189.17813819516758 * k7[j]
            + 527.8081592054236 * k8[j] - 11.57390253995963 * k9[j] + 6.8812326946963 * k10[j]
            - 1.0006050966910838 * k11[j] + 0.7777137798053443 * k12[j] - 2.778205752353508 * k13[j]
            - 60.19669523126412 * k14[j] + 84.32040550667716 * k15[j] + 11.99229113618279 * k16[j]
        )
        f7[j] = h * (
            -25.69393346270375 * k1[j] - 154.18974869023643 * k6[j] - 231.5293791760455 * k7[j]
            + 357.6391179106141 * k8[j] + 93.40532418362432 * k9[j] - 37.45832313645163 * k10[j]
            + 104.0996495089623 * k11[j] + 29.8402934266605 * k12[j] - 43.53345659001114 * k13[j]
            + 96.32455395918828 * k14[j] - 39.17726167561544 * k15[j] - 149.72683625798564 * k16[j]
        )
    return taken


METHOD = Method(
    estimate_order=8,
    stage_calls=11,
    last=12,
    dense_rows=8,
    dense_calls=3,
    nodes=(
        0.0, 0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726,
        0.3333333333333333, 0.25, 0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571,
        1.0, 1.0, 0.1, 0.2, 0.7777777777777778
    ),
    beta=0.04,
    safety=0.88,
    shrink=0.333,
    grow=6.0,
    stages=stages,
    error=error,
    dense=dense,
    propose=propose,
    accepted=stability_limit.idle,
    restart=stability_limit.idle,
)
