"""Radau IIA method of order 5 with exact derivatives, for the independent coordinates.

Formulas, transformation, error estimate and step control are those of E. Hairer and G. Wanner,
Solving Ordinary Differential Equations II, section IV.8. With the transformation of the three
stages Newton's method needs one real and one complex matrix, of order f each (see
`state_space_form`): the positions of the stages are linear in their velocities, hold exactly at
every iterate, and leave only the equation of the accelerations.

The estimate is of order h⁴ and the error of order h⁶, so that an estimate which is kept at the
tolerance gives errors that shrink faster than it. As in Hairer's program the tolerance is
therefore mapped: what the estimate is held to is `share` times what was asked.
"""

from runtime.constraints.newton_return import FAILED
from runtime.core import function_table as ft
from runtime.core.array_types import Integers
from runtime.core.dense_output import hermite_rows
from runtime.core.jit import addressed, compiled, inner
from runtime.core.loop_record import run_record
from runtime.core.rounding import EPS
from runtime.core.workspace_rows import Y0, Y1, F, K, row_of
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit import radau5_stages as rs
from runtime.integrate.implicit.newton_matrices import factor_complex, factor_real
from runtime.integrate.implicit.radau5_coefficients import C_COMPLEX, C_IMAGINARY, C_REAL
from runtime.integrate.implicit.radau5_error import LAST, estimate_error
from runtime.integrate.implicit.simplified_newton import (
    error,
    newton_iteration,
    set_tolerance,
    step_solver,
)
from runtime.integrate.implicit.state_space_form import differentiate, list_unknowns
from runtime.integrate.implicit.stiffness_estimate import stiffness, suits_explicit
from runtime.integrate.method import Method

DENSE_ROWS = 6
_NEWTON = 5e-4  # measured: how far Newton's method is taken, over the tolerance: steps are few
_MOST_ITERATIONS = 7  # safety: Newton iterations of a step
_SLOWEST = 0.99  # safety: ratio of two Newton steps from which on the iteration is given up
_SAME = 1.2  # measured: a step that could grow by less keeps its length, and its matrices
# measured: h² |G_u| + h |G_u̇| up to which end accelerations add a sixth of their error
_SMOOTH = 10.0


@inner
def share(rtol: float) -> float:
    """What the estimate is held to, over the tolerance asked: errors of a run go with h⁵."""
    return float(0.1 * rtol**-0.2)


@inner
def predict(context: Integers, h: float) -> int:
    """Predict the stages, and set the tolerance by them."""
    rs.predict_stages(context, h)
    end = row_of(context, K + rs.STATES + 2)
    set_tolerance(context, share(run_record(context).rtol), _NEWTON, 0, h * C_REAL, end)
    return 0


@inner
def linearize(context: Integers, t: float) -> int:
    """Take the derivatives at the start of the step."""
    return int(differentiate(context, t, Y0))


@inner
def factor(context: Integers, h: float) -> int:
    """Factor both matrices; not 0 where one is singular."""
    singular = factor_real(context, h * C_REAL)
    return int(singular + factor_complex(context, h * C_COMPLEX, h * C_IMAGINARY))


iterate = newton_iteration(
    rs.evaluate_stages, rs.improve_stages, _MOST_ITERATIONS, slowest=_SLOWEST
)


@inner
def solve(context: Integers, t: float, h: float) -> int:
    """Solve for the three stages, whose dependent halves are not final."""
    rs.start_stages(context, h)
    return iterate(context, t, h)


solve_step = step_solver(predict, linearize, factor, solve)


@addressed(ft.STAGES)
def stages(context: Integers, t: float, h: float) -> int:
    """Take the step from Y0 to Y1, of which the dependent half is not yet corrected."""
    list_unknowns(context)
    taken = solve_step(context, t, h)
    if taken != FAILED:
        y1, end = row_of(context, Y1), row_of(context, K + rs.STATES + 2)
        for i in range(2 * context[ft.COORDINATES]):
            y1[i] = end[i]
        ft.method_floats_of(context)[mem.STEP_ERROR] = estimate_error(context, t, h)
    return taken


