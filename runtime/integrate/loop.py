"""The loop over steps: try, look for crossings, write samples, accept.

`advance` is compiled once. Kernels, the method and the larger parts of the loop reach it as
first-class functions; all state lies in its arrays, so that a run can stop after any step and go on
with the same bits.
"""

import numpy as np

from runtime.core import outcome_codes as codes
from runtime.core.array_types import Integers, i8
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    EVENT_ROWS,
    LOG_ROWS,
    LOOPS,
    MODIFIED,
    STABILIZED,
    SWITCHES,
    accepted_of,
    attempt_of,
    crossed_of,
    dense_of,
    emit_of,
    first_step_of,
    locate_of,
    modes_of,
    passed_of,
    propose_of,
    recent_events_of,
    repartition_of,
    restart_of,
    transition_of,
    vanishing_of,
    watch_of,
)
from runtime.core.jit import ADDRESSES, compiled
from runtime.core.run_record import APPROACHING, CROSSING, FREE, LEAVING, MISSING, run_record
from runtime.core.workspace import BAND, G0, G1, LARGEST, R0, R1, Y0, Y1, K, row_of, switch_row
from runtime.hybrid.event_location import INSTANT, last_due
from runtime.hybrid.event_resolution import UNRESOLVED
from runtime.hybrid.mode_consistency import CONSISTENT
from runtime.hybrid.switching_functions import measure
from runtime.integrate.step import DONE, NEWTON, NOT_FINITE, TOO_LARGE

GOING = -1  # the run is not over
LOOK = -2  # nor is this: a singular position has to be looked at, see `crossing`
CHANGE = -3  # nor is this: another method is due
UNFINISHED = (GOING, LOOK, CHANGE)

_FLIGHT = 0.6  # of the time between two impacts: a first step that meets none
_RETAKES = 5
WEAK_STATES = 3  # accepted states in a row with a weak pivot that make a singular run
_ZENO_EVENTS = 30  # events in a row with such a ratio that are no accident
_ZENO_SPAN = 1e-7  # of the run: what eight such events must take at most
_ZENO_RATIO = 0.98  # of the time of eight events to that of the eight before the last
_SHARE = 0.3  # of the way to a position that is missed: what a step may cover
RECENT = 8
TOO_CLOSE = 1.2  # steps: a singular position no further away than this needs a plan before the step
LOG_MARGIN = 16  # free rows of the partition log that one step may need


