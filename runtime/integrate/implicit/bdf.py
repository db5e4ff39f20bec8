"""Backward differentiation formulas of variable order 1 to 5 and variable step.

The formulas are the numerical differentiation formulas, BDF with the last difference added, in the
quasi-constant step implementation of L. F. Shampine and M. W. Reichelt, The MATLAB ODE suite, SIAM
Journal on Scientific Computing 18, 1997: the past is kept as backward differences of all
coordinates and velocities at equal distances, and interpolated anew where the step changes. The
differences of dependent coordinates are as smooth as those of independent ones, so that a change of
the partition costs neither order nor a restart.

The step ends at t₁ with u̇ - ψ̇ - c ü = 0 and u - ψ - c u̇ = 0, c = h / α_k; see `reduction` for how
this is solved.
"""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core.array_types import Integers
from runtime.core.function_table import (
    COORDINATES,
    ERROR,
    HOOK,
    PROPOSE,
    SLIDING_COUNT,
    STAGES,
    method_floats_of,
    method_integers_of,
)
from runtime.core.jit import addressed, compiled, inner
from runtime.core.run_record import run_record
from runtime.core.workspace import STAGE, Y1, K, row_of
from runtime.integrate.implicit.bdf_history import (
    AHEAD,
    ALPHA,
    DENSE_ROWS,
    DIFFERENCE,
    GROW,
    HIGHEST,
    NOW,
    PAST,
    begin,
    dense,
    foresee,
    look_back,
)
from runtime.integrate.implicit.bdf_newton import LAST, MOST_ITERATIONS, estimate, newton
from runtime.integrate.implicit.method_memory import (
    C_FACTORED,
    COUNTS,
    CURRENT,
    DAMPING,
    ENOUGH,
    EQUAL,
    FREEDOMS,
    H_BASE,
    HIGHER,
    ITERATIONS,
    LOW,
    LOWER,
    NEXT_ORDER,
    RATE,
    REJECTED,
    SETTLED,
    STEP_ERROR,
    STEP_ORDER,
    STIFFNESS,
    line,
    memory,
)
from runtime.integrate.implicit.newton_matrices import factor_real, tolerate
from runtime.integrate.implicit.state_space_form import arrive, differentiate, unknowns
from runtime.integrate.implicit.stiffness_estimate import calm
from runtime.integrate.method import Method

_SHARE = 0.2  # measured: factor of rtol^(1/5), the tolerance of a step over that of the user
NEWTON = 3e-3  # measured: how far Newton's method is taken, over the tolerance of the user
# Cosines of the angles of A(α) stability, of the NDF: Shampine and Reichelt, table 1.
_DAMPED = np.append([-1.0, -1.0, -1.0], np.cos(np.radians([80.0, 66.0, 51.0])))
_RESOLVED = 0.5  # measured: rad in a step; a vibration that turns by less is resolved
_PASSED = 15.0  # measured: rad in a step; between both the roots may lie outside the circle
_SAME = 1.1  # measured: a step that could grow by less keeps its length, and its matrix


@inner
def share(rtol: float) -> float:
    """What the estimate is held to, over the tolerance asked.

    The error of a run is that of a step, h⁶ at order 5, times the number of steps.
    """
    return float(_SHARE * rtol**0.2)


@addressed(STAGES)
def stages(context: Integers, t: float, h: float) -> int:
    """Take the step from Y0 to Y1, of which the dependent half is not yet corrected."""
    r = run_record(context)
    n = context[COORDINATES]
    length = 2 * n
    memory, notes = method_floats_of(context), method_integers_of(context)
    unknowns(context)
    look_back(context, h)
    c = h / ALPHA[notes[STEP_ORDER]]
    part = share(r.rtol)
    for _ in range(2):
        foresee(context)
        y1 = row_of(context, Y1)
        memory[ENOUGH] = tolerate(context, part * r.rtol, r.rtol, NEWTON, HIGHEST + 2, c, y1)
        fresh = notes[CURRENT] != 1
        if fresh:
            z = row_of(context, STAGE)
            for i in range(length):
                z[i] = y1[i]
            if arrive(context, t + h, STAGE, K + LAST) == FAILED:
                return FAILED
            differentiate(context, t + h, STAGE)
        if memory[C_FACTORED] != c:
            memory[RATE] = 1.0
            memory[C_FACTORED] = c
            r.factorizations += 1
            if factor_real(context, n, c) != 0:
                notes[CURRENT] = 0
                return FAILED
        taken = newton(context, t + h, c)
        if taken != FAILED:
            k = notes[STEP_ORDER]
            t1 = t + h
            memory[STEP_ERROR] = estimate(context, t1, c, 0, part)
            if notes[EQUAL] >= k:
                if k > 1:
                    memory[LOWER] = estimate(context, t1, c, -1, part)
                if k < HIGHEST:
                    memory[HIGHER] = estimate(context, t1, c, 1, part)
            return taken
        notes[CURRENT] = 0
        if fresh:
            return FAILED
    return FAILED


