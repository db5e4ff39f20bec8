"""Repartition in a run: poor independent coordinates are found, replaced, and logged."""

import numpy as np

from runtime.constraints.partitioning import choose_independent, column_norm
from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context
from runtime.core.jit import addressed, inner
from runtime.core.loop_record import run_record
from runtime.linalg.vectors import copy_vector

GROWTH_LIMIT = 2.0  # measured: entry of H, near 1 after full pivoting, that asks for a repartition
_CHECK_EVERY = 4  # measured: steps between probes of the independent coordinates


@inner
def log_partition(context: Context, t: float) -> None:
    """Append the time and the independent coordinates in force (1, others 0) to the log."""
    r, weights = run_record(context), context.correction_weights
    at = r.logged_repartitions
    context.log_times[at] = t
    for j in range(weights.size):
        context.log_sets[at, j] = 1 if weights[j] == 0.0 else 0
    r.logged_repartitions += 1
    r.repartitions += 1


@addressed(ft.REPARTITION)
def repartition(context: Context, t: float, state: int) -> int:
    """Choose the independent coordinates anew at the state in row `state`; log a change.

    Returns 1 where the choice changed, else 0. Where it did not, the limits that led here are
    doubled, so that the partition is not judged again at every step.
    """
    r = run_record(context)
    weights, before = context.correction_weights, context.first_scratch
    copy_vector(weights, before)
    r.rank = choose_independent(context, t, ws.positions(context, state))
    changed = 0
    for j in range(weights.size):
        if (before[j] > 0.0) != (weights[j] > 0.0):
            changed = 1
    if changed != 0:
        r.ratio_limit = r.growth_limit = GROWTH_LIMIT
        r.probe = 0
        log_partition(context, t)
    else:
        r.growth_limit *= 2.0
        r.ratio_limit *= 2.0
    return changed


@inner
def is_poorly_chosen(context: Context, t: float) -> int:
    """Whether the independent coordinates no longer describe the motion well at Y1: 1, else 0.

    It costs nothing where the scaled velocities of dependent coordinates are not large against
    those of independent ones, except that every few steps all independent ones are probed together:
    probed one by one, a chain of ten bars would keep a poor partition for a hundred steps. Large
    velocities alone do not condemn a partition: a driver may cause them.
    """
    r, n = run_record(context), context[ft.COORDINATES]
    if r.rank >= n:
        return 0
    v, weights, scale = context.v1, context.correction_weights, context.scale
    fastest_independent, fastest_dependent = 0.0, 0.0
    for j in range(n):
        speed = abs(v[j]) / scale[j]
        if weights[j] == 0.0:
            fastest_independent = max(fastest_independent, speed)
        else:
            fastest_dependent = max(fastest_dependent, speed)
    if not fastest_dependent > r.ratio_limit * fastest_independent:
        r.check_in -= 1
        if r.check_in > 0:
            return 0
        r.check_in = _CHECK_EVERY
        r.probe += 1
        r.corrections += 2
        # Entries of either sign add up to some more than one of them, the more the more they are.
        limit = r.growth_limit * np.sqrt(0.75 + 0.25 * (n - r.rank))
        return 1 if column_norm(context, t, -r.probe) > limit else 0
    largest = 0.0
    for position in range(r.rank, n):
        largest = max(largest, column_norm(context, t, context.column_order[position]))
        r.corrections += 2
    if largest > r.growth_limit:
        return 1
    r.ratio_limit *= 2.0
    return 0
