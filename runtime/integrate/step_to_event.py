"""The end of a step at the first event in it.

Where a switching function crosses zero inside a trial step, the step is taken again up to there.
"""

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Integers
from runtime.core.jit import addressed, inner
from runtime.core.kinds import RANGE
from runtime.core.loop_record import run_record
from runtime.core.outcomes import Outcome, Site
from runtime.core.workspace_rows import row_of, switch_row
from runtime.hybrid.events import INSTANT, UNRESOLVED, find_crossing_at_end
from runtime.hybrid.sliding_motion import evaluate_switching_and_rates
from runtime.integrate.step import Signal, TrialStep, reject
from runtime.linalg.vectors import copy_vector

_RETAKES = 5  # safety: steps up to an event before its instant is taken as it is
_STANDING = 8  # safety: events in a row without time between them, and two for each function


@inner
def copy_end(context: Integers, source: int, target: int) -> None:
    """Copy state, derivative and switching functions between the ends, 0 and 1, of the step."""
    last = run_record(context).last
    copy_vector(row_of(context, ws.Y0 + source), row_of(context, ws.Y0 + target))
    copy_vector(row_of(context, ws.K + source * last), row_of(context, ws.K + target * last))
    for g in (ws.G0, ws.R0):
        copy_vector(switch_row(context, g + 2 * source), switch_row(context, g + 2 * target))


@addressed(ft.PART)
def stay(context: Integers) -> int:
    """At an event at this very instant: no step, only a change of modes."""
    r = run_record(context)
    r.length, r.end = 0.0, r.t
    copy_end(context, 0, 1)
    r.standing += 1
    if r.standing > _STANDING + 2 * context[ft.SWITCHES]:
        r.index = r.crossing
        r.site = Site.STANDING
        return Outcome.ZENO
    return Signal.PROCEED


@addressed(ft.PART)
def retake(context: Context) -> int:
    """Take the step again up to the event, by Newton's method on its switching function."""
    r = run_record(context)
    g1, r1 = context.g1, context.r1
    largest, band = context.largest, context.band
    crossing, t, h, reach = r.crossing, r.t, r.length, r.reach
    take_trial_step = ft.trial_step_of(context)
    code = 0
    r.standing = 0
    for turn in range(_RETAKES):
        r.end = t + h
        code = take_trial_step(context, t, h)
        r.retakes += 1
        if code != TrialStep.DONE:
            break
        evaluate_switching_and_rates(context, r.end, ws.Y1, ws.K + r.last, ws.G1)
        g = g1[crossing]
        if abs(g) <= 4e-16 * largest[crossing] or turn == _RETAKES - 1:
            break
        polished = h - g / r1[crossing]
        if not (0.0 < polished <= reach) or abs(polished - h) > 1e-3 * reach:
            break
        if t + polished == r.end:
            break
        h = polished
    r.length = h
    if code != TrialStep.DONE:
        return reject(context, code, 0.5 * h)
    side = 1.0 if context.modes[crossing] != 0 else -1.0
    near = max(1e-11 * largest[crossing], 1e-12 * reach * abs(r1[crossing]), band[crossing])
    if side * g1[crossing] > near:
        r.crossing = -1  # it only came close
    return Signal.PROCEED


@addressed(ft.PART)
def end_at_event(context: Context) -> int:
    """End the step at the first event in it; `run.crossing` receives its function, or -1.

    `run.length` becomes the time to it, `run.reach` the step's own.
    """
    r = run_record(context)
    h, r.crossing, r.dense_ready = r.length, -1, 0
    if context[ft.SWITCHES] == 0:
        return Signal.PROCEED
    suspects = ft.screen_step_of(context)(context, r.t, h, r.end)
    if suspects == UNRESOLVED:
        return reject(context, UNRESOLVED, r.stretch * h)
    r.next_length = min(r.next_length, h * r.stretch)
    if suspects > 0:
        ft.dense_of(context)(context, r.t, h)
        r.dense_ready = 1
        r.dense_outputs += 1
        r.rhs += r.dense_calls
        x = ft.locate_of(context)(context)
        if x <= 1.0:
            r.crossing, r.length = context.crossed[0], x * h
    unresolved = INSTANT * max(abs(r.t), abs(r.t_end))
    late = r.crossing >= 0 and r.t + r.length >= r.t_end - unresolved
    if late and context.table_part[r.crossing] == RANGE:
        r.crossing, r.length = -1, h  # the table and the run end together
    if r.crossing < 0 and r.end >= r.t_end:
        r.crossing = find_crossing_at_end(context, r.end)
    if r.crossing < 0:
        return Signal.PROCEED
    r.reach, r.dense_ready = h, 0
    if r.end >= r.t_end:
        # The last sample is that of what follows the event.
        r.reach = r.t_end - INSTANT * abs(r.t_end) - r.t
        r.length = min(r.length, r.reach)
    if r.length <= INSTANT * max(abs(r.t), r.h_min):
        return stay(context)
    return retake(context)
