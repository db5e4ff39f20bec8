"""One trial step: stages, return onto the constraints, derivative at the end, error."""

import numpy as np
from numba import types

from runtime.compiled import compiled, inner
from runtime.constraints.correction import FAILED, WEAK
from runtime.constraints.partition import choose, growth
from runtime.integrate.signatures import (
    Accelerations,
    Correct,
    Correction,
    Error,
    IntegerMatrix,
    Integers,
    Jacobian,
    Kernel,
    Matrix,
    Stages,
    Vector,
    f8,
    i8,
    integer_matrix,
    integers,
    matrix,
    vector,
)
from runtime.integrate.views import view
from runtime.integrate.workspace import (
    DELTA,
    PARTITION,
    PREDICTED,
    ROWS,
    SAMPLE,
    UNIT,
    Y1,
    K,
    Run,
    run_record,
)

DONE = 0
NEWTON = 1
NOT_FINITE = 2
TOO_LARGE = 3  # the error is over the tolerance

GROWTH_LIMIT = 10.0  # entries of H that full pivoting keeps near one
_CHECK_EVERY = 4  # steps between probes of one independent coordinate
_MANY_ITERATIONS = 4


@inner
def log_partition(
    t: float, w: Vector, run: Run, column_order: Integers, times: Vector, sets: IntegerMatrix
) -> None:
    """Append the time and the independent coordinates in force (1, others 0) to the log."""
    r = run[0]
    n = column_order.size
    at = r.logged_repartitions
    times[at] = t
    for j in range(n):
        sets[at, j] = 1 if w[PARTITION * 2 * n + j] == 0.0 else 0
    r.logged_repartitions += 1
    r.repartitions += 1


REPARTITION = i8(
    Jacobian,
    f8,
    i8,
    vector,
    vector,
    run_record,
    integers,
    integers,
    vector,
    matrix,
    integers,
    integers,
    vector,
    integer_matrix,
)
Repartition = types.FunctionType(REPARTITION)


@compiled(REPARTITION)
def repartition(
    jacobian: Kernel,
    t: float,
    state: int,
    w: Vector,
    p: Vector,
    run: Run,
    rows: Integers,
    columns: Integers,
    values: Vector,
    dense: Matrix,
    row_order: Integers,
    column_order: Integers,
    times: Vector,
    sets: IntegerMatrix,
) -> int:
    """Choose the independent coordinates anew at the state in row `state`; log a change.

    Returns 1 where the choice changed, else 0. Where it did not, the limits that led here are
    doubled, so that the same question is not asked at every step.
    """
    r = run[0]
    n = column_order.size
    weights = view(w, PARTITION * 2 * n, n)
    scale = view(w, PARTITION * 2 * n + n, n)
    before = view(w, DELTA * 2 * n, n)
    for j in range(n):
        before[j] = weights[j]
    q = view(w, state * 2 * n, n)
    r.rank = choose(
        jacobian, t, q, p, scale, rows, columns, values, dense, weights, row_order, column_order
    )
    changed = 0
    for j in range(n):
        if (before[j] > 0.0) != (weights[j] > 0.0):
            changed = 1
    if changed != 0:
        r.ratio_limit = GROWTH_LIMIT
        r.growth_limit = GROWTH_LIMIT
        r.probe = 0
        log_partition(t, w, run, column_order, times, sets)
    else:
        r.growth_limit *= 2.0
        r.ratio_limit *= 2.0
    return changed


