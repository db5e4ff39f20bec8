"""Samples of a run: at given instants, at the end of every step, or for a quadrature along it."""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core import function_table_slots as ft
from runtime.core.arrays import Context, Integers
from runtime.core.dense_output import interpolate
from runtime.core.jit import addressed, inner
from runtime.core.loop_record import Plan, run_record
from runtime.core.workspace_rows import PREDICTED, PROJECTION, SAMPLE, SIZE, Y1, row_of
from runtime.integrate.clocks import CLOCK
from runtime.linalg.vectors import copy_vector

_BLIND = 4.0  # measured: rounding of velocities near a singular position over its estimate
_SPARE = 8  # safety: rows of a window for samples at the instants between two steps
_ROOM = 0.49  # safety: of the time from a singular position to an end of the step across it
INSTANTS, STEP_ENDS, QUADRATURE = 0, 1, 2  # kinds of sampling: what is in `every_step`
_POINTS, WEIGHTS = np.polynomial.legendre.leggauss(5)
NODES: tuple[float, ...] = tuple(float(x) for x in _POINTS)
INTERVAL = len(NODES) + 1  # samples of an interval in a quadrature: its Gauss nodes and its end


@inner
def has_room(context: Context, end: float) -> bool:
    """Whether the samples of a step up to the instant `end` fit into the window of a sink.

    Without a sink there is room for all instants.
    """
    r = run_record(context)
    if r.every_step != INSTANTS or context[ft.OUT_ROWS] >= context[ft.SAMPLE_TIMES]:
        return True
    last = r.next_sample + context[ft.OUT_ROWS] - r.samples - _SPARE
    if last < r.next_sample:
        return False
    return bool(last >= context[ft.SAMPLE_TIMES] or context.sample_times[last] > end)


@inner
def record(context: Context, t: float, state: int) -> None:
    """Append the state in row `state` and the modes in force to the samples."""
    r = run_record(context)
    context.out_times[r.samples] = t
    copy_vector(row_of(context, state), context.out_states[r.samples])
    copy_vector(context.modes, context.out_modes[r.samples])
    r.samples += 1


@inner
def is_rounding(context: Context, at: float) -> bool:
    """Whether a return near a singular position moved the sample by no more than its rounding.

    That grows with the inverse square of the time from the position; where it reaches the tolerance
    the samples begin to be judged.
    """
    r, n = run_record(context), context[ft.COORDINATES]
    half, off = 0.5 * (r.blind_to - r.blind_from), at - 0.5 * (r.blind_to + r.blind_from)
    moved, size = 0.0, row_of(context, SIZE)
    old, new = row_of(context, PREDICTED), row_of(context, SAMPLE)
    for j in range(2 * n):
        moved = max(moved, abs(new[j] - old[j]) / (abs(old[j]) + size[j]))
    return bool(moved * off * off <= _BLIND * r.rtol * half * half)


@inner
def sample_returned(context: Integers, t: float, h: float, at: float) -> int:
    """Write row SAMPLE: the dense output at `at`, returned onto the constraints. FAILED or 0."""
    interpolate(context, run_record(context).dense_rows, (at - t) / h, SAMPLE)
    result = ft.correct_of(context)(context, at, SAMPLE, PROJECTION)
    if result == FAILED:
        return FAILED
    run_record(context).corrections += result
    return 0


@inner
def sample_between(
    context: Context, t: float, h: float, centre: float, tau: float, at: float
) -> int:
    """Write row SAMPLE: the state at `at`, within `tau` of a singular position. FAILED or 0.

    It is that of the polynomial through positions and velocities at -2, -1, 1, 2 `tau` from it,
    where a return is good (Hermite's formula). At the position itself neither is: stages of the
    dense output lie near it.
    """
    n, x = context[ft.COORDINATES], (at - centre) / tau
    total = row_of(context, PREDICTED)
    total.fill(0.0)
    for place in (-2.0, -1.0, 1.0, 2.0):
        if sample_returned(context, t, h, centre + place * tau) == FAILED:
            return FAILED
        basis, slope, own = 1.0, 0.0, 0.0  # Lagrange's polynomial, its derivative, that at `place`
        for other in (-2.0, -1.0, 1.0, 2.0):
            if other != place:
                slope = (slope * (x - other) + basis) / (place - other)
                basis *= (x - other) / (place - other)
                own += 1.0 / (place - other)
        line = 1.0 - 2.0 * own * (x - place)
        of_q, of_v = line * basis * basis, (x - place) * basis * basis * tau
        rate_q = (2.0 * line * slope - 2.0 * own * basis) * basis / tau
        rate_v = (2.0 * (x - place) * slope + basis) * basis
        node = row_of(context, SAMPLE)
        for j in range(n):
            total[j] += of_q * node[j] + of_v * node[n + j]
            total[n + j] += rate_q * node[j] + rate_v * node[n + j]
    copy_vector(total, row_of(context, SAMPLE))
    return 0


