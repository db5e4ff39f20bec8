"""The loop over steps.

`advance` is compiled once. It calls the kernels, the method and the larger parts of the loop by
the function table; all state lies in the run's arrays, so that a run can stop after any step and go
on with the same bits. Between the parts of a step its length, end and event travel in the run's
record.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core.arrays import Context, Integers, i8
from runtime.core.jit import ADDRESSES, addressed, inner, unlocked
from runtime.core.loop_record import Plan, run_record
from runtime.core.outcomes import Outcome, Site
from runtime.core.workspace_rows import Y0, Y1
from runtime.hybrid.events import INSTANT, UNRESOLVED
from runtime.integrate.clocks import CLOCK
from runtime.integrate.sampled_values import ENDS, replace_last
from runtime.integrate.sampling import STEP_ENDS, has_room
from runtime.integrate.step import Signal, TrialStep, reject
from runtime.integrate.step_acceptance import accept_step, end_at_event, judge_events

_SHARE = 0.3  # measured: of the way to a configuration that is missed; largest part of one step
WEAK_STATES = 3  # safety: accepted states in a row with a weak pivot that make a singular run
TOO_CLOSE = 1.2  # safety: steps; a nearer singular configuration is planned for before the step
LOG_MARGIN = 16  # safety: free rows of the partition log that one step may need


@inner
def is_at_kink(context: Context) -> bool:
    """Whether the run stands at a kink of an explicit function of time; other stops are passed."""
    r = run_record(context)
    while r.stop - r.t <= max(INSTANT * abs(r.t), r.h_min):
        if context.stop_kinds[r.next_stop] >= 0:
            return True
        r.next_stop += 1
        r.stop = np.inf
        if r.next_stop < context[ft.STOPS]:
            r.stop = context.stop_times[r.next_stop]
    return False


@inner
def is_sample_due(context: Context) -> bool:
    """Whether a clock renews values now, also in the last instant of the run."""
    r = run_record(context)
    return bool(r.sample_at <= r.t + CLOCK * abs(r.t))


@addressed(ft.PART)
def plan_step(context: Context) -> int:
    """Choose the end of the next step: the controller's, a plan's, a stop's, or that of the run."""
    r = run_record(context)
    t = r.t
    if t < r.t_end and is_at_kink(context):
        return Signal.KINK
    if is_sample_due(context):
        signal = ft.renew_of(context)(context)
        return Signal.RETRY if signal == Signal.PROCEED else signal
    if t >= r.t_end:
        return Outcome.OK
    if (
        r.logged_events + 3 * context[ft.SWITCHES] > context[ft.EVENT_ROWS]
        or r.logged_repartitions + LOG_MARGIN > context[ft.LOG_ROWS]
    ):
        return Signal.GOING
    if r.steps + r.rejected >= r.max_steps:
        return Outcome.MAX_STEPS
    h = min(r.h, r.h_max)
    r.tried, r.planned = 0.0, 0
    if r.plan == Plan.CROSSING or (r.plan == Plan.APPROACHING and t + 1.01 * h >= r.turn):
        h = r.length_across if r.plan == Plan.CROSSING else r.turn - t
        r.planned = 1
    elif r.plan == Plan.MISSING:
        h = min(h, max(r.length_across, _SHARE * abs(r.turn - t)))
    end = r.turn if r.planned != 0 and r.plan == Plan.APPROACHING else t + h
    last = min(r.stop, r.t_end, r.sample_at)
    if t + (1.01 - 0.01 * r.planned) * h >= last:
        h = last - t
        end = last
    elif h <= r.h_min or end <= t:
        r.site = Site.SHORTEST_STEP
        if r.reason == TrialStep.NEWTON_FAILED:
            return Outcome.NEWTON_FAILED
        if r.reason == TrialStep.NOT_FINITE:
            return Outcome.NOT_FINITE
        return Outcome.STEP_TOO_SMALL
    if not has_room(context, end):
        return Signal.GOING
    r.length, r.end = h, end
    return Signal.PROCEED


@addressed(ft.PART)
def try_step(context: Integers) -> int:
    """Take the trial step; where it is rejected, shorten the next one."""
    r = run_record(context)
    t, h, end = r.t, r.length, r.end
    code = ft.trial_step_of(context)(context, t, h)
    if context[ft.LOOPS] != 0:
        taken = 1 if code == TrialStep.DONE else 0
        if ft.guard_branches_of(context)(context, t, h, taken) != 0:
            r.rejected += 1
            return Signal.LEAVE
    if code == TrialStep.DONE:
        if context[ft.PEAKS] != 0 and r.fixed == 0 and r.plan != Plan.CROSSING:
            part = ft.resolved_part_of(context)(context)
            if part < 0.0:
                r.site = Site.KINK
                return Outcome.DISCONTINUOUS
            if part < 1.0:
                return reject(context, UNRESOLVED, part * h)
        return Signal.PROCEED
    if code == TrialStep.TOO_LARGE:
        h *= max(r.shrink, r.safety / r.error**r.exponent)
    else:
        h *= 0.25
    reject(context, code, h)
    if h <= r.h_min and end >= r.t_end:
        r.h = 0.0
    if r.plan == Plan.CROSSING:
        return Signal.LOOK
    guided = r.fixed != 0 or r.plan == Plan.APPROACHING or t < r.quiet
    if not guided and context[ft.CONSTRAINT_COUNT] > 0:
        # Where constraints are about to become dependent, shorter steps do not help.
        r.vanishing = ft.vanishing_of(context)(context, t, end - t, Y0)
        if np.isfinite(r.vanishing):
            return Signal.LOOK
    return Signal.RETRY


