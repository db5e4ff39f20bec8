"""One trial step: stages, return onto the constraints, derivative at the end, error."""

import numpy as np

from runtime.compiled import compiled, inner
from runtime.constraints.correction import FAILED, WEAK
from runtime.constraints.partition import choose, growth
from runtime.integrate.bent import STEP
from runtime.integrate.field import field
from runtime.integrate.signatures import ATTEMPT, REPARTITION, Integers, Vector
from runtime.integrate.slots import (
    COLUMN_ORDER,
    CONSTRAINT_COUNT,
    CORRECTING,
    DENSE_JACOBIAN,
    HELD,
    JACOBIAN_COLUMNS,
    JACOBIAN_ROWS,
    JACOBIAN_VALUES,
    LOG_ROWS,
    LOG_SETS,
    LOG_TIMES,
    NONZEROS,
    ROW_ORDER,
    SETTINGS,
    constraints_of,
    correct_of,
    correction_of,
    error_of,
    jacobian_of,
    repartition_of,
    return_held_of,
    stages_of,
)
from runtime.integrate.views import (
    floats_at,
    integer_matrix_at,
    integers_at,
    matrix_at,
    view,
)
from runtime.integrate.workspace import (
    ATOL,
    DELTA,
    FREE,
    MISSING,
    PARTITION,
    PREDICTED,
    PROJECTION,
    ROWS,
    SAMPLE,
    SIZE,
    UNIT,
    Y1,
    K,
    Run,
)

DONE = 0
NEWTON = 1
NOT_FINITE = 2
TOO_LARGE = 3  # the error is over the tolerance

NEVER, BY_PARTITION, BY_PROJECTION, IF_DRIFTED = 0, 1, 2, 3
"""When and how a step is brought back onto the constraints: the number CORRECTING of the table."""

GROWTH_LIMIT = 2.0  # entries of H that full pivoting keeps near one
_CHECK_EVERY = 4  # steps between probes of one independent coordinate
_MANY_ITERATIONS = 4


@inner
def log_partition(machine: Integers, t: float, w: Vector, run: Run) -> None:
    """Append the time and the independent coordinates in force (1, others 0) to the log."""
    r = run[0]
    n = w.size // (2 * ROWS)
    capacity = machine[LOG_ROWS]
    at = r.logged_repartitions
    times = floats_at(machine, LOG_TIMES, capacity)
    sets = integer_matrix_at(machine, LOG_SETS, capacity, n)
    times[at] = t
    for j in range(n):
        sets[at, j] = 1 if w[PARTITION * 2 * n + j] == 0.0 else 0
    r.logged_repartitions += 1
    r.repartitions += 1


@compiled(REPARTITION)
def repartition(machine: Integers, t: float, state: int, w: Vector, run: Run, p: Vector) -> int:
    """Choose the independent coordinates anew at the state in row `state`; log a change.

    Returns 1 where the choice changed, else 0. Where it did not, the limits that led here are
    doubled, so that the same question is not asked at every step.
    """
    r = run[0]
    n = w.size // (2 * ROWS)
    m = machine[CONSTRAINT_COUNT]
    nonzeros = machine[NONZEROS]
    weights = view(w, PARTITION * 2 * n, n)
    scale = view(w, PARTITION * 2 * n + n, n)
    before = view(w, DELTA * 2 * n, n)
    for j in range(n):
        before[j] = weights[j]
    r.rank = choose(
        jacobian_of(machine),
        t,
        view(w, state * 2 * n, n),
        p,
        scale,
        integers_at(machine, JACOBIAN_ROWS, nonzeros),
        integers_at(machine, JACOBIAN_COLUMNS, nonzeros),
        floats_at(machine, JACOBIAN_VALUES, nonzeros),
        matrix_at(machine, DENSE_JACOBIAN, m, n),
        weights,
        integers_at(machine, ROW_ORDER, m),
        integers_at(machine, COLUMN_ORDER, n),
    )
    changed = 0
    for j in range(n):
        if (before[j] > 0.0) != (weights[j] > 0.0):
            changed = 1
    if changed != 0:
        r.ratio_limit = GROWTH_LIMIT
        r.growth_limit = GROWTH_LIMIT
        r.probe = 0
        log_partition(machine, t, w, run)
    else:
        r.growth_limit *= 2.0
        r.ratio_limit *= 2.0
    return changed


@inner
def poorly_chosen(machine: Integers, t: float, w: Vector, p: Vector, run: Run) -> int:
    """1 where the independent coordinates no longer describe the motion well at Y1, else 0.

    Costs nothing where the scaled velocities of dependent coordinates are not large against those
    of independent ones, except that now and then one independent coordinate is probed. Large
    velocities alone do not condemn a partition: a driver may cause them.
    """
    r = run[0]
    n = w.size // (2 * ROWS)
    if r.rank >= n:
        return 0
    correction = correction_of(machine)
    column_order = integers_at(machine, COLUMN_ORDER, n)
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


