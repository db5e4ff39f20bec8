"""Backward differentiation formulas of variable order 1 to 5 and variable step.

The formulas are the numerical differentiation formulas, BDF with the last difference added, in the
quasi-constant step implementation of L. F. Shampine and M. W. Reichelt, The MATLAB ODE suite, SIAM
Journal on Scientific Computing 18, 1997: the past is kept as backward differences of all
coordinates and velocities at equal distances, and interpolated anew where the step changes. The
differences of dependent coordinates are as smooth as those of independent ones, so that a change of
the partition costs neither order nor a restart.

The step ends at t₁ with u̇ - ψ̇ - c ü = 0 and u - ψ - c u̇ = 0, c = h / α_k; see
`state_space_form` for how this is solved.

Newton's method for a step of the backward differentiation formulas, and the step's error.
"""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core import function_table_slots as ft
from runtime.core.arrays import Context, Integers
from runtime.core.function_table_slots import COORDINATES
from runtime.core.jit import addressed, compiled, inlined, inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import STAGE, Y1, K, row_of, velocity_rates
from runtime.integrate.implicit import bdf_history as history
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit import simplified_newton as newton
from runtime.integrate.implicit import state_space_form as form
from runtime.integrate.implicit.bdf_history import (
    AHEAD,
    DIFFERENCE,
    ERROR_CONSTANT,
    HIGHEST,
    NOW,
    PSI,
)
from runtime.integrate.implicit.simplified_newton import (
    factor_real,
    filtered_error,
    newton_iteration,
    solve_factored,
)
from runtime.integrate.implicit.state_space_form import (
    differentiate,
    evaluate,
    list_unknowns,
    suits_explicit,
)
from runtime.linalg.vectors import axpy, copy_vector

MOST_ITERATIONS = 4  # safety: Newton iterations of a step
_RESIDUAL = 19  # layout: row of METHOD_FLOATS; later the error of all coordinates
_SEEN = 0.01  # accuracy: of the tolerance; change of a velocity by the rounding of a position


