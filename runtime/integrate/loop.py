"""The loop over steps: try, look for crossings, write samples, accept.

`advance` is compiled once. Kernels, the method and the larger parts of the loop reach it as
first-class functions; all state lies in its arrays, so that a run can stop after any step and go on
with the same bits.
"""

import numpy as np

from runtime.core import outcome_codes as codes
from runtime.core.array_views import view
from runtime.core.function_table import (
    BENDS,
    LOG_ROWS,
    LOOPS,
    STABILIZED,
    accepted_of,
    attempt_of,
    dense_of,
    emit_of,
    first_step_of,
    locate_of,
    passed_of,
    propose_of,
    repartition_of,
    restart_of,
    transition_of,
    vanishing_of,
    watch_of,
)
from runtime.core.jit import ADDRESSES, compiled
from runtime.core.signatures import (
    IntegerMatrix,
    Integers,
    Matrix,
    Vector,
    i8,
    integer_matrix,
    integers,
    matrix,
    vector,
)
from runtime.core.workspace import (
    APPROACHING,
    BAND,
    CROSSING,
    FREE,
    G0,
    G1,
    LARGEST,
    LEAVING,
    MISSING,
    R0,
    R1,
    ROWS,
    SWITCH_ROWS,
    Y0,
    Y1,
    K,
    Run,
    run_record,
)
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


@compiled(
    i8(
        i8,
        ADDRESSES,
        vector,
        vector,
        run_record,
        vector,
        integers,
        integers,
        vector,
        vector,
        vector,
        matrix,
        integer_matrix,
        vector,
        vector,
        integer_matrix,
        matrix,
    )
)
def advance(
    budget: int,
    machine: Integers,
    w: Vector,
    sw: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    scratch: Integers,
    lam: Vector,
    t_eval: Vector,
    out_t: Vector,
    out_y: Matrix,
    out_modes: IntegerMatrix,
    recent: Vector,
    event_t: Vector,
    event_kind: IntegerMatrix,
    event_y: Matrix,
) -> int:
    """Take at most `budget` trial steps.

    Returns `GOING`, `LOOK`, `CHANGE`, or the code of the outcome. `run.index` names the switching
    function or constraint where an outcome concerns one.
    """
    attempt = attempt_of(machine)
    first_step = first_step_of(machine)
    r = run[0]
    length = w.size // ROWS
    m = lam.size
    s = sw.size // SWITCH_ROWS
    y0 = view(w, Y0 * length, length)
    y1 = view(w, Y1 * length, length)
    k0 = view(w, K * length, length)
    k1 = view(w, (K + r.last) * length, length)
    found = view(scratch, 3 * s, 1)
    for _ in range(budget):
        t = r.t
        if t >= r.t_end:
            return codes.OK
        if (
            r.logged_events + 2 * s > event_t.size
            or r.logged_repartitions + LOG_MARGIN > machine[LOG_ROWS]
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
        code = attempt(machine, t, h, w, run, p, modes, lam)
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
                r.vanishing = vanishing_of(machine)(machine, t, t1 - t, Y0, w, run, p)
                if np.isfinite(r.vanishing):
                    return LOOK
            continue
        soon = 0
        if machine[LOOPS] != 0:
            code = passed_of(machine)(machine, t, h, w, run, p)
            if code > 0:
                return int(code)
            if code < 0:
                continue
        if (
            r.plan == FREE
            and m > 0
            and machine[BENDS] == machine[STABILIZED]
            and t1 >= r.look_at
            and t1 >= r.quiet
            and r.fixed == 0
        ):
            r.vanishing = vanishing_of(machine)(machine, t, h, Y1, w, run, p)
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
            h_next = h * propose_of(machine)(machine, h, w, run)
            if planned != 0:
                h_next = max(h_next, r.h) if r.plan == APPROACHING else r.h

        # Look for a crossing, and end the step where the first one is.
        crossing = -1
        dense_ready = 0
        if s > 0:
            suspects = watch_of(machine)(machine, t, h, t1, w, sw, run, p, modes, lam)
            if suspects == UNRESOLVED:
                r.rejected += 1
                r.reason = UNRESOLVED
                r.rejected_before = 1
                r.h = r.stretch * h
                continue
            h_next = min(h_next, h * r.stretch)
            if suspects > 0:
                dense_of(machine)(machine, t, h, w, p, modes, lam)
                dense_ready = 1
                r.dense_outputs += 1
                r.rhs += r.dense_calls
                x = locate_of(machine)(machine, t, h, r.dense_rows, found)
                if x <= 1.0:
                    crossing = found[0]
                    reach = h
                    h = x * h
                    dense_ready = 0
            if crossing < 0 and t1 >= r.t_end:
                crossing = last_due(t1, sw, modes)
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
                sw[G1 * s + k] = sw[G0 * s + k]
                sw[R1 * s + k] = sw[R0 * s + k]
            r.standing += 1
            if r.standing > 8 + 2 * s:
                r.index = crossing
                return codes.ZENO
        elif crossing >= 0:
            r.standing = 0
            for retake in range(_RETAKES):
                t1 = t + h
                code = attempt(machine, t, h, w, run, p, modes, lam)
                r.retakes += 1
                if code != DONE:
                    break
                measure(machine, t1, Y1, K + r.last, G1, w, sw, p, modes, lam)
                g = sw[G1 * s + crossing]
                if abs(g) <= 4e-16 * sw[LARGEST * s + crossing] or retake == _RETAKES - 1:
                    break
                polished = h - g / sw[R1 * s + crossing]
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
            g = sw[G1 * s + crossing]
            side = 1.0 if modes[crossing] != 0 else -1.0
            near = max(
                1e-11 * sw[LARGEST * s + crossing],
                1e-12 * reach * abs(sw[R1 * s + crossing]),
                sw[BAND * s + crossing],
            )
            if side * g > near:
                crossing = -1  # it only came close

        # Write the samples, then accept.
        if h > 0.0:
            written = emit_of(machine)(
                machine, t, t1, h, dense_ready, w, run, p, modes,
                lam, t_eval, out_t, out_y, out_modes,
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
            due = accepted_of(machine)(machine, t, h, w, run)
            r.weak = r.weak + 1 if r.weak_row > 0 else 0
        r.t = t1
        r.h = h_next
        for k in range(s):
            sw[LARGEST * s + k] = max(sw[LARGEST * s + k], abs(sw[G1 * s + k]))
        changed = 0
        if crossing >= 0:
            changed = transition_of(machine)(
                machine, crossing, t1, h_next, w, sw, run, p, modes, scratch, lam, event_t,
                event_kind, event_y,
            )  # fmt: skip
            r.rhs += 1
        else:
            for k in range(s):
                side = 1.0 if modes[k] != 0 else -1.0
                if side * sw[G1 * s + k] > sw[BAND * s + k]:
                    sw[BAND * s + k] = 0.0
        for j in range(length):
            y0[j] = y1[j]
            k0[j] = k1[j]
        for k in range(s):
            sw[G0 * s + k] = sw[G1 * s + k]
            sw[R0 * s + k] = sw[R1 * s + k]

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
            restart_of(machine)(machine, t1, h_next, w, run)
            if r.fixed == 0:
                first = first_step(machine, t1, r.h_max, r.rtol, r.order, w, p, modes, lam)
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
                repartition_of(machine)(machine, t1, Y0, w, run, p)
            r.plan = FREE
        if r.lent != 0 and r.plan == FREE and t1 >= r.lent_until:
            return LOOK
        if soon != 0:
            return LOOK
        if due != 0 and r.t < r.t_end:
            return CHANGE
    return codes.OK if r.t >= r.t_end else GOING
