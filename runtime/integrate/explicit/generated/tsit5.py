# Generated from codegen/tableaus/tsit5.py.
# Do not edit: change the tableau, then run python -m codegen methods
"""Explicit Runge-Kutta method of order 5(4) with dense output of order 4.

The pair and its dense output are Ch. Tsitouras's (Runge-Kutta pairs of order 5(4) satisfying only
the first column simplifying assumption, Computers & Mathematics with Applications 62, 2011).
"""

import numpy as np

from runtime.core.array_views import view
from runtime.core.dense_output import hermite_rows
from runtime.core.jit import addressed
from runtime.core.rhs import slope
from runtime.core.signatures import DENSE, ERROR, PROPOSE, STAGES, Integers, Vector
from runtime.core.workspace import ATOL, ROWS, STAGE, Y0, Y1, F, K, Run
from runtime.integrate.explicit.stability_limit import memory, observe, restart, stable_ratio
from runtime.integrate.explicit.stateless import accepted
from runtime.integrate.method import Method

EDGE = 5e-06  # accuracy: as the tableau says
POWERS = np.array([
    0.0014322113248073478, 0.008333333333333333, 0.041666666666666664, 0.16666666666666666, 0.5,
    1.0, 1.0
])


@addressed(STAGES)
def stages(
    machine: Integers, t: float, h: float, w: Vector, run: Run, p: Vector, modes: Integers,
    lam: Vector
) -> int:
    """Take the step from Y0 with derivative K to Y1, not yet corrected."""
    length = w.size // ROWS
    y0 = view(w, Y0 * length, length)
    y1 = view(w, Y1 * length, length)
    z = view(w, STAGE * length, length)
    k1 = view(w, K * length, length)
    k2 = view(w, (K + 1) * length, length)
    k3 = view(w, (K + 2) * length, length)
    k4 = view(w, (K + 3) * length, length)
    k5 = view(w, (K + 4) * length, length)
    k6 = view(w, (K + 5) * length, length)
    taken = 0
    for j in range(length):
        z[j] = y0[j] + h * (0.161 * k1[j])
    taken += slope(machine, t + 0.161 * h, STAGE, K + 1, w, p, modes, lam)
    for j in range(length):
        z[j] = y0[j] + h * (-0.008480655492356989 * k1[j] + 0.335480655492357 * k2[j])
    taken += slope(machine, t + 0.327 * h, STAGE, K + 2, w, p, modes, lam)
    for j in range(length):
        z[j] = y0[j] + h * (
            2.8971530571054935 * k1[j] - 6.359448489975075 * k2[j] + 4.3622954328695815 * k3[j]
        )
    taken += slope(machine, t + 0.9 * h, STAGE, K + 3, w, p, modes, lam)
    for j in range(length):
        z[j] = y0[j] + h * (
            5.325864828439257 * k1[j] - 11.748883564062828 * k2[j] + 7.4955393428898365 * k3[j]
            - 0.09249506636175525 * k4[j]
        )
    taken += slope(machine, t + 0.9800255409045097 * h, STAGE, K + 4, w, p, modes, lam)
    for j in range(length):
        z[j] = y0[j] + h * (
            5.86145544294642 * k1[j] - 12.92096931784711 * k2[j] + 8.159367898576159 * k3[j]
            - 0.071584973281401 * k4[j] - 0.028269050394068383 * k5[j]
        )
    taken += slope(machine, t + h, STAGE, K + 5, w, p, modes, lam)
    for j in range(length):
        y1[j] = y0[j] + h * (
            0.09646076681806523 * k1[j] + 0.01 * k2[j] + 0.4798896504144996 * k3[j]
            + 1.379008574103742 * k4[j] - 3.290069515436081 * k5[j] + 2.324710524099774 * k6[j]
        )
    return taken


@addressed(ERROR)
def error(machine: Integers, h: float, rtol: float, w: Vector) -> float:
    """Estimated error of the step over its tolerance, root mean square over q and v."""
    length = w.size // ROWS
    y0 = view(w, Y0 * length, length)
    y1 = view(w, Y1 * length, length)
    atol = view(w, ATOL * length, length)
    k1 = view(w, K * length, length)
    k2 = view(w, (K + 1) * length, length)
    k3 = view(w, (K + 2) * length, length)
    k4 = view(w, (K + 3) * length, length)
    k5 = view(w, (K + 4) * length, length)
    k6 = view(w, (K + 5) * length, length)
    k7 = view(w, (K + 6) * length, length)
    total = 0.0
    for j in range(length):
        estimate = h * (
            0.0017800110522257714 * k1[j] + 0.0008164344596567469 * k2[j]
            - 0.007880878010261995 * k3[j] + 0.1447110071732629 * k4[j] - 0.5823571654525552 * k5[j]
            + 0.45808210592918697 * k6[j] - 0.015151515151515152 * k7[j]
        )
        ratio = estimate / (atol[j] + rtol * max(abs(y0[j]), abs(y1[j])))
        total += ratio * ratio
    observe(machine, rtol, w, EDGE, K + 6)
    return float(np.sqrt(total / length))


@addressed(DENSE)
def dense(
    machine: Integers, t: float, h: float, w: Vector, p: Vector, modes: Integers, lam: Vector
) -> int:
    """Fill the coefficient rows of the dense output of the step from Y0 to Y1."""
    length = w.size // ROWS
    k1 = view(w, K * length, length)
    k2 = view(w, (K + 1) * length, length)
    k3 = view(w, (K + 2) * length, length)
    k4 = view(w, (K + 3) * length, length)
    k5 = view(w, (K + 4) * length, length)
    k6 = view(w, (K + 5) * length, length)
    k7 = view(w, (K + 6) * length, length)
    hermite_rows(h, w, K + 6)
    f4 = view(w, (F + 4) * length, length)
    for j in range(length):
        f4[j] = h * (
            -1.0530884977290216 * k1[j] + 0.1017 * k2[j] + 2.490627285651253 * k3[j]
            - 16.548102889244902 * k4[j] + 47.37952196281928 * k5[j] - 34.87065786149661 * k6[j]
            + 2.5 * k7[j]
        )
    return 0


@addressed(PROPOSE)
def propose(machine: Integers, h: float, w: Vector, run: Run) -> float:
    """Ratio of the next step's length to this accepted one's."""
    return float(stable_ratio(machine, h, w, run, POWERS, EDGE))


METHOD = Method(
    order=5,
    error_order=4,
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
    accepted=accepted,
    restart=restart,
    memory=memory,
)