@addressed(ft.PROPOSE)
def propose(context: Integers, h: float) -> float:
    """Ratio of the next step's length to this accepted one's.

    The predictive controller of K. Gustafsson; a step that could grow by little keeps its length,
    and with it the factored matrices.
    """
    r, memory, notes = (
        run_record(context),
        ft.method_floats_of(context),
        ft.method_integers_of(context),
    )
    now = max(r.error, 1e-10)
    ratio = now**-0.25
    if notes[mem.EQUAL] > 0:
        predicted = h / memory[mem.H_BASE] * (memory[mem.ERROR_BASE] / now) ** 0.25 * ratio
        ratio = min(ratio, predicted)
    spared = 2 * _MOST_ITERATIONS + 1
    ratio *= r.safety * spared / (spared - 1 + notes[mem.ITERATIONS])
    if r.rejected_before != 0:
        ratio = min(ratio, 1.0)
    if 1.0 <= ratio <= _SAME:
        return 1.0
    return float(max(r.shrink, min(r.grow, ratio)))


@compiled(ft.HOOK)
def accepted(context: Integers, t: float, h: float) -> int:
    """Keep the step's polynomial, from which the next one's stages are predicted."""
    y0, y1 = row_of(context, Y0), row_of(context, Y1)
    memory, notes = ft.method_floats_of(context), ft.method_integers_of(context)
    rs.keep_rounding(context, h)
    change = mem.row(context, rs.POLYNOMIAL)
    for i in range(2 * context[ft.COORDINATES]):
        change[i] = y1[i] - y0[i]
    f2, f3 = mem.row(context, rs.POLYNOMIAL + 1), mem.row(context, rs.POLYNOMIAL + 2)
    rs.write_polynomial(context, f2, f3)
    memory[mem.H_BASE] = h
    memory[mem.ERROR_BASE] = max(1e-2, run_record(context).error)
    notes[mem.EQUAL] += 1
    return int(suits_explicit(context, h))


@compiled(ft.HOOK)
def restart(context: Integers, t: float, h: float) -> int:
    """Forget the past: the motion goes on under other equations."""
    notes, low = ft.method_integers_of(context), mem.row(context, mem.LOW)
    for j in range(2 * context[ft.COORDINATES]):
        low[j] = 0.0
    notes[mem.EQUAL] = 0
    notes[mem.CURRENT] = 0
    return 0


@addressed(ft.DENSE)
def dense(context: Integers, t: float, h: float) -> int:
    """Fill the coefficient rows of the dense output of the step from Y0 to Y1.

    The collocation polynomial is of degree three. Where the equations are not stiff over the step,
    the accelerations at its ends are as good as the states, and a polynomial through positions,
    velocities and accelerations is of the method's own order; where they are stiff, errors of the
    state would be magnified in them.
    """
    n = context[ft.COORDINATES]
    y0, y1 = row_of(context, Y0), row_of(context, Y1)
    k0, k1 = row_of(context, K), row_of(context, K + LAST)
    f0, f1, f2 = row_of(context, F), row_of(context, F + 1), row_of(context, F + 2)
    f3, f4, f5 = row_of(context, F + 3), row_of(context, F + 4), row_of(context, F + 5)
    for i in range(2 * n):
        f4[i] = 0.0
        f5[i] = 0.0
    if stiffness(context, h) > _SMOOTH:
        for i in range(2 * n):
            f0[i] = y0[i]
            f1[i] = y1[i] - y0[i]
        rs.write_polynomial(context, f2, f3)
        return 0
    hermite_rows(context, h, K + LAST)
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
    estimate_order=4,
    error_order=3,
    last=LAST,
    dense_rows=DENSE_ROWS,
    safety=0.9,  # measured: share of the length that the error permits
    shrink=0.2,  # measured: least ratio of the lengths of two steps
    grow=8.0,  # measured: largest ratio
    stages=stages,
    error=error,
    dense=dense,
    propose=propose,
    accepted=accepted,
    restart=restart,
    memory=mem.memory,
    foresight=0.5,  # measured: a few steps of the explicit method that leads across
)