@compiled(i8(ADDRESSES, i8))
def advance(context: Integers, budget: int) -> int:
    """Take at most `budget` trial steps.

    Returns `GOING`, `LOOK`, `CHANGE`, or the code of the outcome. `run.index` names the switching
    function or constraint where an outcome concerns one.
    """
    modes = modes_of(context)
    recent = recent_events_of(context)
    g1 = switch_row(context, G1)
    g0 = switch_row(context, G0)
    r1 = switch_row(context, R1)
    r0 = switch_row(context, R0)
    largest = switch_row(context, LARGEST)
    band = switch_row(context, BAND)
    attempt = attempt_of(context)
    first_step = first_step_of(context)
    r = run_record(context)
    length = 2 * context[COORDINATES]
    m = context[CONSTRAINT_COUNT]
    s = context[SWITCHES]
    y0 = row_of(context, Y0)
    y1 = row_of(context, Y1)
    k0 = row_of(context, K)
    k1 = row_of(context, K + r.last)
    found = crossed_of(context)
    for _ in range(budget):
        t = r.t
        if t >= r.t_end:
            return codes.OK
        if (
            r.logged_events + 2 * s > context[EVENT_ROWS]
            or r.logged_repartitions + LOG_MARGIN > context[LOG_ROWS]
        ):
            return GOING
        if r.steps + r.rejected >= r.max_steps:
            return codes.MAX_STEPS
        h = min(r.h, r.h_max)
        r.tried = 0.0
        planned = 0
        if r.plan == CROSSING or (r.plan == APPROACHING and t + 1.01 * h >= r.turn):
            h = r.leap if r.plan == CROSSING else r.turn - t
            planned = 1
        elif r.plan == MISSING:
            h = min(h, max(r.leap, _SHARE * abs(r.turn - t)))
        t1 = r.turn if planned != 0 and r.plan == APPROACHING else t + h
        if t + (1.01 - 0.01 * planned) * h >= r.t_end:
            h = r.t_end - t
            t1 = r.t_end
        elif h <= r.h_min or t1 <= t:
            if r.reason == NEWTON:
                return codes.NEWTON_FAILED
            return codes.NOT_FINITE if r.reason == NOT_FINITE else codes.STEP_TOO_SMALL

        # Try the step.
        due = 0
        code = attempt(context, t, h)
        if code != DONE:
            r.rejected += 1
            r.reason = code
            r.rejected_before = 1
            if code == TOO_LARGE:
                h *= max(r.shrink, r.safety / r.error**r.exponent)
            else:
                h *= 0.25
            r.h = h
            if h <= r.h_min and t1 >= r.t_end:
                r.h = 0.0
            if r.plan == CROSSING:
                return LOOK
            if r.fixed == 0 and m > 0 and r.plan != APPROACHING and t >= r.quiet:
                # Where constraints are about to become dependent, shorter steps do not help.
                r.vanishing = vanishing_of(context)(context, t, t1 - t, Y0)
                if np.isfinite(r.vanishing):
                    return LOOK
            continue
        soon = 0
        if context[LOOPS] != 0:
            code = passed_of(context)(context, t, h)
            if code > 0:
                return int(code)
            if code < 0:
                continue
        if (
            r.plan == FREE
            and m > 0
            and context[MODIFIED] == context[STABILIZED]
            and t1 >= r.look_at
            and t1 >= r.quiet
            and r.fixed == 0
        ):
            r.vanishing = vanishing_of(context)(context, t, h, Y1)
            if r.vanishing < TOO_CLOSE * h:
                # Not to be stepped over by chance, nor to be ended at.
                r.rejected += 1
                r.tried = h
                return LOOK
            if r.vanishing < np.inf:
                r.vanishing -= h
                soon = 1
        h_next = r.h
        if r.fixed == 0:
            h_next = h * propose_of(context)(context, h)
            if planned != 0:
                h_next = max(h_next, r.h) if r.plan == APPROACHING else r.h

        # Look for a crossing, and end the step where the first one is.
        crossing = -1
        dense_ready = 0
        if s > 0:
            suspects = watch_of(context)(context, t, h, t1)
            if suspects == UNRESOLVED:
                r.rejected += 1
                r.reason = UNRESOLVED
                r.rejected_before = 1
                r.h = r.stretch * h
                continue
            h_next = min(h_next, h * r.stretch)
            if suspects > 0:
                dense_of(context)(context, t, h)
                dense_ready = 1
                r.dense_outputs += 1
                r.rhs += r.dense_calls
                x = locate_of(context)(context, t, h, r.dense_rows)
                if x <= 1.0:
                    crossing = found[0]
                    reach = h
                    h = x * h
                    dense_ready = 0
            if crossing < 0 and t1 >= r.t_end:
                crossing = last_due(context, t1)
                if crossing >= 0:
                    reach = h
                    dense_ready = 0
            if crossing >= 0 and t1 >= r.t_end:
                # The last sample is that of what follows the event.
                reach = r.t_end - INSTANT * abs(r.t_end) - t
                h = min(h, reach)
        if crossing >= 0 and h <= INSTANT * max(abs(t), r.h_min):
            # At this very instant: no step, only a change of modes.
            h = 0.0
            t1 = t
            for j in range(length):
                y1[j] = y0[j]
                k1[j] = k0[j]
            for k in range(s):
                g1[k] = g0[k]
                r1[k] = r0[k]
            r.standing += 1
            if r.standing > 8 + 2 * s:
                r.index = crossing
                return codes.ZENO
        elif crossing >= 0:
            r.standing = 0
            for retake in range(_RETAKES):
                t1 = t + h
                code = attempt(context, t, h)
                r.retakes += 1
                if code != DONE:
                    break
                measure(context, t1, Y1, K + r.last, G1)
                g = g1[crossing]
                if abs(g) <= 4e-16 * largest[crossing] or retake == _RETAKES - 1:
                    break
                polished = h - g / r1[crossing]
                if not (0.0 < polished <= reach) or abs(polished - h) > 1e-3 * reach:
                    break
                if t + polished == t1:
                    break
                h = polished
            if code != DONE:
                r.rejected += 1
                r.reason = code
                r.rejected_before = 1
                r.h = 0.5 * h
                continue
            g = g1[crossing]
            side = 1.0 if modes[crossing] != 0 else -1.0
            near = max(
                1e-11 * largest[crossing],
                1e-12 * reach * abs(r1[crossing]),
                band[crossing],
            )
            if side * g > near:
                crossing = -1  # it only came close

        # Write the samples, then accept.
        if h > 0.0:
            written = emit_of(context)(
                context, t, t1, h, dense_ready,
            )  # fmt: skip
            if written < 0:
                r.rejected += 1
                r.reason = NEWTON
                r.rejected_before = 1
                r.h = 0.5 * h
                continue
            r.steps += 1
            r.rejected_before = 0
            r.error_old = max(r.error, 1e-4)
            due = accepted_of(context)(context, t, h)
            r.weak = r.weak + 1 if r.weak_row > 0 else 0
        r.t = t1
        r.h = h_next
        for k in range(s):
            largest[k] = max(largest[k], abs(g1[k]))
        changed = 0
        if crossing >= 0:
            changed = transition_of(context)(
                context, crossing, t1, h_next,
            )  # fmt: skip
            r.rhs += 1
        else:
            for k in range(s):
                side = 1.0 if modes[k] != 0 else -1.0
                if side * g1[k] > band[k]:
                    band[k] = 0.0
        for j in range(length):
            y0[j] = y1[j]
            k0[j] = k1[j]
        for k in range(s):
            g0[k] = g1[k]
            r0[k] = r1[k]

        # Is there a reason to stop?
        if changed > 0:
            span = t1 - recent[0]
            for i in range(RECENT - 1):
                recent[i] = recent[i + 1]
            recent[RECENT - 1] = t1
            faster = span < _ZENO_RATIO * r.event_span and r.flight == np.inf
            r.shrinking = r.shrinking + 1 if faster else 0
            r.event_span = span
            if r.blamed != CONSISTENT:
                r.index = r.blamed
                return codes.ZENO if r.shrinking >= RECENT else codes.INCONSISTENT
            endless = r.shrinking >= _ZENO_EVENTS and span < _ZENO_SPAN * r.duration
            if endless or r.events > r.max_events:
                r.index = crossing
                return codes.ZENO
            restart_of(context)(context, t1, h_next)
            if r.fixed == 0:
                first = first_step(context, t1, r.h_max, r.rtol, r.order)
                r.h = min(h_next, 2.0 * first, _FLIGHT * r.flight)
                r.rhs += 1
                r.error_old = 1e-4
                r.remembered = 0.0
        if r.weak >= WEAK_STATES:
            r.index = r.weak_row - 1
            r.vanishing = 0.0  # where constraints are left there is a position to look for
            return LOOK if r.index < m else codes.SINGULAR
        if planned == 0 and h > 0.0:
            r.usual = max(h, 0.5 * r.usual)
        if r.plan == CROSSING or (r.plan == APPROACHING and t1 >= r.turn):
            return LOOK
        if r.plan >= LEAVING and t1 >= r.quiet:
            if r.plan == LEAVING:
                repartition_of(context)(context, t1, Y0)
            r.plan = FREE
        if r.lent != 0 and r.plan == FREE and t1 >= r.lent_until:
            return LOOK
        if soon != 0:
            return LOOK
        if due != 0 and r.t < r.t_end:
            return CHANGE
    return codes.OK if r.t >= r.t_end else GOING