@addressed(ft.PART)
def look_for_singularity(context: Integers) -> int:
    """Whether a singular configuration lies so near that the step must not be taken."""
    r = run_record(context)
    r.announced = 0
    if (
        r.plan == Plan.FREE
        and context[ft.CONSTRAINT_COUNT] > 0
        and context[ft.SLIDING_COUNT] == 0  # the search knows Φ alone, and not g = 0
        and r.end >= r.look_at
        and r.end >= r.quiet
        and r.fixed == 0
    ):
        r.vanishing = ft.vanishing_of(context)(context, r.t, r.length, Y1)
        if r.vanishing < TOO_CLOSE * r.length:
            # Not to be stepped over by chance, nor to be ended at.
            r.rejected += 1
            r.tried = r.length
            return Signal.LOOK
        if r.vanishing < np.inf:
            r.vanishing -= r.length
            r.announced = 1
    return Signal.PROCEED


@inner
def propose_next(context: Integers) -> None:
    """Choose the length of the step after this one, as far as its error decides."""
    r = run_record(context)
    r.next_length = r.h
    if r.fixed == 0:
        r.next_length = min(r.length * ft.propose_of(context)(context, r.length), r.followed)
        if r.planned != 0:
            r.next_length = max(r.next_length, r.h) if r.plan == Plan.APPROACHING else r.h
        elif r.end == r.stop or r.end == r.sample_at:  # noqa: PLR1714
            r.next_length = max(r.next_length, r.h)  # not the error cut it


@addressed(ft.PART)
def follow_plan(context: Integers) -> int:
    """After an accepted step: what is planned about singular configurations and the method."""
    r = run_record(context)
    if r.weak >= WEAK_STATES:
        r.index = r.weak_row - 1
        r.vanishing = 0.0  # where constraints are left there is a position to look for
        if r.index < context[ft.CONSTRAINT_COUNT]:
            return Signal.LOOK
        r.site = Site.WEAK_STATES
        return Outcome.SINGULAR
    if r.planned == 0 and r.length > 0.0:
        r.usual = max(r.length, 0.5 * r.usual)
    if r.plan == Plan.CROSSING or (r.plan == Plan.APPROACHING and r.t >= r.turn):
        return Signal.LOOK
    if r.plan >= Plan.LEAVING and r.t >= r.quiet:
        if r.plan == Plan.LEAVING:
            ft.repartition_of(context)(context, r.t, Y0)
        r.plan = Plan.FREE
    if (r.lent != 0 and r.plan == Plan.FREE and r.t >= r.lent_until) or r.announced != 0:
        return Signal.LOOK
    if r.due != 0 and r.t < r.t_end:
        return Signal.CHANGE
    return Signal.PROCEED


@inner
def renew_when_due(context: Context) -> int:
    """Renew the sampled values that are due at the end of the step."""
    if is_sample_due(context):
        return int(ft.renew_of(context)(context))
    return Signal.PROCEED


@inner
def watch_events(context: Context) -> int:
    """After events: what begins with a condition that is watched."""
    r = run_record(context)
    if context[ft.WATCHED] == 0 or r.changed == 0:
        return Signal.PROCEED
    if r.length == 0.0 and r.every_step != STEP_ENDS:
        replace_last(context)  # by what was renewed at this instant
    signal = int(ft.watch_of(context)(context))
    if signal == Signal.STOP and context.ends_run[r.stopped_by] == ENDS:
        renewed = renew_when_due(context)  # in the last row of this run, as in a longer one
        signal = signal if renewed == Signal.PROCEED else renewed
    return signal


@unlocked(i8(ADDRESSES, i8))
def advance(context: Integers, budget: int) -> int:
    """Take at most `budget` trial steps; returns a negative `Signal`, or the code of the outcome.

    `run.index` names the switching function or constraint where an outcome concerns one.
    """
    for _ in range(budget):
        signal = plan_step(context)
        if signal == Signal.PROCEED:
            signal = try_step(context)
        if signal == Signal.PROCEED:
            signal = look_for_singularity(context)
        if signal == Signal.PROCEED:
            propose_next(context)
            signal = end_at_event(context)
        if signal == Signal.PROCEED:
            signal = accept_step(context)
        if signal == Signal.PROCEED:
            signal = judge_events(context)
        if signal == Signal.PROCEED:
            signal = watch_events(context)
        if signal == Signal.PROCEED:
            signal = follow_plan(context)
        if signal == Signal.PROCEED:
            signal = renew_when_due(context)
        if not (signal == Signal.PROCEED or signal == Signal.RETRY):  # noqa: PLR1714
            return signal
    r = run_record(context)
    if r.t >= r.t_end and not is_sample_due(context):
        return Outcome.OK
    return Signal.GOING
