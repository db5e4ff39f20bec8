"""Newton's method for a step of the backward differentiation formulas, and the step's error."""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core.array_types import Context, Integers
from runtime.core.function_table_slots import COORDINATES
from runtime.core.jit import inlined, inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import Y1, K, row_of, velocity_rates
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit import state_space_form as form
from runtime.integrate.implicit.bdf_history import AHEAD, DIFFERENCE, ERROR_CONSTANT, NOW, PSI
from runtime.integrate.implicit.newton_matrices import filtered_error, solve_factored
from runtime.integrate.implicit.simplified_newton import newton_iteration
from runtime.linalg.vectors import axpy

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
    unknown, y1, a = (
        mem.unknowns(context),
        row_of(context, Y1),
        velocity_rates(context, K + mem.LAST),
    )
    rows = mem.rows(context)
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
