"""Backward differentiation formulas of variable order 1 to 5 and variable step.

The formulas are the numerical differentiation formulas, BDF with the last difference added, in the
quasi-constant step implementation of L. F. Shampine and M. W. Reichelt, The MATLAB ODE suite, SIAM
Journal on Scientific Computing 18, 1997: the past is kept as backward differences of all
coordinates and velocities at equal distances, and interpolated anew where the step changes. The
differences of dependent coordinates are as smooth as those of independent ones, so that a change of
the partition costs neither order nor a restart.

The step ends at t₁ with u̇ - ψ̇ - c ü = 0 and u - ψ - c u̇ = 0, c = h / α_k; see
`state_space_form` for how this is solved.
"""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core import function_table_slots as ft
from runtime.core.array_types import Context, Integers
from runtime.core.jit import addressed, compiled, inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import STAGE, Y1, K, row_of
from runtime.integrate.implicit import bdf_history as history
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit import simplified_newton as newton
from runtime.integrate.implicit.bdf_history import HIGHEST
from runtime.integrate.implicit.bdf_newton import MOST_ITERATIONS, estimate_error, solve
from runtime.integrate.implicit.newton_matrices import factor_real
from runtime.integrate.implicit.state_space_form import differentiate, evaluate, list_unknowns
from runtime.integrate.implicit.stiffness_estimate import suits_explicit
from runtime.linalg.vectors import copy_vector

_SHARE = 0.2  # measured: factor of rtol^(1/5), the tolerance of a step over that of the user
_NEWTON = 3e-3  # measured: how far Newton's method is taken, over the tolerance of the user
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
