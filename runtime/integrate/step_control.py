"""Length of the next step, and of the first.

The controller is the proportional-integral one of K. Gustafsson as Hairer and Wanner use it
(Solving Ordinary Differential Equations II, section IV.2); the first step is that of volume I,
section II.4.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Integers
from runtime.core.jit import addressed, compiled, inner
from runtime.core.loop_record import Plan, run_record
from runtime.core.state_derivative import write_derivative
from runtime.core.workspace_rows import row_of
from runtime.linalg.vectors import copy_vector

_FALL = 0.1  # measured: least ratio of an error to the error expected from the step before
_COMPARABLE = 2.0  # measured: ratio of two lengths up to which one error predicts the other
_ROUNDING = 1e-12  # accuracy: of the typical size; start values that assembly left near zero
_APART = 1e-6  # accuracy: of the typical size; displacement in a difference quotient
_STABLE = 5.5  # measured: |λ| h of a fast decay at which dop853 is stable; its edge is at 6
_START = 1e-3  # measured: of the typical size; a start value counts as no smaller


@addressed(ft.PROPOSE)
def propose(context: Integers, h: float) -> float:
    """Ratio of the next step's length to this accepted one's.

    Of a motion in few coordinates an estimate passes through zero now and then, and steps that
    trust it come to be so long that the next estimate is worth nothing. From step to step an error
    is taken to fall to a tenth of what the lengths of the steps let expect, and no further.
    """
    r = run_record(context)
    if r.plan != Plan.FREE:
        r.remembered = 0.0
    else:
        if r.remembered > 0.0 and h <= _COMPARABLE * r.length_old:
            expected, longer = r.remembered, h / r.length_old
            for _ in range(r.estimate_order):
                expected *= longer
            r.error = max(r.error, _FALL * expected)
        r.remembered, r.length_old = r.error, h
    ratio = r.grow
    if r.error != 0.0:
        power = r.beta * np.log(r.error_old) - (r.exponent - 0.75 * r.beta) * np.log(r.error)
        ratio = max(r.shrink, min(r.grow, r.safety * np.exp(power)))
    return float(min(ratio, 1.0) if r.rejected_before != 0 else ratio)


@inner
def limit_by_states(context: Context, t: float) -> None:
    """Write the longest step from Y0 in which the fastest state of first order decays.

    Dense output that has stages of its own takes what is left of a fast state for its motion, so
    that samples err far more than the ends of steps where these go beyond the edge of stability.
    The spectral radius of the states' own rates follows by power iteration, one evaluation a step.
    """
    r, n, along = run_record(context), context[ft.COORDINATES], context.state_direction
    y, z, size = row_of(context, ws.Y0), row_of(context, ws.STAGE), row_of(context, ws.SIZE)
    rate, moved = row_of(context, ws.K), row_of(context, ws.DELTA)
    copy_vector(y, z)
    for i in range(context[ft.STATES]):
        j = n + context.state_columns[i]
        z[j] += _APART * along[i] * size[j]
    write_derivative(context, t, ws.STAGE, ws.DELTA)
    r.rhs += 1
    total = 0.0
    for i in range(context[ft.STATES]):
        j = n + context.state_columns[i]
        along[i] = (moved[j] - rate[j]) / (_APART * size[j])
        total += along[i] ** 2
    radius = np.sqrt(total)
    known = np.isfinite(radius) and radius > 0.0
    for i in range(context[ft.STATES]):
        along[i] = along[i] / radius if known else 1.0
    # Two steps together tell |λ| of states that swing, whose rates grow and shrink in turns. Of a
    # chain of integrators the first is a mere factor, and the second zero.
    mean = np.sqrt(radius * r.radius) if known else 0.0
    r.radius = radius if known else 0.0
    r.followed = _STABLE / mean if mean > 0.0 else np.inf


@compiled(ft.FIRST_STEP)
def first_step(context: Integers, t: float, h_max: float, rtol: float, order: int) -> float:
    """Length of a first step from Y0 with derivative K, at most `h_max`; evaluates the rhs once."""
    y0, k0, z = row_of(context, ws.Y0), row_of(context, ws.K), row_of(context, ws.SAMPLE)
    d, atol, typical = row_of(context, ws.DELTA), row_of(context, ws.ATOL), row_of(context, ws.SIZE)
    length = 2 * context[ft.COORDINATES]
    size, rate, largest = 0.0, 0.0, 0.0
    for j in range(length):
        tolerance = atol[j] + rtol * max(abs(y0[j]), _START * typical[j])
        size += (y0[j] / tolerance) ** 2
        largest = max(largest, abs(y0[j]) / typical[j])
        rate += (k0[j] / tolerance) ** 2
    nothing = largest <= _ROUNDING or size <= 1e-10 * length or rate <= 1e-10 * length
    h = 1e-6 if nothing else 0.01 * np.sqrt(size / rate)
    h = min(h, h_max)
    for j in range(length):
        z[j] = y0[j] + h * k0[j]
    write_derivative(context, t + h, ws.SAMPLE, ws.DELTA)
    change = 0.0
    for j in range(length):
        tolerance = atol[j] + rtol * max(abs(y0[j]), _START * typical[j])
        change += ((d[j] - k0[j]) / tolerance) ** 2
    steepest = max(np.sqrt(rate / length), np.sqrt(change / length) / h)
    if not np.isfinite(steepest):
        return float(h)
    second = max(1e-6, h * 1e-3) if steepest <= 1e-15 else (0.01 / steepest) ** (1.0 / order)
    return float(min(100.0 * h, second, h_max))
