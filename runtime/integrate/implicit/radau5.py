"""Radau IIA method of order 5 with exact derivatives, for the independent coordinates.

Formulas, transformation, error estimate and step control are those of E. Hairer and G. Wanner,
Solving Ordinary Differential Equations II, section IV.8. With the transformation of the three
stages Newton's method needs one real and one complex matrix, of order f each (see `reduction`): the
positions of the stages are linear in their velocities, hold exactly at every iterate, and leave
only the equation of the accelerations.

The estimate is of order h⁴ and the error of order h⁶, so that an estimate which is kept at the
tolerance gives errors that shrink faster than it. As in Hairer's program the tolerance is
therefore mapped: what the estimate is held to is `share` times what was asked.
"""

from runtime.constraints.newton_return import FAILED
from runtime.core.array_types import Integers
from runtime.core.dense_output import hermite_rows
from runtime.core.function_table import (
    COORDINATES,
    DENSE,
    ERROR,
    HOOK,
    PROPOSE,
    STAGES,
    method_floats_of,
    method_integers_of,
)
from runtime.core.jit import addressed, compiled, inner
from runtime.core.rounding import EPS
from runtime.core.run_record import run_record
from runtime.core.workspace import Y0, Y1, F, K, row_of
from runtime.integrate.implicit.method_memory import (
    C_FACTORED,
    CURRENT,
    ENOUGH,
    EQUAL,
    ERROR_BASE,
    H_BASE,
    ITERATIONS,
    LOW,
    RATE,
    STEP_ERROR,
    line,
    memory,
)
from runtime.integrate.implicit.newton_matrices import factor_complex, factor_real, tolerate
from runtime.integrate.implicit.radau5_coefficients import (
    C_COMPLEX,
    C_IMAGINARY,
    C_REAL,
)
from runtime.integrate.implicit.radau5_error import LAST, estimate
from runtime.integrate.implicit.radau5_stages import (
    MOST_ITERATIONS,
    NEWTON,
    POLYNOMIAL,
    STATES,
    curve,
    foresee,
    keep_low,
    newton,
)
from runtime.integrate.implicit.state_space_form import differentiate, unknowns
from runtime.integrate.implicit.stiffness_estimate import calm, stiffness
from runtime.integrate.method import Method

DENSE_ROWS = 6
_SAME = 1.2  # measured: a step that could grow by less keeps its length, and its matrices
# measured: h² |G_u| + h |G_u̇| up to which end accelerations add a sixth of their error
_SMOOTH = 10.0


@inner
def share(rtol: float) -> float:
    """What the estimate is held to, over the tolerance asked: errors of a run go with h⁵."""
    return float(0.1 * rtol**-0.2)


@addressed(STAGES)
def stages(context: Integers, t: float, h: float) -> int:
    """Take the step from Y0 to Y1, of which the dependent half is not yet corrected."""
    r = run_record(context)
    n = context[COORDINATES]
    length = 2 * n
    memory, notes = method_floats_of(context), method_integers_of(context)
    unknowns(context)
    for _ in range(2):
        foresee(context, h)
        last = row_of(context, K + STATES + 2)
        memory[ENOUGH] = tolerate(
            context, share(r.rtol) * r.rtol, r.rtol, NEWTON, 0, h * C_REAL, last
        )
        fresh = notes[CURRENT] != 1
        if fresh:
            differentiate(context, t, Y0)
        if memory[C_FACTORED] != h:
            memory[RATE] = 1.0
            memory[C_FACTORED] = h
            r.factorizations += 1
            singular = factor_real(context, n, h * C_REAL)
            singular += factor_complex(context, n, h * C_COMPLEX, h * C_IMAGINARY)
            if singular != 0:
                notes[CURRENT] = 0
                return FAILED
        taken = newton(context, t, h)
        if taken != FAILED:
            y1 = row_of(context, Y1)
            for i in range(length):
                y1[i] = last[i]
            memory[STEP_ERROR] = estimate(context, t, h)
            return taken
        notes[CURRENT] = 0
        if fresh:
            return FAILED
    return FAILED


@addressed(ERROR)
def error(context: Integers, h: float, rtol: float) -> float:
    """Estimated error of the step over its tolerance, root mean square over q and v."""
    return float(method_floats_of(context)[STEP_ERROR])