@inner
def poorly_chosen(
    correction: Kernel, t: float, w: Vector, p: Vector, run: Run, column_order: Integers
) -> int:
    """1 where the independent coordinates no longer describe the motion well at Y1, else 0.

    Costs nothing where the scaled velocities of dependent coordinates are not large against those
    of independent ones, except that now and then one independent coordinate is probed. Large
    velocities alone do not condemn a partition: a driver may cause them.
    """
    r = run[0]
    n = column_order.size
    if r.rank >= n:
        return 0
    q = view(w, Y1 * 2 * n, n)
    v = view(w, Y1 * 2 * n + n, n)
    weights = view(w, PARTITION * 2 * n, n)
    scale = view(w, PARTITION * 2 * n + n, n)
    probe = view(w, UNIT * 2 * n, n)
    rest = view(w, UNIT * 2 * n + n, n)
    dq = view(w, DELTA * 2 * n, n)
    dv = view(w, DELTA * 2 * n + n, n)
    held = 0.0
    carried = 0.0
    for j in range(n):
        speed = abs(v[j]) / scale[j]
        if weights[j] == 0.0:
            held = max(held, speed)
        else:
            carried = max(carried, speed)
    first, last = r.probe, r.probe
    if carried > r.ratio_limit * held:
        first, last = r.rank, n
    else:
        r.check_in -= 1
        if r.check_in > 0:
            return 0
        r.check_in = _CHECK_EVERY
        first = r.rank + r.probe % (n - r.rank)
        last = first + 1
        r.probe += 1
    largest = 0.0
    for position in range(first, last):
        largest = max(
            largest,
            growth(
                correction, t, column_order[position], q, p, weights, scale, probe, dq, dv, rest
            ),
        )
        r.corrections += 2
    if largest > r.growth_limit:
        return 1
    if last - first == n - r.rank and carried > r.ratio_limit * held:
        r.ratio_limit *= 2.0
    return 0


ATTEMPT = i8(
    Accelerations,
    Correction,
    Correct,
    Jacobian,
    Repartition,
    Stages,
    Error,
    f8,
    f8,
    vector,
    run_record,
    vector,
    integers,
    vector,
    integers,
    integers,
    vector,
    matrix,
    integers,
    integers,
    vector,
    integer_matrix,
)
Attempt = types.FunctionType(ATTEMPT)


@compiled(ATTEMPT)
def attempt(
    accelerations: Kernel,
    correction: Kernel,
    correct: Kernel,
    jacobian: Kernel,
    repartition: Kernel,
    stages: Kernel,
    error: Kernel,
    t: float,
    h: float,
    w: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    lam: Vector,
    rows: Integers,
    columns: Integers,
    values: Vector,
    dense: Matrix,
    row_order: Integers,
    column_order: Integers,
    times: Vector,
    sets: IntegerMatrix,
) -> int:
    """Step from Y0 over `h` to Y1, corrected, with its derivative and the error `run.error`.

    Returns `DONE`, or why the step cannot be accepted.
    """
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    y1 = view(w, Y1 * length, length)
    predicted = view(w, PREDICTED * length, length)
    taken = stages(accelerations, correction, correct, t, h, w, p, modes, lam, r.each_stage)
    r.rhs += r.stage_calls
    if taken < 0:
        return NEWTON
    r.corrections += taken
    if lam.size > 0:
        finite = True
        for j in range(length):
            predicted[j] = y1[j]
            finite = finite and np.isfinite(y1[j])
        if not finite:
            return NOT_FINITE
        if poorly_chosen(correction, t + h, w, p, run, column_order) != 0:
            repartition(
                jacobian, t + h, Y1, w, p, run, rows, columns, values, dense, row_order,
                column_order, times, sets,
            )  # fmt: skip
        result = correct(correction, t + h, Y1, PARTITION, w, p)
        r.newton += 1
        if result == FAILED or result >= _MANY_ITERATIONS:
            for j in range(length):
                view(w, SAMPLE * length, length)[j] = y1[j]
                y1[j] = predicted[j]
            changed = repartition(
                jacobian, t + h, Y1, w, p, run, rows, columns, values, dense, row_order,
                column_order, times, sets,
            )  # fmt: skip
            if changed != 0:
                result = correct(correction, t + h, Y1, PARTITION, w, p)
                r.newton += 1
            else:
                for j in range(length):
                    y1[j] = view(w, SAMPLE * length, length)[j]
        if result == FAILED:
            return NEWTON
        r.corrections += result % WEAK
        for j in range(n):
            r.largest_dq = max(r.largest_dq, abs(y1[j] - predicted[j]))
    slope = view(w, (K + r.last) * length, n)
    a = view(w, (K + r.last) * length + n, n)
    v = view(w, Y1 * length + n, n)
    r.weak_row = accelerations(t + h, view(w, Y1 * length, n), v, p, modes, a, lam)
    r.rhs += 1
    for j in range(n):
        slope[j] = v[j]
    r.error = error(h, r.rtol, w)
    if not np.isfinite(r.error):
        return NOT_FINITE
    if r.error > 1.0 and r.fixed == 0:
        return TOO_LARGE
    return DONE
