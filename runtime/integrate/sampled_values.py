"""Values that clocks and conditions renew: steps end there, and the method starts anew.

They are velocities without accelerations. At a sample the kernel `samples` computes those that are
due; where a run brings functions of its own, Python does.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core.arrays import Context, i8
from runtime.core.jit import ADDRESSES, addressed, compiled, inner
from runtime.core.kernel_abi import samples_of, watched_of
from runtime.core.kinds import SLIDING
from runtime.core.loop_record import run_record
from runtime.core.outcomes import Outcome, Site
from runtime.core.workspace_rows import Y0, row_of
from runtime.hybrid.impact import ON_SURFACE
from runtime.hybrid.mode_transition import LOOK_AHEAD
from runtime.integrate.clocks import CLOCK
from runtime.integrate.initialization import start_anew
from runtime.integrate.problem import WAITS
from runtime.integrate.sampling import INSTANTS, STEP_ENDS, record
from runtime.integrate.step import Signal
from runtime.linalg.vectors import copy_vector

_MOST_ROUNDS = 8  # safety: rounds at one instant in which values renew one another
ENDS, _RECONNECTS = 1, 2  # code: of `ends_run`: a run ends; joints come or go
_ONE_INSTANT = 1e-8  # accuracy: of the largest |g|; a run cannot distinguish such instants


@inner
def next_instant(context: Context) -> float:
    """The next instant at which a clock samples a value, or a sample acts, s."""
    clocks, ticks, at = context.sample_clocks, context.ticks, np.inf
    for k in range(context[ft.SAMPLED]):
        if context.sample_triggers[k] < 0:
            at = min(at, ticks[2 * k] * clocks[2 * k])
            if clocks[2 * k + 1] > 0.0:
                at = min(at, ticks[2 * k + 1] * clocks[2 * k] + clocks[2 * k + 1])
    return at


@inner
def evaluate_samples(context: Context) -> None:
    """Write the samples that are due at Y0."""
    samples_of(context)(
        run_record(context).t, context.q0, context.v0, context.parameters, context.due,
        context.sample_values,
    )  # fmt: skip


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
        due[k] = 1 if context.sample_triggers[k] < 0 and ticks[2 * k] * every <= now else 0
    evaluate_samples(context)
    return int(context[ft.CONTROLLERS])


@compiled(i8(ADDRESSES))
def take_samples(context: Context) -> int:
    """Let the samples that were computed act, or wait for their delay."""
    ticks, due, length = context.ticks, context.due, context[ft.QUEUE]
    for k in range(context[ft.SAMPLED]):
        if due[k] == 0:
            continue
        if context.sample_triggers[k] >= 0:
            context.v0[context.sampled_columns[k]] = context.sample_values[k]
            continue
        if context.sample_clocks[2 * k + 1] > 0.0:
            context.waiting_samples[k, ticks[2 * k] % length] = context.sample_values[k]
        else:
            context.v0[context.sampled_columns[k]] = context.sample_values[k]
            ticks[2 * k + 1] += 1
        ticks[2 * k] += 1
    run_record(context).sample_at = next_instant(context)
    return 0


@inner
def start_with_samples(context: Context) -> int:
    """Go on with the samples that were computed; returns the code of an outcome."""
    take_samples(context)
    outcome = start_anew(context)
    run_record(context).energy = np.nan  # forces are others from here on
    return int(outcome)


@inner
def replace_last(context: Context) -> None:
    """Give the last samples, if they are at this instant, the state and the modes from here on."""
    r = run_record(context)
    last, earliest = r.samples - 1, r.t - CLOCK * abs(r.t)
    while last >= 0 and context.out_times[last] >= earliest:
        copy_vector(row_of(context, Y0), context.out_states[last])
        copy_vector(context.modes, context.out_modes[last])
        last -= 1


@inner
def replace_samples(context: Context) -> None:
    """Give the samples of the results at this instant the values that were renewed."""
    r = run_record(context)
    if r.every_step != STEP_ENDS:
        replace_last(context)
    while r.every_step == INSTANTS and r.next_sample < context[ft.SAMPLE_TIMES]:
        at = context.sample_times[r.next_sample]
        if at > r.t + CLOCK * abs(r.t):
            break
        record(context, at, Y0)
        r.next_sample += 1


@inner
def join_changes(context: Context) -> None:
    """Let joints come or go, too, whose conditions begin to hold within the error of the run."""
    r, modes = run_record(context), context.kernel_modes
    before, now = context.watched_before, context.watched_now
    for k in range(context[ft.SWITCHES]):
        side = 1.0 if context.modes[k] != 0 else -1.0
        g, change = side * context.g0[k], side * context.r0[k] * LOOK_AHEAD * r.h
        largest = context.largest[k]
        near = g + change < -ON_SURFACE * largest and g <= min(r.rtol, _ONE_INSTANT) * largest
        if near and context.modes[k] != SLIDING and context.rigid[k] < 0:
            modes[k] = 1 - modes[k]
    watched_of(context)(r.t, context.q0, context.v0, context.parameters, modes, now)
    for i in range(context[ft.WATCHED]):
        if context.ends_run[i] == _RECONNECTS and now[i] != 0.0 and before[i] == 0.0:
            before[i] = WAITS


@inner
def update_watched(context: Context) -> int:
    """Evaluate the conditions at Y0; how many values are due as one has begun to hold.

    `run.stopped_by` receives the first that ends the run, or stays as it is.
    """
    r, modes = run_record(context), context.kernel_modes
    before, now, due = context.watched_before, context.watched_now, context.due
    for k in range(context[ft.SWITCHES]):
        modes[k] = 0 if context.modes[k] == SLIDING else context.modes[k]
    watched_of(context)(r.t, context.q0, context.v0, context.parameters, modes, now)
    count, changes = 0, False
    for k in range(context[ft.SAMPLED]):
        i = context.sample_triggers[k]
        due[k] = 1 if i >= 0 and now[i] != 0.0 and before[i] == 0.0 else 0
        count += due[k]
    for i in range(context[ft.WATCHED]):
        begins = before[i] == WAITS or (now[i] != 0.0 and before[i] == 0.0)
        if begins and context.ends_run[i] != 0 and r.stopped_by < 0:
            r.stopped_by = i
        is_last = context.ends_run[i] == ENDS and r.stopped_by == i
        waits = begins and context.ends_run[i] != 0 and not is_last
        before[i] = WAITS if waits else now[i]
        changes = changes or (waits and context.ends_run[i] == _RECONNECTS)
    if changes:
        join_changes(context)
    return count


@addressed(ft.PART)
def watch(context: Context) -> int:
    """Renew what conditions renew that have begun to hold; `Signal.STOP` where one ends the run."""
    r = run_record(context)
    for _ in range(_MOST_ROUNDS + context[ft.SAMPLED]):
        count = update_watched(context)
        if count == 0:
            return Signal.STOP if r.stopped_by >= 0 else Signal.PROCEED
        evaluate_samples(context)
        outcome = start_with_samples(context)
        replace_samples(context)
        if outcome != Outcome.OK:
            return int(outcome)
    r.index, r.site = -1, Site.CONDITIONS
    return Outcome.ZENO


@compiled(i8(ADDRESSES))
def watch_now(context: Context) -> int:
    """`watch`, for calls from Python."""
    return int(watch(context))


@compiled(i8(ADDRESSES))
def go_on(context: Context) -> int:
    """Go on with the samples that were computed, and watch what they change; a signal or code."""
    outcome = start_with_samples(context)
    replace_last(context)
    replace_samples(context)
    if outcome != Outcome.OK:
        return int(outcome)
    if context[ft.WATCHED] != 0:
        return int(watch(context))
    return Signal.PROCEED


@addressed(ft.PART)
def renew_in_step(context: Context) -> int:
    """Renew what is due; `Signal.PROCEED`, `SAMPLE` where Python does, or an outcome."""
    if compute_samples(context) > 0:
        return Signal.SAMPLE
    return int(go_on(context))
