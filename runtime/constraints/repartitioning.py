"""Repartition in a run: when the independent coordinates are poor, are chosen anew, and logged."""

import numpy as np

from runtime.constraints.partitioning import choose_independent, column_norm
from runtime.core.array_types import Integers
from runtime.core.function_table import (
    COORDINATES,
    REPARTITION,
    column_order_of,
    dense_jacobian_of,
    jacobian_columns_of,
    jacobian_rows_of,
    jacobian_values_of,
    log_sets_of,
    log_times_of,
    parameters_of,
    row_order_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import correction_of, jacobian_of
from runtime.core.run_record import run_record
from runtime.core.workspace import (
    DELTA,
    PARTITION,
    UNIT,
    Y1,
    first_half,
    positions,
    row_of,
    second_half,
    velocities,
)

# measured: entries of H, which full pivoting keeps near one, that call for a repartition
GROWTH_LIMIT = 2.0
_CHECK_EVERY = 4  # measured: steps between probes of the independent coordinates


@inner
def log_partition(context: Integers, t: float) -> None:
    """Append the time and the independent coordinates in force (1, others 0) to the log."""
    partition = row_of(context, PARTITION)
    r = run_record(context)
    n = context[COORDINATES]
    at = r.logged_repartitions
    times = log_times_of(context)
    sets = log_sets_of(context)
    times[at] = t
    for j in range(n):
        sets[at, j] = 1 if partition[j] == 0.0 else 0
    r.logged_repartitions += 1
    r.repartitions += 1


@addressed(REPARTITION)
def repartition(context: Integers, t: float, state: int) -> int:
    """Choose the independent coordinates anew at the state in row `state`; log a change.

    Returns 1 where the choice changed, else 0. Where it did not, the limits that led here are
    doubled, so that the partition is not judged again at every step.
    """
    p = parameters_of(context)
    r = run_record(context)
    n = context[COORDINATES]
    weights = first_half(context, PARTITION)
    scale = second_half(context, PARTITION)
    before = first_half(context, DELTA)
    for j in range(n):
        before[j] = weights[j]
    r.rank = choose_independent(
        jacobian_of(context),
        t,
        positions(context, state),
        p,
        scale,
        jacobian_rows_of(context),
        jacobian_columns_of(context),
        jacobian_values_of(context),
        dense_jacobian_of(context),
        weights,
        row_order_of(context),
        column_order_of(context),
    )
    changed = 0
    for j in range(n):
        if (before[j] > 0.0) != (weights[j] > 0.0):
            changed = 1
    if changed != 0:
        r.ratio_limit = GROWTH_LIMIT
        r.growth_limit = GROWTH_LIMIT
        r.probe = 0
        log_partition(context, t)
    else:
        r.growth_limit *= 2.0
        r.ratio_limit *= 2.0
    return changed


@inner
def is_poorly_chosen(context: Integers, t: float) -> int:
    """Whether the independent coordinates no longer describe the motion well at Y1: 1, else 0.

    It costs nothing where the scaled velocities of dependent coordinates are not large against
    those of independent ones, except that every few steps all independent ones are probed together:
    probed one by one, a chain of ten bars would keep a poor partition for a hundred steps. Large
    velocities alone do not condemn a partition: a driver may cause them.
    """
    p = parameters_of(context)
    r = run_record(context)
    n = context[COORDINATES]
    if r.rank >= n:
        return 0
    correction = correction_of(context)
    column_order = column_order_of(context)
    q = positions(context, Y1)
    v = velocities(context, Y1)
    weights = first_half(context, PARTITION)
    scale = second_half(context, PARTITION)
    probe = positions(context, UNIT)
    driven = velocities(context, UNIT)
    dq = first_half(context, DELTA)
    dv = second_half(context, DELTA)
    fastest_independent = 0.0
    fastest_dependent = 0.0
    for j in range(n):
        speed = abs(v[j]) / scale[j]
        if weights[j] == 0.0:
            fastest_independent = max(fastest_independent, speed)
        else:
            fastest_dependent = max(fastest_dependent, speed)
    free = n - r.rank
    uneven = fastest_dependent > r.ratio_limit * fastest_independent
    if not uneven:
        r.check_in -= 1
        if r.check_in > 0:
            return 0
        r.check_in = _CHECK_EVERY
        r.probe += 1
        r.corrections += 2
        together = column_norm(correction, t, -r.probe, q, p, weights, scale, probe, dq, dv, driven)
        # Entries of either sign add up to some more than one of them, the more the more they are.
        return 1 if together > r.growth_limit * np.sqrt(0.75 + 0.25 * free) else 0
    largest = 0.0
    for position in range(r.rank, n):
        column = column_order[position]
        largest = max(
            largest, column_norm(correction, t, column, q, p, weights, scale, probe, dq, dv, driven)
        )
        r.corrections += 2
    if largest > r.growth_limit:
        return 1
    r.ratio_limit *= 2.0
    return 0
