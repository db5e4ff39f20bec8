"""Newton's method for a step of the backward differentiation formulas, and the step's error."""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core.array_types import Integers
from runtime.core.array_views import view
from runtime.core.function_table import COORDINATES, method_floats_of, method_integers_of
from runtime.core.jit import inner
from runtime.core.run_record import run_record
from runtime.core.workspace import Y1, K, row_of, velocity_rates
from runtime.integrate.implicit.bdf_history import (
    AHEAD,
    DIFFERENCE,
    ERROR_CONSTANT,
    NOW,
    PSI,
)
from runtime.integrate.implicit.method_memory import (
    COUNTS,
    FREEDOMS,
    IN,
    LINES,
    NUMBERS,
    OUT,
    SLOPE,
    STEP_ORDER,
    TOLERANCE,
    line,
    matrix,
)
from runtime.integrate.implicit.newton_matrices import DONE, GOING, converged, filtered, uneven
from runtime.integrate.implicit.state_space_form import along, arrive, carry
from runtime.linalg.lu import solve

LAST = 1  # row, after K, of the derivative at the end of the step
MOST_ITERATIONS = 4  # safety: Newton iterations of a step
RESIDUAL = 19  # row of METHOD_FLOATS
_SEEN = 0.01  # accuracy: of the tolerance; change of a velocity by the rounding of a position


@inner
def unrounded(context: Integers, t: float, c: float) -> bool:
    """Write into row SLOPE what accelerations change by from Y1 to what rounding cut off from it.

    Where that is nothing that Newton's method would see, False and nothing is written. At an angle
    of a million turns the last digit is a force that no step gets smooth; so it is where a force is
    stiff.
    """
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    n = context[COORDINATES]
    length = 2 * n
    f = notes[FREEDOMS]
    y1 = row_of(context, Y1)
    start, ahead, difference = (
        line(memory, NOW, n),
        line(memory, AHEAD, n),
        line(memory, DIFFERENCE, n),
    )
    allowed, by_u = line(memory, TOLERANCE, n), matrix(memory, 0, n)
    rest, out = line(memory, IN, n), line(memory, OUT, n)
    for j in range(length):
        rest[j] = 0.0
    for i in range(2 * f):
        j = notes[COUNTS + i // 2] + i % 2 * n
        rest[j] = (ahead[j] + difference[j]) - (y1[j] - start[j])
    seen = False
    for i in range(f):
        change = 0.0
        for k in range(f):
            change += abs(by_u[i * f + k] * rest[notes[COUNTS + k]])
        seen = seen or c * change > _SEEN * allowed[n + notes[COUNTS + i]]
    if seen:
        dq, dv = view(rest, 0, n), view(rest, n, n)
        carry(context, t, Y1, dq, dv, view(out, 0, n), view(out, n, n))
        # The complex matrix is none of this method's, and lends room.
        free = view(memory, NUMBERS + length * LINES + 3 * n * n, 4 * n * n)
        along(context, t, Y1, dq, dv, view(line(memory, SLOPE, n), 0, n), free)
    return seen


@inner
def newton(context: Integers, t: float, c: float) -> int:
    """Solve for the state Y1 at time `t`, the end of the step; its dependent half is not final.

    Returns calls of `correction`, or `FAILED` where the iteration does not converge.
    """
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    r = run_record(context)
    n = context[COORDINATES]
    f = notes[FREEDOMS]
    y1 = row_of(context, Y1)
    a = velocity_rates(context, K + LAST)
    start, ahead, psi = line(memory, NOW, n), line(memory, AHEAD, n), line(memory, PSI, n)
    difference, delta = line(memory, DIFFERENCE, n), line(memory, RESIDUAL, n)
    da, allowed = view(line(memory, SLOPE, n), 0, n), line(memory, TOLERANCE, n)
    for i in range(f):
        j = notes[COUNTS + i]
        difference[n + j] = 0.0
        difference[j] = c * y1[n + j] - psi[j]
        y1[j] = start[j] + (ahead[j] + difference[j])
    taken = 0
    before = 0.0
    for iteration in range(MOST_ITERATIONS):
        result = arrive(context, t, Y1, K + LAST)
        if result == FAILED:
            return FAILED
        taken += result
        r.rhs += 1
        r.iterations += 1
        if unrounded(context, t, c):
            for i in range(n):
                a[i] += da[i]
        for i in range(f):
            j = notes[COUNTS + i]
            delta[i] = c * a[j] - psi[n + j] - difference[n + j]
        solve(matrix(memory, 2, n), f, view(notes, COUNTS + n, n), delta)
        total = 0.0
        for i in range(f):
            j = notes[COUNTS + i]
            difference[n + j] += delta[i]
            y1[n + j] = start[n + j] + (ahead[n + j] + difference[n + j])
            difference[j] = c * y1[n + j] - psi[j]
            y1[j] = start[j] + (ahead[j] + difference[j])
            total += (delta[i] / allowed[n + j]) ** 2 + (c * delta[i] / allowed[j]) ** 2
        size = np.sqrt(total / max(1, 2 * f))
        left = MOST_ITERATIONS - 1 - iteration
        reached = converged(context, iteration, left, size, before, 1.0)
        if reached != GOING:
            return taken if reached == DONE else FAILED
        before = size
    return FAILED


@inner
def estimate(context: Integers, t: float, c: float, other: int, share: float) -> float:
    """Size of the filtered difference of order k + 1 + `other` at the new state.

    At an order k it is ∇ᵏ⁺¹, what the step adds to what was foreseen, one lower it is that plus ∇ᵏ
    of the past, one higher that less ∇ᵏ⁺¹ of the past.

    Where stiff forces hold a position, the formula's velocity is a difference quotient of it and
    off by one power of h more than the differences of velocities say; the filter knows. The
    dependent coordinates' own differences are the error of the dense output, which is not carried
    on: it is held to what was asked, over which the tolerance of a step is `share`.
    """
    memory = method_floats_of(context)
    notes = method_integers_of(context)
    n = context[COORDINATES]
    k = notes[STEP_ORDER]
    y1 = row_of(context, Y1)
    start, ahead, difference = (
        line(memory, NOW, n),
        line(memory, AHEAD, n),
        line(memory, DIFFERENCE, n),
    )
    past = line(memory, NOW + (k if other < 0 else k + 1), n)
    sign = 0.0 if other == 0 else (1.0 if other < 0 else -1.0)
    rates = line(memory, SLOPE, n)
    for i in range(notes[FREEDOMS]):
        j = notes[COUNTS + i]
        rates[n + i] = difference[j] + sign * past[j]
        rates[i] = difference[n + j] + sign * past[n + j]
    found = filtered(context, t, Y1, c)
    raw, allowed = line(memory, OUT, n), line(memory, TOLERANCE, n)
    for i in range(n):
        raw[i] = share * ((y1[i] - start[i]) - ahead[i] + sign * past[i])
    return float(ERROR_CONSTANT[k + other] * max(found, uneven(context, raw, allowed)))
