"""Acceptance of a step: samples, new modes at an event, and whether the events go on for ever."""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core.arrays import Context
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import kinetic_energy_of
from runtime.core.kinds import KNOTS, RANGE
from runtime.core.loop_record import Plan, run_record
from runtime.core.outcomes import Outcome, Site
from runtime.hybrid.mode_consistency import CONSISTENT
from runtime.integrate.step import Signal, TrialStep, reject
from runtime.integrate.step_accumulation import is_endless
from runtime.integrate.step_to_event import copy_end

_FLIGHT = 0.6  # measured: of the time between two impacts; a first step that meets none
_ZENO_EVENTS = 30  # safety: events in a row with such a ratio that are no accident
_ZENO_SPAN = 1e-7  # safety: of the run; the time that eight such events must take at most
_ZENO_RATIO = 0.98  # safety: time of the last eight events over that up to one event earlier
_DOUBTS = 3  # safety: looks at shorter steps, before a balance of energy that fails ends the run
_SHORTER = 0.4  # safety: part of the step for that; its multiples do not end where the step did
_NEWTON_FAILED, _TOO_LARGE = int(TrialStep.NEWTON_FAILED), int(TrialStep.TOO_LARGE)
LEAST_ERROR = 1e-4  # safety: a smaller error of the last step says nothing of the next one


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
