"""Simplified Newton iteration of an implicit step, whose matrices stay while it converges.

The matrices are I - c G_u̇ - c² G_u; errors of a step are seen through them. The tests of
convergence are those of E. Hairer and G. Wanner, Solving Ordinary Differential Equations II,
section IV.8. A method brings its own prediction, equations and matrices.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core.arrays import EPS, Context, Integers, Vector
from runtime.core.function_table_slots import COORDINATES, ERROR
from runtime.core.jit import addressed, closure, inner
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import ATOL, PARTITION, SIZE, Y0, row_of
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.state_space_form import complete_direction
from runtime.integrate.method import Method
from runtime.linalg.dense_elimination import factor, solve


@inner
def factor_real(context: Context, c: float) -> int:
    """Factor I - c G_u̇ - c² G_u; 1 where it is singular, else 0."""
    f = context.method_integers[mem.FREEDOMS]
    by_u, by_rate = mem.derivative(context, mem.BY_U), mem.derivative(context, mem.BY_RATE)
    a = mem.factors(context, mem.REAL)
    for i in range(f):
        for j in range(f):
            a[i * f + j] = (1.0 if i == j else 0.0) - c * (by_rate[i, j] + c * by_u[i, j])
    return int(factor(a, f, mem.pivots(context, mem.REAL), 0.0))


@inner
def factor_complex(context: Context, c: float, d: float) -> int:
    """Factor I - (c + i d) G_u̇ - (c + i d)² G_u as a real matrix of order 2 f, real parts first."""
    f = context.method_integers[mem.FREEDOMS]
    by_u, by_rate = mem.derivative(context, mem.BY_U), mem.derivative(context, mem.BY_RATE)
    a = mem.factors(context, mem.COMPLEX)
    for i in range(f):
        for j in range(f):
            at = 2 * f * i + j
            real = (1.0 if i == j else 0.0) - c * by_rate[i, j] - (c * c - d * d) * by_u[i, j]
            imaginary = -d * by_rate[i, j] - 2.0 * c * d * by_u[i, j]
            a[at], a[at + f] = real, -imaginary
            a[at + 2 * f * f], a[at + 2 * f * f + f] = imaginary, real
    return int(factor(a, 2 * f, mem.pivots(context, mem.COMPLEX), 0.0))


@inner
def solve_factored(context: Context, index: int, x: Vector) -> None:
    """Overwrite the right side `x` by the solution with the matrix `REAL` or `COMPLEX`.

    That is (f,), or (2 f,) with real parts first.
    """
    order = (index - mem.REAL + 1) * context.method_integers[mem.FREEDOMS]
    solve(mem.factors(context, index), order, mem.pivots(context, index), x)


@inner
def filtered_error(context: Context, t: float, state: int, c: float, raw: Vector) -> float:
    """Size over the tolerance of (I - c J)⁻¹ (x, y), and of the dependent coordinates in `raw`.

    The larger of the two. x and y, changes of the unknowns and of their rates, are in the second
    and in the first half of row SLOPE and are used up. Row IN receives the result, completed by the
    change of the dependent coordinates at the state in row `state`. The matrix takes out what stiff
    forces do not permit, and turns an error of a position that they hold into that of its velocity.

    `raw` is the error of all coordinates as it was estimated. At the ends of steps the dependent
    ones follow from the constraints and have no error of their own. But they are foreseen, and
    interpolated between. Where drivers move them the independent ones say nothing of how, and
    Newton's method for them might come to another way to assemble the machine. Velocities are left
    out: where a stiff force holds a position they are not smooth.
    """
    n, notes = context[COORDINATES], context.method_integers
    f, unknown, rows = notes[mem.FREEDOMS], mem.unknowns(context), mem.rows(context)
    by_u, partition = mem.derivative(context, mem.BY_U), row_of(context, PARTITION)
    change, allowed = rows[mem.IN], rows[mem.TOLERANCE]
    y, x = mem.half(context, mem.SLOPE, 0), mem.half(context, mem.SLOPE, 1)
    for i in range(f):
        for k in range(f):
            y[i] += c * by_u[i, k] * x[k]
    solve_factored(context, mem.REAL, y)
    change.fill(0.0)
    for i in range(f):
        j = unknown[i]
        change[n + j] = y[i]
        change[j] = x[i] + c * y[i]
    complete_direction(context, t, state)
    total, dependent = 0.0, 0.0
    for j in range(2 * n):
        total += (change[j] / allowed[j]) ** 2
    for j in range(n):
        if notes[mem.PARTITIONED] != 0 and partition[j] != 0.0:
            dependent += (raw[j] / allowed[j]) ** 2
    return float(max(np.sqrt(total / (2 * n)), np.sqrt(dependent / (2 * n))))


Solver = Callable[[Integers, float, float], int]

_SLOW = 0.05  # measured: rate of convergence above which the next step takes derivatives anew
_FORGOTTEN = 0.9  # measured: power of the last rate of convergence, with which the next step begins
_LOOSEST = 0.03  # measured: of the tolerance of a step; loosest tolerance of Newton's method
_ROUNDED = 64.0 * EPS  # accuracy: of a step's change; rounding in a difference of high order
_STIFF = 16.0 * EPS  # accuracy: the same of velocities, where stiff forces hold a position
_SOLVED = 4.0 * EPS  # accuracy: rounding in Newton's residual
_LEAST = 8.0 * EPS  # accuracy: of the largest coordinate; rounding in past dependent coordinates
_RECOVERED = 4.0 * EPS  # accuracy: the same, times the square of the ratio of speeds
_FASTEST = 10.0  # safety: largest ratio of speeds, dependent over independent, that counts


def step_solver(
    predict: Callable[[Integers, float], int],
    linearize: Callable[[Integers, float], int],
    factor: Callable[[Integers, float], int],
    solve: Solver,
) -> Solver:
    """A function of (context, t, scale) that solves a step, with fresh derivatives if need be.

    It returns the iterations that returns onto the constraints took, or `FAILED`. The matrices
    belong to the number `scale`: c of BDF, h of Radau IIA. Of (context, scale), `predict` starts
    the iteration and `factor` factors the matrices, not 0 where one is singular; of (context, t),
    `linearize` takes the derivatives, or `FAILED`; `solve` is as `newton_iteration` makes it.
    """

    @closure
    def solve_step(context: Context, t: float, scale: float) -> int:
        r = run_record(context)
        memory, notes = context.method_floats, context.method_integers
        fresh = False
        while not fresh:
            predict(context, scale)
            fresh = notes[mem.CURRENT] != 1
            if fresh and linearize(context, t) == FAILED:
                return FAILED
            if memory[mem.FACTORED_FOR] != scale:
                memory[mem.RATE] = 1.0
                memory[mem.FACTORED_FOR] = scale
                r.factorizations += 1
                if factor(context, scale) != 0:
                    notes[mem.CURRENT] = 0
                    return FAILED
            taken = solve(context, t, scale)
            if taken != FAILED:
                return taken
            notes[mem.CURRENT] = 0
        return FAILED

    return solve_step


def newton_iteration(
    evaluate: Solver, improve: Callable[[Integers, float], float], most: int, slowest: float
) -> Solver:
    """A function of (context, t, scale) that iterates until what is missing is below the tolerance.

    It returns the iterations that returns onto the constraints took, or `FAILED` where a state
    cannot be completed or the iteration does not converge: after `most` iterations, or where the
    ratio of two changes' sizes is `slowest`. Of (context, t, scale), `evaluate` completes the
    iterate and writes its accelerations, or `FAILED`; of (context, scale), `improve` changes it by
    a Newton step, whose size over the tolerance it returns. On return the unknowns are one Newton
    step ahead of the accelerations and dependent halves. For stages that follow each other, as
    those of DIRK methods, `solve` of `step_solver` calls one such function, once a stage; keep the
    stage's number in STEP_ORDER, and let `scale` be h. A later stage takes (z_i - Σ_{j<i} …)/(γ h)
    as the slope of stage i, not the row that `evaluate` wrote. RATE goes on from stage to stage,
    and ITERATIONS is that of the last one; leave the largest for `propose`.
    """

    @closure
    def iterate(context: Context, t: float, scale: float) -> int:
        memory, notes = context.method_floats, context.method_integers
        taken, before = 0, 0.0
        memory[mem.RATE] = max(memory[mem.RATE], EPS) ** _FORGOTTEN
        for iteration in range(most):
            result = evaluate(context, t, scale)
            if result == FAILED:
                return FAILED
            taken += result
            run_record(context).iterations += 1
            notes[mem.ITERATIONS] = iteration + 1
            size = improve(context, scale)
            if size == 0.0:
                return taken
            if iteration > 0:
                ratio = size / before
                if not ratio < slowest:
                    return FAILED
                memory[mem.RATE] = ratio / (1.0 - ratio)
                if ratio > _SLOW:
                    notes[mem.CURRENT] = 0
                left = most - 1 - iteration
                if ratio**left * memory[mem.RATE] * size > memory[mem.ENOUGH]:
                    return FAILED
            if memory[mem.RATE] * size <= memory[mem.ENOUGH]:
                return taken
            if not np.isfinite(size):
                return FAILED
            before = size
        return FAILED

    return iterate


@inner
def set_tolerance(
    context: Context, share: float, newton: float, remembered: int, c: float, ahead: Vector
) -> None:
    """Fill row TOLERANCE, what the error of the step may be, from its ends Y0 and `ahead`.

    Not less than rounding. States are carried on with what rounding cuts off them (row LOW), so
    that it is that of their change over the step. Only in coordinates that were dependent until
    lately, for the steps `remembered` by the method, the past is as rough as their recovery left
    it. ENOUGH becomes how far Newton's method is to be taken, over this tolerance. The error
    estimate is held to `share`, Newton's method taken to `newton`, over the tolerance of the user.
    Where the matrix I - c G_u̇ - c² G_u is stiff, the last digit of a position is a force that the
    next velocity has to undo.

    With steps whose estimates go with h^k and errors of a run with h^p, the error of a run is
    proportional to rtol where `share` is proportional to rtol^(k/p - 1): k = 4 in Radau IIA, 6 in
    BDF, p = 5. Its factor is measured (`test_the_error_is_the_tolerance`), as is `newton`, below
    which errors of a run do not show Newton's. One-step methods have `remembered` 0.
    """
    notes, unknown = context.method_integers, mem.unknowns(context)
    n, f = context[COORDINATES], notes[mem.FREEDOMS]
    asked = run_record(context).rtol
    relative = share * asked
    y0, atol, size = row_of(context, Y0), row_of(context, ATOL), row_of(context, SIZE)
    by_u, allowed = mem.derivative(context, mem.BY_U), mem.rows(context)[mem.TOLERANCE]
    held, carried, moved = 0.0, 0.0, 0.0
    for j in range(n, 2 * n):
        carried = max(carried, abs(y0[j]) / size[j])
    for i in range(f):
        j = unknown[i]
        held = max(held, abs(y0[n + j]) / size[n + j])
        moved = max(moved, abs(ahead[j] - y0[j]) / size[j])
        moved = max(moved, abs(ahead[n + j] - y0[n + j]) / size[n + j])
    ratio = min(_FASTEST, carried / max(held, 1e-300))
    rough = _LEAST + _RECOVERED * ratio * ratio if notes[mem.SETTLED] < remembered else 0.0
    for half in range(2):
        places, largest = range(half * n, half * n + n), 0.0
        for j in places:
            largest = max(largest, abs(y0[j]) / size[j])
        for j in places:
            value = relative * (atol[j] / asked + max(abs(y0[j]), abs(ahead[j])))
            allowed[j] = value + (_ROUNDED * moved + rough * largest) * size[j]
    for i in range(f):
        j, force, stiff = unknown[i], 0.0, 0.0
        for k in range(f):
            entry = abs(by_u[i, k])
            force += entry * abs(y0[unknown[k]])
            stiff += c * c * entry * size[unknown[k]] / size[j]
        allowed[n + j] += _STIFF * c * force * stiff / (1.0 + stiff) ** 2
    at_rounding = _SOLVED * moved / (relative + _ROUNDED * moved)
    enough = min(_LOOSEST, newton * asked / relative)
    context.method_floats[mem.ENOUGH] = max(at_rounding, enough)


@addressed(ERROR)
def error(context: Context, h: float, rtol: float) -> float:
    """Estimated error of the step over its tolerance, which the step has left in METHOD_FLOATS."""
    return float(context.method_floats[mem.STEP_ERROR])


implicit_method = partial(
    Method,
    last=mem.LAST,
    dense_rows=mem.DENSE_ROWS,
    safety=0.9,  # measured: share of the length that the error permits
    shrink=0.2,  # measured: least ratio of the lengths of two steps
    error=error,
    memory=mem.memory,
    foresight=0.5,  # measured: a few steps of the explicit method that leads across
)