@inner
def drifted(machine: Integers, t: float, w: Vector, rtol: float, p: Vector) -> bool:
    """Whether a constraint is off by more than a step's tolerance at Y1."""
    length = w.size // ROWS
    n = length // 2
    phi = view(w, DELTA * length, machine[CONSTRAINT_COUNT])
    constraints_of(machine)(t, view(w, Y1 * length, n), p, phi)
    tolerance = np.inf
    for j in range(n):
        tolerance = min(tolerance, w[ATOL * length + j] + rtol * w[SIZE * length + j])
    largest = 0.0
    for i in range(phi.size):
        largest = max(largest, abs(phi[i]))
    return bool(largest > tolerance)


@inner
def projected(machine: Integers, t: float, w: Vector, run: Run, p: Vector) -> int:
    """Move Y1 onto the constraints by the least in the metric of the masses, if it must be."""
    r = run[0]
    length = w.size // ROWS
    if machine[CORRECTING] == IF_DRIFTED and not drifted(machine, t, w, r.rtol, p):
        return DONE
    result = correct_of(machine)(machine, t, Y1, PROJECTION, w, p)
    r.newton += 1
    if result == FAILED:
        return NEWTON
    r.corrections += result % WEAK
    for j in range(length // 2):
        moved = abs(w[Y1 * length + j] - w[PREDICTED * length + j])
        r.largest_dq = max(r.largest_dq, moved)
    return DONE


@inner
def returned(machine: Integers, t: float, w: Vector, run: Run, p: Vector) -> int:
    """Bring Y1 back onto the constraints, with another partition where this one is poor."""
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    correct = correct_of(machine)
    repartition = repartition_of(machine)
    y1 = view(w, Y1 * length, length)
    predicted = view(w, PREDICTED * length, length)
    finite = True
    for j in range(length):
        predicted[j] = y1[j]
        finite = finite and np.isfinite(y1[j])
    if not finite:
        return NOT_FINITE
    if machine[CORRECTING] != BY_PARTITION:
        return projected(machine, t, w, run, p)
    if FREE < r.plan < MISSING:
        # No coordinates are independent at a singular position, and near it none are good.
        result = correct(machine, t, Y1, PROJECTION, w, p)
        r.newton += 1
        if result == FAILED:
            return NEWTON
        r.corrections += result % WEAK
        return DONE
    if poorly_chosen(machine, t, w, p, run) != 0:
        repartition(machine, t, Y1, w, run, p)
    result = correct(machine, t, Y1, PARTITION, w, p)
    r.newton += 1
    if result == FAILED or result >= _MANY_ITERATIONS:
        kept = view(w, SAMPLE * length, length)
        for j in range(length):
            kept[j] = y1[j]
            y1[j] = predicted[j]
        if repartition(machine, t, Y1, w, run, p) != 0:
            result = correct(machine, t, Y1, PARTITION, w, p)
            r.newton += 1
        else:
            for j in range(length):
                y1[j] = kept[j]
    if result == FAILED:
        return NEWTON
    r.corrections += result % WEAK
    for j in range(n):
        r.largest_dq = max(r.largest_dq, abs(y1[j] - predicted[j]))
    return DONE


@compiled(ATTEMPT)
def attempt(
    machine: Integers,
    t: float,
    h: float,
    w: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """Step from Y0 over `h` to Y1, corrected, with its derivative and the error `run.error`.

    Returns `DONE`, or why the step cannot be accepted.
    """
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    floats_at(machine, SETTINGS, 2)[STEP] = h
    taken = stages_of(machine)(machine, t, h, w, run, p, modes, lam)
    r.rhs += r.stage_calls
    if taken < 0:
        return NEWTON
    r.corrections += taken
    if lam.size > 0 and machine[CORRECTING] != NEVER:
        code = returned(machine, t + h, w, run, p)
        if code != DONE:
            return code
    if machine[HELD] != 0:
        return_held_of(machine)(machine, t + h, Y1, w, p, modes, lam)
    slope = view(w, (K + r.last) * length, n)
    a = view(w, (K + r.last) * length + n, n)
    v = view(w, Y1 * length + n, n)
    r.weak_row = field(machine, t + h, view(w, Y1 * length, n), v, p, modes, a, lam)
    r.rhs += 1
    for j in range(n):
        slope[j] = v[j]
    r.error = error_of(machine)(machine, h, r.rtol, w)
    if not np.isfinite(r.error):
        return NOT_FINITE
    if r.error > r.permitted and r.fixed == 0:
        return TOO_LARGE
    return DONE