@addressed(PROPOSE)
def propose(context: Integers, h: float) -> float:
    """Ratio of the next step's length to this accepted one's.

    The predictive controller of K. Gustafsson; a step that could grow by little keeps its length,
    and with it the factored matrices.
    """
    r = run_record(context)
    memory, notes = method_floats_of(context), method_integers_of(context)
    now = max(r.error, 1e-10)
    ratio = now**-0.25
    if notes[EQUAL] > 0:
        predicted = h / memory[H_BASE] * (memory[ERROR_BASE] / now) ** 0.25 * ratio
        ratio = min(ratio, predicted)
    ratio *= r.safety * (2 * MOST_ITERATIONS + 1) / (2 * MOST_ITERATIONS + notes[ITERATIONS])
    if r.rejected_before != 0:
        ratio = min(ratio, 1.0)
    if 1.0 <= ratio <= _SAME:
        return 1.0
    return float(max(r.shrink, min(r.grow, ratio)))


@compiled(HOOK)
def accepted(context: Integers, t: float, h: float) -> int:
    """Keep the step's polynomial, from which the next one's stages are foreseen."""
    y1 = row_of(context, Y1)
    y0 = row_of(context, Y0)
    n = context[COORDINATES]
    length = 2 * n
    memory, notes = method_floats_of(context), method_integers_of(context)
    keep_low(context, h)
    change = line(memory, POLYNOMIAL, n)
    for i in range(length):
        change[i] = y1[i] - y0[i]
    curve(context, line(memory, POLYNOMIAL + 1, n), line(memory, POLYNOMIAL + 2, n))
    memory[H_BASE] = h
    memory[ERROR_BASE] = max(1e-2, run_record(context).error)
    notes[EQUAL] += 1
    return int(calm(context, h))


@compiled(HOOK)
def restart(context: Integers, t: float, h: float) -> int:
    """Forget the past: the motion goes on under other equations."""
    length = 2 * context[COORDINATES]
    notes = method_integers_of(context)
    low = line(method_floats_of(context), LOW, length // 2)
    for j in range(length):
        low[j] = 0.0
    notes[EQUAL] = 0
    notes[CURRENT] = 0
    return 0


@addressed(DENSE)
def dense(context: Integers, t: float, h: float) -> int:
    """Fill the coefficient rows of the dense output of the step from Y0 to Y1.

    The collocation polynomial is of degree three. Where the equations are not stiff over the step,
    the accelerations at its ends are as good as the states, and a polynomial through positions,
    velocities and accelerations is of the method's own order; where they are stiff, errors of the
    state would be magnified in them.
    """
    n = context[COORDINATES]
    length = 2 * n
    y0, y1 = row_of(context, Y0), row_of(context, Y1)
    f0, f1 = row_of(context, F), row_of(context, F + 1)
    for row in range(DENSE_ROWS):
        f = row_of(context, F + row)
        for i in range(length):
            f[i] = 0.0
    if stiffness(context, h) > _SMOOTH:
        for i in range(length):
            f0[i] = y0[i]
            f1[i] = y1[i] - y0[i]
        curve(context, row_of(context, F + 2), row_of(context, F + 3))
        return 0
    hermite_rows(context, h, K + LAST)
    k0 = row_of(context, K)
    k1 = row_of(context, K + LAST)
    f2 = row_of(context, F + 2)
    f3 = row_of(context, F + 3)
    f4 = row_of(context, F + 4)
    f5 = row_of(context, F + 5)
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


METHOD = Method(
    order=4,  # power of the step in the error estimate
    error_order=3,
    stage_calls=0,  # counted where they happen
    last=LAST,
    dense_rows=DENSE_ROWS,
    dense_calls=0,
    beta=0.0,  # measured: no proportional part
    safety=0.9,  # measured: share of the length that the error permits
    shrink=0.2,  # measured: least ratio of the lengths of two steps
    grow=8.0,  # measured: largest ratio
    stages=stages,
    error=error,
    dense=dense,
    propose=propose,
    accepted=accepted,
    restart=restart,
    memory=memory,
    foresight=0.5,  # measured: a few steps of the explicit method that leads across
)
