"""Samples of a run: at the instants asked for, or at the end of every step."""

from runtime.constraints.newton_return import FAILED, WEAK
from runtime.core.array_types import Integers
from runtime.core.dense_output import interpolate
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    CORRECTING,
    EMIT,
    SAMPLE_TIMES,
    SLIDING_COUNT,
    SWITCHES,
    correct_of,
    dense_of,
    modes_of,
    out_modes_of,
    out_states_of,
    out_times_of,
    return_held_of,
    sample_times_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.run_record import run_record
from runtime.core.workspace import PROJECTION, SAMPLE, Y1, row_of


@inner
def record(context: Integers, t: float, state: int) -> None:
    """Append the state in row `state` and the modes in force to the samples."""
    modes = modes_of(context)
    out_t = out_times_of(context)
    out_y = out_states_of(context)
    out_modes = out_modes_of(context)
    r = run_record(context)
    length = 2 * context[COORDINATES]
    y = row_of(context, state)
    at = r.samples
    out_t[at] = t
    for j in range(length):
        out_y[at, j] = y[j]
    for k in range(context[SWITCHES]):
        out_modes[at, k] = modes[k]
    r.samples += 1


@addressed(EMIT)
def emit(context: Integers, t: float, t1: float, h: float, dense_ready: int) -> int:
    """Write the samples after `t` up to `t1`, corrected onto the constraints and what is held.

    Returns a negative number where a sample could not be corrected, else 0.
    """
    t_eval = sample_times_of(context)
    r = run_record(context)
    if r.every_step != 0:
        record(context, t1, Y1)
        return 0
    while r.next_sample < context[SAMPLE_TIMES] and t_eval[r.next_sample] <= t1:
        at = t_eval[r.next_sample]
        if at == t1:
            record(context, t1, Y1)
        else:
            if dense_ready == 0:
                dense_of(context)(context, t, h)
                dense_ready = 1
                r.dense_outputs += 1
                r.rhs += r.dense_calls
            interpolate(context, r.dense_rows, (at - t) / h, SAMPLE)
            # Near a singular position a return onto the constraints would move the sample further
            # than it errs.
            corrected = context[CONSTRAINT_COUNT] > 0 and context[CORRECTING] != 0
            if corrected and not r.blind_from < at < r.blind_to:
                result = correct_of(context)(context, at, SAMPLE, PROJECTION)
                if result == FAILED:
                    return FAILED
                r.corrections += result % WEAK
            if context[SLIDING_COUNT] != 0:
                return_held_of(context)(context, at, SAMPLE)
            record(context, at, SAMPLE)
        r.next_sample += 1
    return 0