@inner
def sample(context: Integers, t: float, h: float, at: float) -> int:
    """Append the state at the instant `at` within a step, from its dense output.

    It is returned onto the constraints, and the switching surfaces of closed contacts and sliding
    modes. Returns FAILED, or 0.
    """
    r, code = run_record(context), 0
    constrained = context[ft.CONSTRAINT_COUNT] > 0 and context[ft.CORRECTING] != 0
    if constrained and r.blind_from < at < r.blind_to:
        # Near a singular position a return onto the constraints may move the sample further than it
        # errs.
        centre, half = 0.5 * (r.blind_from + r.blind_to), 0.5 * (r.blind_to - r.blind_from)
        tau = min(half, _ROOM * min(centre - t, t + h - centre))
        code = FAILED
        if abs(at - centre) < tau:
            code = sample_between(context, t, h, centre, tau, at)
        if code == FAILED:
            interpolate(context, r.dense_rows, (at - t) / h, SAMPLE)
            copy_vector(row_of(context, SAMPLE), row_of(context, PREDICTED))
            code = sample_returned(context, t, h, at)
            if code == FAILED or is_rounding(context, at):
                copy_vector(row_of(context, PREDICTED), row_of(context, SAMPLE))
                code = 0
    elif constrained:
        code = sample_returned(context, t, h, at)
        if code == FAILED and r.plan == Plan.CROSSING:
            # The position lies here, and not where it was foreseen.
            half = 0.5 * (r.blind_to - r.blind_from)
            tau = min(half, _ROOM * min(at - t, t + h - at))
            code = sample_between(context, t, h, at, tau, at)
    else:
        interpolate(context, r.dense_rows, (at - t) / h, SAMPLE)
    if code == FAILED:
        return FAILED
    if context[ft.SLIDING_COUNT] != 0:
        ft.return_to_surfaces_of(context)(context, at, SAMPLE)
    record(context, at, SAMPLE)
    return 0


@inner
def sample_nodes(context: Context, t: float, t1: float, h: float) -> int:
    """Append INTERVAL samples for each interval between the step's ends and the instants in it.

    These are Gauss' nodes and the interval's end. Returns FAILED, without samples, or 0.
    """
    r, t_eval = run_record(context), context.sample_times
    samples, next_sample = r.samples, r.next_sample
    low, code = t, 0
    while low < t1 and code == 0:
        while r.next_sample < context[ft.SAMPLE_TIMES] and t_eval[r.next_sample] <= low:
            r.next_sample += 1
        high = t1
        if r.next_sample < context[ft.SAMPLE_TIMES]:
            high = min(high, t_eval[r.next_sample])
        for node in NODES:
            if code == 0:
                code = sample(context, t, h, 0.5 * (low + high) + 0.5 * (high - low) * node)
        if high == t1:
            record(context, t1, Y1)
        elif code == 0:
            code = sample(context, t, h, high)
        low = high
    if code != 0:
        r.samples, r.next_sample = samples, next_sample
    return code


@addressed(ft.EMIT)
def emit(context: Context, t: float, t1: float, h: float, dense_ready: int) -> int:
    """Write the samples after `t` up to `t1`; negative where one could not be corrected, else 0."""
    r, t_eval = run_record(context), context.sample_times
    if r.every_step == STEP_ENDS:
        record(context, t1, Y1)
        return 0
    within = r.next_sample < context[ft.SAMPLE_TIMES] and t_eval[r.next_sample] < t1
    if dense_ready == 0 and (within or r.every_step == QUADRATURE):
        ft.dense_of(context)(context, t, h)
        r.dense_outputs += 1
        r.rhs += r.dense_calls
    if r.every_step == QUADRATURE:
        return sample_nodes(context, t, t1, h)
    while r.next_sample < context[ft.SAMPLE_TIMES] and t_eval[r.next_sample] <= t1:
        at = t_eval[r.next_sample]
        if t1 + CLOCK * abs(t1) >= r.sample_at and at >= t1 - CLOCK * abs(t1):
            break  # it has the values that are renewed now
        if at == t1:
            record(context, t1, Y1)
        elif sample(context, t, h, at) == FAILED:
            return FAILED
        r.next_sample += 1
    return 0
