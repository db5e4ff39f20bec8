"""Values that clocks renew, and keep in between: steps end at samples, and the method starts anew.

They are velocities without accelerations. At a sample the kernel `samples` computes those that are
due; where a run brings functions of its own, Python does.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core.array_types import Context, i8
from runtime.core.jit import ADDRESSES, addressed, compiled, inner
from runtime.core.kernel_abi import samples_of
from runtime.core.loop_record import run_record
from runtime.core.outcomes import Outcome
from runtime.core.workspace_rows import Y0, row_of
from runtime.integrate.clocks import CLOCK
from runtime.integrate.initialization import start_anew
from runtime.integrate.sampling import INSTANTS, QUADRATURE, record
from runtime.integrate.step import Signal
from runtime.linalg.vectors import copy_vector


@inner
def next_instant(context: Context) -> float:
    """The next instant at which a value is sampled or acts, s."""
    clocks, ticks, at = context.sample_clocks, context.ticks, np.inf
    for k in range(context[ft.SAMPLED]):
        at = min(at, ticks[2 * k] * clocks[2 * k])
        if clocks[2 * k + 1] > 0.0:
            at = min(at, ticks[2 * k + 1] * clocks[2 * k] + clocks[2 * k + 1])
    return at


@compiled(i8(ADDRESSES))
def compute_samples(context: Context) -> int:
    """Let those values act whose delay is over, and compute those that are due, at Y0.

    Returns how many of them Python computes.
    """
    r = run_record(context)
    clocks, ticks, due = context.sample_clocks, context.ticks, context.due
    waiting, length = context.waiting_samples, context[ft.QUEUE]
    now = r.t + CLOCK * abs(r.t)
    for k in range(context[ft.SAMPLED]):
        every, delay = clocks[2 * k], clocks[2 * k + 1]
        while delay > 0.0 and ticks[2 * k + 1] < ticks[2 * k]:
            if ticks[2 * k + 1] * every + delay > now:
                break
            context.v0[context.sampled_columns[k]] = waiting[k, ticks[2 * k + 1] % length]
            ticks[2 * k + 1] += 1
        due[k] = 1 if ticks[2 * k] * every <= now else 0
    values = context.sample_values
    samples_of(context)(r.t, context.q0, context.v0, context.parameters, due, values)
    return int(context[ft.CONTROLLERS])


@compiled(i8(ADDRESSES))
def take_samples(context: Context) -> int:
    """Let the samples that were computed act, or wait for their delay; the next instant."""
    r = run_record(context)
    clocks, ticks, due = context.sample_clocks, context.ticks, context.due
    for k in range(context[ft.SAMPLED]):
        if due[k] == 0:
            continue
        if clocks[2 * k + 1] > 0.0:
            context.waiting_samples[k, ticks[2 * k] % context[ft.QUEUE]] = context.sample_values[k]
        else:
            context.v0[context.sampled_columns[k]] = context.sample_values[k]
            ticks[2 * k + 1] += 1
        ticks[2 * k] += 1
    r.sample_at = next_instant(context)
    return 0


@compiled(i8(ADDRESSES))
def go_on(context: Context) -> int:
    """Go on with the samples that were computed; returns `Signal.PROCEED` or an outcome's code."""
    r = run_record(context)
    take_samples(context)
    outcome = start_anew(context)
    r.energy = np.nan  # forces are others from here on
    last = r.samples - 1
    if r.every_step == QUADRATURE and last >= 0 and context.out_times[last] == r.t:
        copy_vector(row_of(context, Y0), context.out_states[last])
    while r.every_step == INSTANTS and r.next_sample < context[ft.SAMPLE_TIMES]:
        at = context.sample_times[r.next_sample]
        if at > r.t + CLOCK * abs(r.t):
            break
        record(context, at, Y0)
        r.next_sample += 1
    return Signal.PROCEED if outcome == Outcome.OK else outcome


@addressed(ft.PART)
def renew_in_step(context: Context) -> int:
    """Renew what is due; `Signal.PROCEED`, `SAMPLE` where Python does, or an outcome."""
    if compute_samples(context) > 0:
        return Signal.SAMPLE
    return int(go_on(context))
