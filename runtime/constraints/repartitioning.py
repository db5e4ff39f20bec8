"""The choice of independent coordinates in a run: when it is poor, made anew, and logged."""

import numpy as np

from runtime.constraints.partitioning import choose, growth
from runtime.core.array_views import (
    floats_at,
    integer_matrix_at,
    integers_at,
    matrix_at,
    view,
)
from runtime.core.function_table import (
    COLUMN_ORDER,
    CONSTRAINT_COUNT,
    DENSE_JACOBIAN,
    JACOBIAN_COLUMNS,
    JACOBIAN_ROWS,
    JACOBIAN_VALUES,
    LOG_ROWS,
    LOG_SETS,
    LOG_TIMES,
    NONZEROS,
    ROW_ORDER,
    correction_of,
    jacobian_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.signatures import REPARTITION, Integers, Vector
from runtime.core.workspace import DELTA, PARTITION, ROWS, UNIT, Y1, Run

# measured: entries of H, which full pivoting keeps near one, that call for a repartition
GROWTH_LIMIT = 2.0
_CHECK_EVERY = 4  # measured: steps between probes of the independent coordinates


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


@addressed(REPARTITION)
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
    of independent ones, except that now and then the independent ones are probed, all together:
    one after the other, a chain of ten bars would have hung from its heights for a hundred steps.
    Large velocities alone do not condemn a partition: a driver may cause them.
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
    free = n - r.rank
    uneven = carried > r.ratio_limit * held
    if not uneven:
        r.check_in -= 1
        if r.check_in > 0:
            return 0
        r.check_in = _CHECK_EVERY
        r.probe += 1
        r.corrections += 2
        together = growth(correction, t, -r.probe, q, p, weights, scale, probe, dq, dv, rest)
        # Entries of either sign add up to some more than one of them, the more the more they are.
        return 1 if together > r.growth_limit * np.sqrt(0.75 + 0.25 * free) else 0
    largest = 0.0
    for position in range(r.rank, n):
        column = column_order[position]
        largest = max(
            largest, growth(correction, t, column, q, p, weights, scale, probe, dq, dv, rest)
        )
        r.corrections += 2
    if largest > r.growth_limit:
        return 1
    r.ratio_limit *= 2.0
    return 0