@addressed(ERROR)
def error(context: Integers, h: float, rtol: float) -> float:
    """Estimated error of the step over its tolerance, root mean square over q and v."""
    return float(method_floats_of(context)[STEP_ERROR])


@inner
def permitted(context: Integers, k: int, h: float) -> bool:
    """Whether the formula of order `k` damps the fastest vibration at steps of length `h`.

    The formulas of order 3 to 5 do so within an angle about the negative real axis, and outside it
    where the vibration is resolved, or else passes many times in a step.
    """
    memory = method_floats_of(context)
    turn = h * memory[STIFFNESS]
    return bool(memory[DAMPING] >= _DAMPED[k] or turn < _RESOLVED or turn > _PASSED)


@addressed(PROPOSE)
def propose(context: Integers, h: float) -> float:
    """Choose the next order; ratio of the next step's length to this accepted one's.

    Both stay until k + 1 steps of one length were taken at order k, as the differences of higher
    order mean nothing before.
    """
    r = run_record(context)
    memory, notes = method_floats_of(context), method_integers_of(context)
    k = notes[STEP_ORDER]
    notes[NEXT_ORDER] = k
    if notes[EQUAL] + 1 < k + 1:
        return 1.0
    safety = r.safety * (2 * MOST_ITERATIONS + 1) / (2 * MOST_ITERATIONS + notes[ITERATIONS])
    best = max(r.error, 1e-10) ** (-1.0 / (k + 1))
    stable = permitted(context, k, h)
    if k > 1:
        ratio = max(memory[LOWER], 1e-10) ** (-1.0 / k)
        if ratio > best or not stable:
            best = ratio
            notes[NEXT_ORDER] = k - 1
    if k < HIGHEST and stable:
        ratio = max(memory[HIGHER], 1e-10) ** (-1.0 / (k + 2))
        if ratio > best and permitted(context, k + 1, max(1.0, ratio * safety) * h):
            best = ratio
            notes[NEXT_ORDER] = k + 1
    best *= safety
    if notes[NEXT_ORDER] == k and 1.0 / _SAME < best < _SAME:
        return 1.0
    return float(max(r.shrink, min(r.grow, best)))


@compiled(HOOK)
def accepted(context: Integers, t: float, h: float) -> int:
    """Take the step into the differences, and change to the order proposed."""
    r = run_record(context)
    n = context[COORDINATES]
    length = 2 * n
    memory, notes = method_floats_of(context), method_integers_of(context)
    k = notes[STEP_ORDER]
    y1 = row_of(context, Y1)
    start, ahead, low = line(memory, NOW, n), line(memory, AHEAD, n), line(memory, LOW, n)
    newest, higher = line(memory, PAST + k + 1, n), line(memory, PAST + k + 2, n)
    last = line(memory, NOW + k + 1, n)
    for i in range(length):
        newest[i] = (y1[i] - start[i]) - ahead[i]
        low[i] = 0.0
    difference = line(memory, DIFFERENCE, n)
    for i in range(2 * notes[FREEDOMS]):
        j = notes[COUNTS + i // 2] + i % 2 * n
        change = ahead[j] + difference[j]
        left = start[j] + change
        if context[SLIDING_COUNT] != 0 or y1[j] == left:
            low[j] = change - (left - start[j])
            newest[j] = difference[j]
    for i in range(length):
        higher[i] = newest[i] - last[i]
    for j in range(k, -1, -1):
        past, now, above = (
            line(memory, PAST + j, n),
            line(memory, NOW + j, n),
            line(memory, PAST + j + 1, n),
        )
        for i in range(length):
            past[i] = now[i] + above[i] if j > 0 else y1[i]
    memory[H_BASE] = h
    notes[EQUAL] += 1
    notes[SETTLED] += 1
    notes[REJECTED] = r.rejected
    if r.fixed != 0 and k < HIGHEST and notes[EQUAL] > k:
        notes[NEXT_ORDER] = k + 1
    if notes[NEXT_ORDER] != k:
        notes[STEP_ORDER] = notes[NEXT_ORDER]
        notes[EQUAL] = 0
    r.exponent = 1.0 / (notes[STEP_ORDER] + 1)
    return int(calm(context, h))


@compiled(HOOK)
def restart(context: Integers, t: float, h: float) -> int:
    """Forget the past: the motion goes on under other equations."""
    notes = method_integers_of(context)
    begin(context, h if h > 0.0 else 1.0, 2)
    notes[CURRENT] = 0
    notes[REJECTED] = run_record(context).rejected
    return 0


METHOD = Method(
    order=2,  # power of the step in the error of the first order, with which every start begins
    error_order=1,
    stage_calls=0,  # counted where they happen
    last=LAST,
    dense_rows=DENSE_ROWS,
    dense_calls=0,
    beta=0.0,  # measured: no proportional part
    safety=0.9,  # measured: share of the length that the error permits
    shrink=0.2,  # measured: least ratio of the lengths of two steps
    grow=GROW,
    stages=stages,
    error=error,
    dense=dense,
    propose=propose,
    accepted=accepted,
    restart=restart,
    memory=memory,
    foresight=0.5,  # measured: a few steps of the explicit method that leads across
)
