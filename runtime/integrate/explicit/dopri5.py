"""Explicit Runge-Kutta method of order 5(4) with dense output of order 4.

The pair is J. R. Dormand and P. J. Prince's (A family of embedded Runge-Kutta formulae, Journal of
Computational and Applied Mathematics 6, 1980); the dense output and its constants are those of
E. Hairer, S. P. Nørsett and G. Wanner, Solving Ordinary Differential Equations I, section II.6.
The last stage is the first of the next step.

On the imaginary axis it is stable up to one radian a step, where its estimate of the error is less
than a thousandth: at looser tolerances accuracy alone does not keep a vibration from growing, and
`vibration` does.
"""

import numpy as np

from runtime.core.dense_output import hermite_rows
from runtime.core.function_table import COORDINATES, DENSE, ERROR, HOOK, PROPOSE, STAGES, memory_of
from runtime.core.jit import addressed, compiled, inner
from runtime.core.rhs import slope
from runtime.core.run_record import run_record
from runtime.core.signatures import Integers
from runtime.core.workspace import ATOL, STAGE, Y0, Y1, F, K, row_of
from runtime.integrate import step_control as control
from runtime.integrate.explicit.stability_limit import FLOATS, bounded, forget, observe
from runtime.integrate.explicit.stateless import accepted

__all__ = ["accepted", "dense", "error", "memory", "propose", "restart", "stages"]

ORDER = 5
ERROR_ORDER = 4
STAGE_CALLS = 5  # calls of accelerations in `stages`
LAST = 6  # row, after K, of the derivative at the end of the step
DENSE_ROWS = 5
DENSE_CALLS = 0
BETA, SAFETY = 0.04, 0.9  # step control: proportional part, share of what the error permits
SHRINK, GROW = 0.2, 10.0  # limits of the change of a step's length

C2, C3, C4, C5 = 1 / 5, 3 / 10, 4 / 5, 8 / 9
NODES = (0.0, C2, C3, C4, C5, 1.0)  # where in a step the equations are evaluated
A21 = 1 / 5
A31, A32 = 3 / 40, 9 / 40
A41, A42, A43 = 44 / 45, -56 / 15, 32 / 9
A51, A52, A53, A54 = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
A61, A62, A63, A64, A65 = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
B1, B3, B4, B5, B6 = 35 / 384, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
E1, E3, E4 = 71 / 57600, -71 / 16695, 71 / 1920
E5, E6, E7 = -17253 / 339200, 22 / 525, -1 / 40
D1, D3 = -12715105075 / 11282082432, 87487479700 / 32700410799
D4, D5 = -10690763975 / 1880347072, 701980252875 / 199316789632
D6, D7 = -1453857185 / 822651844, 69997945 / 29380423

_propose = control.propose
_POWERS = np.array([1 / 600, 1 / 120, 1 / 24, 1 / 6, 1 / 2, 1.0, 1.0])  # of R(z), z⁶ first
# Half the estimate of the error of a vibration at the edge of stability, over its amplitude. Where
# a tolerance is less than that, with its absolute part as much again, no vibration grows.
_EDGE = 4e-4


def memory(n: int) -> tuple[int, int]:
    """Numbers that are kept for n coordinates: floats and integers."""
    return FLOATS, 0


@inner
def loose(rtol: float, length: int) -> bool:
    """Whether the error permits steps beyond the edge to one vibrating velocity among all."""
    return bool(rtol * np.sqrt(length) > _EDGE)


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
    taken = 0
    for j in range(length):
        z[j] = y0[j] + h * A21 * k1[j]
    taken += slope(context, t + C2 * h, STAGE, K + 1)
    for j in range(length):
        z[j] = y0[j] + h * (A31 * k1[j] + A32 * k2[j])
    taken += slope(context, t + C3 * h, STAGE, K + 2)
    for j in range(length):
        z[j] = y0[j] + h * (A41 * k1[j] + A42 * k2[j] + A43 * k3[j])
    taken += slope(context, t + C4 * h, STAGE, K + 3)
    for j in range(length):
        z[j] = y0[j] + h * (A51 * k1[j] + A52 * k2[j] + A53 * k3[j] + A54 * k4[j])
    taken += slope(context, t + C5 * h, STAGE, K + 4)
    for j in range(length):
        z[j] = y0[j] + h * (A61 * k1[j] + A62 * k2[j] + A63 * k3[j] + A64 * k4[j] + A65 * k5[j])
    taken += slope(context, t + h, STAGE, K + 5)
    for j in range(length):
        y1[j] = y0[j] + h * (B1 * k1[j] + B3 * k3[j] + B4 * k4[j] + B5 * k5[j] + B6 * k6[j])
    return taken


@addressed(ERROR)
def error(context: Integers, h: float, rtol: float) -> float:
    """Estimated error of the step over its tolerance, root mean square over q and v."""
    length = 2 * context[COORDINATES]
    y0 = row_of(context, Y0)
    y1 = row_of(context, Y1)
    atol = row_of(context, ATOL)
    k1 = row_of(context, K)
    k3 = row_of(context, K + 2)
    k4 = row_of(context, K + 3)
    k5 = row_of(context, K + 4)
    k6 = row_of(context, K + 5)
    k7 = row_of(context, K + 6)
    total = 0.0
    for j in range(length):
        estimate = h * (E1 * k1[j] + E3 * k3[j] + E4 * k4[j] + E5 * k5[j] + E6 * k6[j] + E7 * k7[j])
        ratio = estimate / (atol[j] + rtol * max(abs(y0[j]), abs(y1[j])))
        total += ratio * ratio
    if loose(rtol, length):
        observe(context, memory_of(context), Y1, STAGE, K + LAST, K + LAST - 1)
    return float(np.sqrt(total / length))


@addressed(PROPOSE)
def propose(context: Integers, h: float) -> float:
    """Ratio of the next step's length to this accepted one's."""
    ratio = _propose(context, h)
    if not loose(run_record(context).rtol, 2 * context[COORDINATES]):
        return float(ratio)
    return float(bounded(memory_of(context), _POWERS, ratio * h) / h)


@compiled(HOOK)
def restart(context: Integers, t: float, h: float) -> int:
    """Forget what vibrated: the motion goes on under other equations."""
    return int(forget(memory_of(context)))


@addressed(DENSE)
def dense(context: Integers, t: float, h: float) -> int:
    """Fill the coefficient rows of the dense output of the step from Y0 to Y1."""
    length = 2 * context[COORDINATES]
    k1 = row_of(context, K)
    k3 = row_of(context, K + 2)
    k4 = row_of(context, K + 3)
    k5 = row_of(context, K + 4)
    k6 = row_of(context, K + 5)
    k7 = row_of(context, K + 6)
    f4 = row_of(context, F + 4)
    hermite_rows(context, h, K + LAST)
    for j in range(length):
        f4[j] = h * (D1 * k1[j] + D3 * k3[j] + D4 * k4[j] + D5 * k5[j] + D6 * k6[j] + D7 * k7[j])
    return 0
