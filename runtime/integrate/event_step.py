"""The end of a step at the first event in it.

Where a switching function crosses zero inside a trial step, the step is taken again up to there.
"""

from runtime.core.array_types import Integers
from runtime.core.function_table import (
    COORDINATES,
    PART,
    SWITCHES,
    crossed_of,
    dense_of,
    locate_of,
    modes_of,
    screen_step_of,
    trial_step_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.outcomes import Outcome
from runtime.core.run_record import run_record
from runtime.core.workspace import BAND, G0, G1, LARGEST, R0, R1, Y0, Y1, K, row_of, switch_row
from runtime.hybrid.event_location import INSTANT, find_crossing_at_end
from runtime.hybrid.event_resolution import UNRESOLVED
from runtime.hybrid.switching_functions import evaluate_switching_and_rates
from runtime.integrate.signals import Signal, reject
from runtime.integrate.step import TrialStep

_RETAKES = 5  # safety: steps up to an event before its instant is taken as it is
_STANDING = 8  # safety: events in a row without time between them, and two for each function


@inner
def find_event(context: Integers, suspects: int) -> None:
    """Locate the first event; `run.length` becomes the time to it, `run.reach` the step's own."""
    r = run_record(context)
    h = r.length
    if suspects > 0:
        dense_of(context)(context, r.t, h)
        r.dense_ready = 1
        r.dense_outputs += 1
        r.rhs += r.dense_calls
        x = locate_of(context)(context, r.t, h, r.dense_rows)
        if x <= 1.0:
            r.crossing = crossed_of(context)[0]
            r.reach = h
            r.length = x * h
            r.dense_ready = 0
    if r.crossing < 0 and r.end >= r.t_end:
        r.crossing = find_crossing_at_end(context, r.end)
        if r.crossing >= 0:
            r.reach = h
            r.dense_ready = 0
    if r.crossing >= 0 and r.end >= r.t_end:
        # The last sample is that of what follows the event.
        r.reach = r.t_end - INSTANT * abs(r.t_end) - r.t
        r.length = min(r.length, r.reach)


@addressed(PART)
def stay(context: Integers) -> int:
    """At an event at this very instant: no step, only a change of modes."""
    r = run_record(context)
    y0, y1 = row_of(context, Y0), row_of(context, Y1)
    k0, k1 = row_of(context, K), row_of(context, K + r.last)
    g0, g1 = switch_row(context, G0), switch_row(context, G1)
    r0, r1 = switch_row(context, R0), switch_row(context, R1)
    s = context[SWITCHES]
    r.length = 0.0
    r.end = r.t
    for j in range(2 * context[COORDINATES]):
        y1[j] = y0[j]
        k1[j] = k0[j]
    for k in range(s):
        g1[k] = g0[k]
        r1[k] = r0[k]
    r.standing += 1
    if r.standing > _STANDING + 2 * s:
        r.index = r.crossing
        return Outcome.ZENO
    return Signal.PROCEED


@addressed(PART)
def retake(context: Integers) -> int:
    """Take the step again up to the event, by Newton's method on its switching function."""
    r = run_record(context)
    g1, r1 = switch_row(context, G1), switch_row(context, R1)
    largest, band = switch_row(context, LARGEST), switch_row(context, BAND)
    crossing, t, h, reach = r.crossing, r.t, r.length, r.reach
    take_trial_step = trial_step_of(context)
    code = 0
    r.standing = 0
    for turn in range(_RETAKES):
        r.end = t + h
        code = take_trial_step(context, t, h)
        r.retakes += 1
        if code != TrialStep.DONE:
            break
        evaluate_switching_and_rates(context, r.end, Y1, K + r.last, G1)
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
        reject(context, code, 0.5 * h)
        return Signal.RETRY
    side = 1.0 if modes_of(context)[crossing] != 0 else -1.0
    near = max(1e-11 * largest[crossing], 1e-12 * reach * abs(r1[crossing]), band[crossing])
    if side * g1[crossing] > near:
        r.crossing = -1  # it only came close
    return Signal.PROCEED


@addressed(PART)
def end_at_event(context: Integers) -> int:
    """Find the first event in the step, and end the step there.

    `run.crossing` receives its switching function, or -1.
    """
    r = run_record(context)
    r.crossing = -1
    r.dense_ready = 0
    if context[SWITCHES] == 0:
        return Signal.PROCEED
    suspects = screen_step_of(context)(context, r.t, r.length, r.end)
    if suspects == UNRESOLVED:
        reject(context, UNRESOLVED, r.stretch * r.length)
        return Signal.RETRY
    r.next_length = min(r.next_length, r.length * r.stretch)
    find_event(context, suspects)
    if r.crossing < 0:
        return Signal.PROCEED
    if r.length <= INSTANT * max(abs(r.t), r.h_min):
        return stay(context)
    return retake(context)