@inner
def add_rounding_effect(context: Context, t: float, c: float) -> None:
    """Add to the accelerations at Y1 their change up to what rounding cut off from it.

    Nothing is added where Newton's method would not see it. At an angle of a million turns the last
    digit is a force that no step gets smooth; so it is where a force is stiff.
    """
    n, f = context[COORDINATES], context.method_integers[mem.FREEDOMS]
    unknown, by_u = mem.unknowns(context), mem.derivative(context, mem.BY_U)
    y1, rows = row_of(context, Y1), mem.rows(context)
    start, ahead, difference = rows[NOW], rows[AHEAD], rows[DIFFERENCE]
    rest, allowed = rows[mem.IN], rows[mem.TOLERANCE]
    rest.fill(0.0)
    for i in range(2 * f):
        j = unknown[i // 2] + i % 2 * n
        rest[j] = (ahead[j] + difference[j]) - (y1[j] - start[j])
    seen = False
    for i in range(f):
        change = 0.0
        for k in range(f):
            change += abs(by_u[i, k] * rest[unknown[k]])
        seen = seen or c * change > _SEEN * allowed[n + unknown[i]]
    if seen:
        form.complete_direction(context, t, Y1)
        form.differentiate_along(context, t, Y1)
        axpy(1.0, mem.half(context, mem.SLOPE, 0), velocity_rates(context, K + mem.LAST))


@inlined
def set_unknown(context: Integers, c: float, j: int) -> None:
    """Set position j at the end of the step from its velocity there, by the formula."""
    y1, rows = row_of(context, Y1), mem.rows(context)
    rows[DIFFERENCE, j] = c * y1[context[COORDINATES] + j] - rows[PSI, j]
    y1[j] = rows[NOW, j] + (rows[AHEAD, j] + rows[DIFFERENCE, j])


@inner
def evaluate_end(context: Integers, t: float, c: float) -> int:
    """Complete the state Y1 and write its accelerations; iterations that took, or `FAILED`."""
    taken = form.evaluate(context, t, Y1, K + mem.LAST)
    if taken != FAILED:
        run_record(context).rhs += 1
        add_rounding_effect(context, t, c)
    return taken


@inner
def improve_end(context: Context, c: float) -> float:
    """Change the unknowns of Y1 by a Newton step; its size over the tolerance."""
    n, f = context[COORDINATES], context.method_integers[mem.FREEDOMS]
    unknown, y1, rows = mem.unknowns(context), row_of(context, Y1), mem.rows(context)
    a = velocity_rates(context, K + mem.LAST)
    start, ahead, psi, difference = rows[NOW], rows[AHEAD], rows[PSI], rows[DIFFERENCE]
    delta, allowed = rows[_RESIDUAL], rows[mem.TOLERANCE]
    for i in range(f):
        j = unknown[i]
        delta[i] = c * a[j] - psi[n + j] - difference[n + j]
    solve_factored(context, mem.REAL, delta)
    total = 0.0
    for i in range(f):
        j = unknown[i]
        difference[n + j] += delta[i]
        y1[n + j] = start[n + j] + (ahead[n + j] + difference[n + j])
        set_unknown(context, c, j)
        total += (delta[i] / allowed[n + j]) ** 2 + (c * delta[i] / allowed[j]) ** 2
    return float(np.sqrt(total / max(1, 2 * f)))


iterate = newton_iteration(evaluate_end, improve_end, MOST_ITERATIONS, slowest=1.0)


@inner
def solve(context: Context, t: float, c: float) -> int:
    """Solve for the state Y1 at time `t`, the end of the step; its dependent half is not final."""
    n, unknown = context[COORDINATES], mem.unknowns(context)
    for i in range(context.method_integers[mem.FREEDOMS]):
        mem.rows(context)[DIFFERENCE, n + unknown[i]] = 0.0
        set_unknown(context, c, unknown[i])
    return iterate(context, t, c)


@inner
def estimate_error(context: Context, t: float, c: float, other: int, share: float) -> float:
    """Size of the filtered difference of order k + 1 + `other` at the new state.

    At an order k it is ∇ᵏ⁺¹, what the step adds to what was foreseen, one lower it is that plus ∇ᵏ
    of the past, one higher that less ∇ᵏ⁺¹ of the past.

    Where stiff forces hold a position, the formula's velocity is a difference quotient of it and
    off by one power of h more than the differences of velocities say; the filter knows. The
    dependent coordinates' own differences are the error of the dense output, which is not carried
    on: it is held to what was asked, over which the tolerance of a step is `share`.
    """
    n, notes, unknown = context[COORDINATES], context.method_integers, mem.unknowns(context)
    k, y1, rows = notes[mem.STEP_ORDER], row_of(context, Y1), mem.rows(context)
    start, ahead, difference = rows[NOW], rows[AHEAD], rows[DIFFERENCE]
    past = rows[NOW + (k if other < 0 else k + 1)]
    rates, raw = rows[mem.SLOPE], rows[_RESIDUAL]
    for i in range(notes[mem.FREEDOMS]):
        j = unknown[i]
        rates[n + i] = difference[j] - other * past[j]
        rates[i] = difference[n + j] - other * past[n + j]
    for i in range(n):
        raw[i] = share * ((y1[i] - start[i]) - ahead[i] - other * past[i])
    return float(ERROR_CONSTANT[k + other] * filtered_error(context, t, Y1, c, raw))


_SHARE = 0.2  # measured: factor of rtol^(1/5) in the ratio of a step's tolerance to the user's
_NEWTON = 3e-3  # measured: tolerance of Newton's method over that of the user
# Cosines of the angles of A(α) stability, of the NDF: Shampine and Reichelt, table 1.
_DAMPED = np.append([-1.0, -1.0, -1.0], np.cos(np.radians([80.0, 66.0, 51.0])))
_RESOLVED = 0.5  # measured: rad in a step; a vibration that turns by less is resolved
_PASSED = 15.0  # measured: rad in a step; between `_RESOLVED` and this the roots may be unstable
_SAME = 1.1  # measured: a step that could grow by less keeps its length, and its matrix


@inner
def share(rtol: float) -> float:
    """What the estimate is held to, over the tolerance asked.

    The error of a run is that of a step, h⁶ at order 5, times the number of steps.
    """
    return float(_SHARE * rtol**0.2)


@inner
def predict(context: Integers, c: float) -> int:
    """Predict the state at the end of the step, and set the tolerance by it."""
    history.extrapolate(context)
    part = share(run_record(context).rtol)
    newton.set_tolerance(context, part, _NEWTON, HIGHEST + 2, c, row_of(context, Y1))
    return 0


@inner
def linearize(context: Integers, t: float) -> int:
    """Take the derivatives at the predicted end of the step, once it is on the constraints."""
    copy_vector(row_of(context, Y1), row_of(context, STAGE))
    if evaluate(context, t, STAGE, K + mem.LAST) == FAILED:
        return FAILED
    return int(differentiate(context, t, STAGE))


solve_step = newton.step_solver(predict, linearize, factor_real, solve)


@addressed(ft.STAGES)
def stages(context: Context, t: float, h: float) -> int:
    """Take the step from Y0 to Y1, of which the dependent half is not yet corrected."""
    memory, notes = context.method_floats, context.method_integers
    list_unknowns(context)
    history.rescale_history(context, h)
    k, t1 = notes[mem.STEP_ORDER], t + h
    c = h / history.ALPHA[k]
    taken = solve_step(context, t1, c)
    if taken != FAILED:
        part = share(run_record(context).rtol)
        memory[mem.STEP_ERROR] = estimate_error(context, t1, c, 0, part)
        if notes[mem.EQUAL] >= k:
            if k > 1:
                memory[mem.LOWER] = estimate_error(context, t1, c, -1, part)
            if k < HIGHEST:
                memory[mem.HIGHER] = estimate_error(context, t1, c, 1, part)
    return taken


@inner
def is_stable(context: Context, k: int, h: float) -> bool:
    """Whether the formula of order `k` damps the fastest vibration at steps of length `h`.

    The formulas of order 3 to 5 do so within an angle about the negative real axis, and outside it
    where the vibration is resolved, or else passes many times in a step.
    """
    memory = context.method_floats
    turn = h * memory[mem.STIFFNESS]
    return bool(memory[mem.DAMPING] >= _DAMPED[k] or turn < _RESOLVED or turn > _PASSED)


@addressed(ft.PROPOSE)
def propose(context: Context, h: float) -> float:
    """Choose the next order; ratio of the next step's length to this accepted one's.

    Both stay until k + 1 steps of one length were taken at order k, as the differences of higher
    order mean nothing before.
    """
    r = run_record(context)
    memory, notes = context.method_floats, context.method_integers
    k = notes[mem.STEP_ORDER]
    notes[mem.NEXT_ORDER] = k
    if notes[mem.EQUAL] + 1 < k + 1:
        return 1.0
    safety = r.safety * (2 * MOST_ITERATIONS + 1) / (2 * MOST_ITERATIONS + notes[mem.ITERATIONS])
    best = max(r.error, 1e-10) ** (-1.0 / (k + 1))
    stable = is_stable(context, k, h)
    if k > 1:
        ratio = max(memory[mem.LOWER], 1e-10) ** (-1.0 / k)
        if ratio > best or not stable:
            best = ratio
            notes[mem.NEXT_ORDER] = k - 1
    if k < HIGHEST and stable:
        ratio = max(memory[mem.HIGHER], 1e-10) ** (-1.0 / (k + 2))
        if ratio > best and is_stable(context, k + 1, max(1.0, ratio * safety) * h):
            best = ratio
            notes[mem.NEXT_ORDER] = k + 1
    best *= safety
    if notes[mem.NEXT_ORDER] == k and 1.0 / _SAME < best < _SAME:
        return 1.0
    return float(max(r.shrink, min(r.grow, best)))


@compiled(ft.HOOK)
def accepted(context: Context, t: float, h: float) -> int:
    """Take the step into the differences, and change to the order proposed."""
    r, notes = run_record(context), context.method_integers
    k = notes[mem.STEP_ORDER]
    history.extend_history(context, h)
    notes[mem.EQUAL] += 1
    notes[mem.SETTLED] += 1
    notes[mem.REJECTED] = r.rejected
    if r.fixed != 0 and k < HIGHEST and notes[mem.EQUAL] > k:
        notes[mem.NEXT_ORDER] = k + 1
    if notes[mem.NEXT_ORDER] != k:
        notes[mem.STEP_ORDER] = notes[mem.NEXT_ORDER]
        notes[mem.EQUAL] = 0
    r.exponent = 1.0 / (notes[mem.STEP_ORDER] + 1)
    return int(suits_explicit(context, h))


@compiled(ft.HOOK)
def restart(context: Context, t: float, h: float) -> int:
    """Forget the past: the motion goes on under other equations."""
    notes = context.method_integers
    history.start_history(context, h if h > 0.0 else 1.0, 2)
    notes[mem.CURRENT] = 0
    notes[mem.REJECTED] = run_record(context).rejected
    return 0


METHOD = newton.implicit_method(
    estimate_order=2,  # at order 1, with which every start begins
    grow=history.GROW,
    stages=stages,
    dense=history.dense,
    propose=propose,
    accepted=accepted,
    restart=restart,
)
