"""The end of a step: the first event in it, acceptance, new modes, and whether events accumulate.

Where a switching function crosses zero inside a trial step, the step is taken again up to there.

Near an instant where the motion turns or switches infinitely often, steps are about as long as the
time left to it, or as its square, and the clock resolves them for millions of steps. Each doubling
of their number then covers a fraction of the time that the one before covered, and the sum of all
that are to come stays short of the end of the run. A run that is merely dear keeps its pace: each
doubling covers twice the time. Where the end of the run, or an instant at which a function of time
bends, comes before the limit of that sum, the run goes on. Steps that will stop shrinking look the
same until then: with a `max_steps` of the user's own a run goes on to that number.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Integers
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import kinetic_energy_of
from runtime.core.kinds import KNOTS, RANGE
from runtime.core.loop_record import Plan, run_record
from runtime.core.outcomes import Outcome, Site
from runtime.core.workspace_rows import row_of, switch_row
from runtime.hybrid.events import INSTANT, UNRESOLVED, find_crossing_at_end
from runtime.hybrid.mode_consistency import CONSISTENT
from runtime.hybrid.sliding_motion import evaluate_switching_and_rates
from runtime.integrate.step import Signal, TrialStep, reject
from runtime.linalg.vectors import copy_vector

_RETAKES = 5  # safety: steps up to an event, after which its instant is no longer improved
_STANDING = 8  # safety: events in a row at one instant, plus two for each function
FIRST_LOOK = 4096  # measured: steps before the first doubling; shorter runs end soon in any case
_SLOWER = 0.75  # safety: time of a doubling over that of the last; 2 at even pace, 1 at half of it
_DOUBLINGS = 7  # safety: slow doublings in a row, up to half a million steps, that are no accident
_OF_EVENTS = 4  # safety: the same for a run of many events, each of which is expensive
_NEAR = 0.01  # safety: of the last doubling; a run may end this close before the limit
_EVENTFUL = 16  # measured: steps per event; with fewer the events are the cause
_FLIGHT = 0.6  # measured: of the time between two impacts; a first step without an impact
_ZENO_EVENTS = 30  # safety: events in a row with such a ratio that are no accident
_ZENO_SPAN = 1e-7  # safety: of the run; the time that eight such events must take at most
_ZENO_RATIO = 0.98  # safety: time of the last eight events over that before the last event
_DOUBTS = 3  # safety: attempts with shorter steps before a failing balance of energy ends the run
_SHORTER = 0.4  # safety: part of the step for that; its multiples do not end where the step ended
_NEWTON_FAILED, _TOO_LARGE = int(TrialStep.NEWTON_FAILED), int(TrialStep.TOO_LARGE)
LEAST_ERROR = 1e-4  # safety: a smaller error of the last step says nothing of the next one


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


@inner
def next_kink(context: Context) -> float:
    """The next instant known beforehand at which a function of time bends, s; infinite for none."""
    for i in range(run_record(context).next_stop, context[ft.STOPS]):
        if context.stop_kinds[i] >= 0:
            return float(context.stop_times[i])
    return float(np.inf)


@inner
def is_endless(context: Context) -> bool:
    """Whether the run never comes to its end; called where the number of steps has doubled.

    Where events are to blame, this is left to the next of them, which has a name.
    """
    r = run_record(context)
    covered = r.t - r.pace_start
    ratio = covered / r.pace if r.pace > 0.0 else np.inf
    r.slower = r.slower + 1 if ratio < _SLOWER else 0
    eventful = _EVENTFUL * (r.events - r.pace_events) > r.pace_steps // 2
    r.pace_start, r.pace, r.pace_steps, r.pace_events = r.t, covered, 2 * r.steps, r.events
    if r.slower < (_OF_EVENTS if eventful else _DOUBLINGS):
        return False
    limit = r.t + ratio / (1.0 - ratio) * covered
    if limit - _NEAR * covered > min(next_kink(context), r.t_end):
        return False
    r.limit = limit
    if r.unlimited != 0:
        return False
    if eventful:
        r.max_events = 0
        return False
    return True


@inner
def reject_late(context: Context, reason: int, next_length: float) -> int:
    """Reject a step whose error was small enough; one across a singular position is planned anew.

    The length of that is its plan's, so that the same step would follow.
    """
    reject(context, reason, next_length)
    if run_record(context).plan == Plan.CROSSING:
        return Signal.LOOK
    return Signal.RETRY


@addressed(ft.PART)
def accept_step(context: Context) -> int:
    """Write the samples, change modes at an event, and make the step's end the next one's start.

    `run.changed` counts the events.
    """
    r, modes = run_record(context), context.modes
    g1, largest = context.g1, context.largest
    band = context.band
    r.due = r.changed = 0
    h = r.length
    if h > 0.0:
        watched = r.steps >= r.balance_at or (r.end >= r.t_end and r.power_rows >= 0)
        if watched and ft.balance_step_of(context)(context) != 0:
            if r.doubts > _DOUBTS:
                r.site = Site.STEP_BALANCE
                return Outcome.CONTRADICTED
            return reject_late(context, _TOO_LARGE, _SHORTER * h)
        if ft.emit_of(context)(context, r.t, r.end, h, r.dense_ready) < 0:
            return reject_late(context, _NEWTON_FAILED, 0.5 * h)
        r.steps += 1
        r.rejected_before = 0
        r.error_old = max(r.error, LEAST_ERROR)
        r.due = ft.accepted_of(context)(context, r.t, h)
        r.weak = r.weak + 1 if r.weak_row > 0 else 0
    r.t, r.h = r.end, r.next_length
    if r.steps >= r.pace_steps and is_endless(context):
        r.site = Site.ENDLESS_STEPS
        return Outcome.STEP_TOO_SMALL
    for k in range(modes.size):
        largest[k] = max(largest[k], abs(g1[k]))
        side = 1.0 if modes[k] != 0 else -1.0
        if r.crossing < 0 and side * g1[k] > band[k]:
            band[k] = 0.0
    if r.crossing >= 0:
        if context.table_part[r.crossing] == RANGE and modes[r.crossing] == 1:
            r.index = r.crossing
            copy_end(context, 1, 0)
            return Outcome.OUT_OF_RANGE
        if context[ft.RIGID_COUNT] != 0:
            kinetic_energy = kinetic_energy_of(context)
            r.before_event = kinetic_energy(context.q1, context.v1, context.parameters)
        r.changed = ft.transition_of(context)(context, r.crossing, r.end, r.next_length)
        r.rhs += 1
        if r.power_rows >= 0 and ft.balance_event_of(context)(context) != 0:
            r.index = r.crossing
            r.site = Site.EVENT_BALANCE
            return Outcome.CONTRADICTED
    copy_end(context, 1, 0)
    return Signal.PROCEED


@inner
def begin_anew(context: Context) -> None:
    """Start the method anew: velocities and forces are others from here on."""
    r = run_record(context)
    r.look_at = min(r.look_at, r.t)
    ft.restart_of(context)(context, r.t, r.next_length)
    if r.fixed == 0:
        first = ft.first_step_of(context)(context, r.t, r.h_max, r.rtol, r.estimate_order)
        r.h = min(r.next_length, 2.0 * first, _FLIGHT * r.flight)
        r.rhs += 1
        r.error_old, r.remembered = LEAST_ERROR, 0.0


@addressed(ft.PART)
def judge_events(context: Context) -> int:
    """After events: whether modes agree and events come to an end; then start the method anew."""
    r = run_record(context)
    if r.changed == 0:
        return Signal.PROCEED
    if context.table_part[r.crossing] == KNOTS and r.blamed == CONSISTENT:
        begin_anew(context)  # they are as many as a table has, and end nothing
        return Signal.PROCEED
    recent = context.recent_events
    span = r.t - recent[0]
    for i in range(ft.RECENT - 1):
        recent[i] = recent[i + 1]
    recent[ft.RECENT - 1] = r.t
    # While a contact bounces (a finite flight) events crowd by right: closing it ends them.
    faster = span < _ZENO_RATIO * r.event_span and r.flight == np.inf
    r.shrinking = r.shrinking + 1 if faster else 0
    r.event_span = span
    if r.blamed != CONSISTENT:
        # Where all the events kept crowd, no mode fits only because their limit is too near.
        r.index = r.blamed
        crowded = r.shrinking >= ft.RECENT
        r.site = Site.CROWDED_MODES if crowded else Site.EVENT_MODES
        return Outcome.ZENO if crowded else Outcome.INCONSISTENT
    endless = r.shrinking >= _ZENO_EVENTS and span < _ZENO_SPAN * r.duration
    if endless or r.events > r.max_events:
        r.index = r.crossing
        r.site = Site.CROWDED if endless else Site.MOST_EVENTS
        return Outcome.ZENO
    begin_anew(context)
    return Signal.PROCEED
