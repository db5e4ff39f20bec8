"""Mode transition at an event: impacts, new modes, and the log of events.

A surface at which the forces bend and do not jump holds no motion.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.arrays import EPS, Context
from runtime.core.jit import addressed, inner
from runtime.core.kinds import BALANCED, CLOSED, KNOTS, ONE_WAY, SLIDING, Direction
from runtime.core.loop_record import run_record
from runtime.core.state_derivative import evaluate_accelerations, write_derivative
from runtime.hybrid import mode_consistency as consistency
from runtime.hybrid import sliding_motion as switching
from runtime.hybrid.impact import ON_SURFACE, SLOW
from runtime.hybrid.mode_selection import prefer_released, set_preferences, surface_band
from runtime.hybrid.rest_forces import rests, share_freedom
from runtime.linalg.vectors import copy_vector, is_finite, largest_magnitude

_CONTINUOUS = 1e-3  # safety: ratio of the responses on a surface and beside it; at a jump it is 1

LOOK_AHEAD = 0.05  # measured: of a step; look-ahead in which modes are judged
_BEGAN, _CEASED = int(Direction.BEGAN), int(Direction.CEASED)
_HOLDS, _IMPACT = int(Direction.HOLDS), int(Direction.IMPACT)
_FREE = 0.02  # measured: difference of the ratio of two flights from that of free flights
_SAME_BOUNCING = 10.0  # measured: next flights by which the ratio may err within one bouncing
_STILL = 1e-12  # accuracy: of the rate before an impact; slower contacts after it stay closed
_CLOCK = 8.0 * EPS  # accuracy: of the time; difference of instants that the clock cannot resolve
_JUMP = 1e-6  # safety: of the largest |g|; a function with a larger |g| at its crossing jumps


@inner
def response_at(context: Context, t: float, state: int, k: int) -> float:
    """By how much the modes of the sliding function `k` change its rate in the state of a row."""
    q, v = ws.positions(context, state), ws.velocities(context, state)
    evaluate_accelerations(context, t, q, v, context.modes, context.first_scratch)
    count = context[ft.SLIDING_COUNT]
    for c in range(count):
        if context.sliding_functions[c] == k:
            return float(context.response[c * count + c])
    return 0.0


@inner
def bends_on_surface(context: Context, t: float, k: int) -> bool:
    """Whether both modes of function `k` have one motion on its surface; row SAMPLE is there.

    So it is where a force is continuous, as c |v| at v = 0. Off the surface, by the error of the
    event, the modes differ, and neither side may seem right, or the motion to be held between.
    """
    modes, kept = context.modes, int(context.modes[k])
    if context.rigid[k] >= 0 or context.sticks[k] != 0 or context.boundary[k] >= BALANCED:
        return False
    modes[k] = SLIDING
    consistency.count_sliding(context, modes)
    before, place = response_at(context, t, ws.Y1, k), ws.row_of(context, ws.SAMPLE)
    copy_vector(ws.row_of(context, ws.Y1), place)
    ft.return_to_surfaces_of(context)(context, t, ws.SAMPLE)
    after = response_at(context, t, ws.SAMPLE, k)
    modes[k] = kept
    consistency.count_sliding(context, modes)
    return is_finite(place) and not abs(after) > _CONTINUOUS * abs(before)


@inner
def log_event(context: Context, t: float, k: int, direction: int) -> None:
    """Append an event of function `k` with the state in row Y1."""
    r = run_record(context)
    at = r.logged_events
    context.event_times[at] = t
    context.event_kinds[at, 0], context.event_kinds[at, 1] = k, direction
    copy_vector(ws.row_of(context, ws.Y1), context.event_states[at])
    r.logged_events += 1
    r.events += 1 if context.table_part[k] != KNOTS else 0


@inner
def move_event(context: Context, at: int, ahead: float) -> None:
    """Give event `at` the state in which the motion of the state in row Y1 is, `ahead` later."""
    n, y, last = context[ft.COORDINATES], context.event_states[at], run_record(context).last
    a = ws.velocity_rates(context, ws.K + last)
    for j in range(n):
        y[n + j] = context.v1[j] + ahead * a[j]
        y[j] = context.q1[j] + 0.5 * ahead * (context.v1[j] + y[n + j])


@inner
def evaluate_now(context: Context, t: float) -> None:
    """Write g of the state in row Y1 into row NOW, and its rate into RATE_NOW.

    The accelerations do not count: of contacts, whose rates are read, they are no part.
    """
    q, v, p = context.q1, context.v1, context.parameters
    abi.switching_of(context)(t, q, v, p, context.now)
    abi.switching_rates_of(context)(t, q, v, context.first_scratch, p, context.rate_now)


@inner
def predict_flights(context: Context, k: int, t: float, free: float) -> float:
    """Total time of all further flights of contact `k`.

    It is `free`, T/(1 - e), where they are free; where friction or another contact interferes, each
    is shorter than the one before in the ratio of the last two. Only flights of one bouncing have a
    ratio: the next one, T, then is about as long as the ratio says. The flight of a ball that its
    floor threw off is no part of the bouncing that ends it.
    """
    e, before = context.restitution_coefficients[context.rigid[k]], context.flight[k]
    flight = t - context.impact_at[k]
    ratio = flight / before if before > 0.0 else e
    if abs(ratio - e) < _FREE * e or not 0.0 < ratio < 1.0:
        return free
    if not flight * ratio < _SAME_BOUNCING * (1.0 - e) * free:
        return free
    return float(flight * ratio / (1.0 - ratio))


@inner
def prefer_release(context: Context, t: float, crossing: int) -> None:
    """Let function `crossing`, whose share has reached a bound, go to that side, in row PREFERRED.

    At the bound the acceleration of that mode equals that of sliding, so that a look-ahead at
    constant acceleration would show no change. Frictions of the same freedom that have reached
    their bounds break loose together: one after the other, each would stop the other again. The
    accelerations must just have been evaluated.
    """
    mode = consistency.nearest_mode(context, crossing)
    context.preferred[crossing] = consistency.decided_entry(mode)
    for k in range(context[ft.SWITCHES]):
        frictions = context.rigid[k] < 0 and context.rigid[crossing] < 0
        if k == crossing or context.modes[k] != SLIDING or not frictions:
            continue
        if not share_freedom(context, k, crossing):
            continue
        if switching.compute_margin(context, t, context.q1, context.v1, k) <= consistency.MISSED:
            context.preferred[k] = consistency.decided_entry(consistency.nearest_mode(context, k))


@inner
def meet_conditions(context: Context, t: float) -> None:
    """Let a condition end the run that holds as a contact closes, and not after the impact.

    A condition such as y <= 0 holds on its boundary, which a body that bounces leaves at once.
    """
    r, modes, holds = run_record(context), context.kernel_modes, context.watched_now
    for k in range(context[ft.SWITCHES]):
        modes[k] = 0 if context.modes[k] == SLIDING else context.modes[k]
        if context.rigid[k] < 0 and context.boundary[k] == CLOSED:
            touches = abs(context.now[k]) <= ON_SURFACE * context.largest[k]
            modes[k] = 1 if touches else modes[k]
    abi.watched_of(context)(t, context.q1, context.v1, context.parameters, modes, holds)
    for i in range(context[ft.WATCHED]):
        begins = holds[i] != 0.0 and context.watched_before[i] == 0.0
        if begins and context.ends_run[i] != 0 and r.stopped_by < 0:
            r.stopped_by = i


@inner
def resolve_impact(context: Context, crossing: int, t: float) -> float:
    """Impact of contact or freewheel `crossing`, and the modes of all others; time until it closes.

    `run.flight` receives the time of the next flight, row STRUCK the closing rates of open contacts
    that touch, and 0 of all others. All other modes follow from the values of g, which stay in NOW.
    """
    r, modes = run_record(context), context.modes
    evaluate_now(context, t)
    if context[ft.WATCHED] != 0:
        meet_conditions(context, t)
    for k in range(context[ft.SWITCHES]):
        touches = context.rigid[k] >= 0 and abs(context.now[k]) <= ON_SURFACE * context.largest[k]
        closing = touches and modes[k] == 1 and context.rate_now[k] < 0.0
        context.struck[k] = -context.rate_now[k] if closing else 0.0
    flight = ft.impact_of(context)(context, crossing, t, ws.Y1)
    r.flight = flight if flight > 0.0 else np.inf
    last = predict_flights(context, crossing, t, -flight) if flight < 0.0 else 0.0
    for k in range(context[ft.SWITCHES]):
        if k == crossing or context.struck[k] > 0.0:
            context.flight[k] = t - context.impact_at[k]
            context.impact_at[k] = t
    evaluate_now(context, t)
    rounding = SLOW * largest_magnitude(context.v1)
    for k in range(context[ft.SWITCHES]):
        if context.rigid[k] >= 0:
            if k != crossing and modes[k] == SLIDING and context.rate_now[k] > rounding:
                modes[k] = 1
        elif context.sticks[k] == ONE_WAY:
            modes[k] = 1 if context.now[k] > rounding else modes[k]
        elif abs(context.now[k]) > ON_SURFACE * max(context.largest[k], context.reserve[k]):
            modes[k] = 1 if context.now[k] > 0.0 else 0
    consistency.count_sliding(context, modes)
    return last


@inner
def mark_surfaces(
    context: Context, t: float, h: float, crossing: int, impact: bool, jumped: bool
) -> None:
    """Fill row BAND of the functions that are on their surface, and zero it for all others.

    A function `crossing` that `jumped` is on neither side near it.
    """
    rigid, g, band, rates = context.rigid, context.now, context.band, context.rate_now
    slow = SLOW * largest_magnitude(context.v1) if impact else 0.0
    for k in range(context[ft.SWITCHES]):
        # An impact may give a function in sliding mode a velocity off its surface.
        slid = context.former_modes[k] == SLIDING and (context.modes[k] == SLIDING or rigid[k] >= 0)
        largest = context.reserve[k] if slid else context.largest[k]
        surface = ON_SURFACE * largest
        touches = abs(g[k]) <= max(surface, _CLOCK * abs(t * context.r1[k]))
        gripped = context.sticks[k] == ONE_WAY and g[k] <= slow
        near = (k == crossing and not jumped) or slid or touches or gripped
        if rigid[k] >= 0 and context.modes[k] == 1 and k != crossing and not slid:
            # A contact that touches took part in this impact, or rests against the one that opens;
            # any other will have an impact of its own.
            rests = impact or abs(rates[k]) * LOOK_AHEAD * h <= surface
            near = abs(g[k]) <= surface and rests
            if near and impact and rates[k] > _STILL * context.struck[k]:
                context.preferred[k] = consistency.fixed_entry(1)
        band[k] = surface_band(g[k], largest) if near else 0.0
        if k == crossing and impact and abs(g[k]) > surface:
            # It came back before it had left the band of its opening; the next impact is no deeper.
            band[k] = abs(g[k]) + surface
        if k == crossing and slid and rigid[k] >= 0:
            # It parts with the third power of time: at first by less than a step's error, which is
            # no impact.
            band[k] = max(band[k], run_record(context).rtol * largest)


@inner
def log_changes(context: Context, t: float, crossing: int, impact: bool) -> int:
    """Log the events of all functions but a contact `crossing` with an impact; their number.

    Running maxima and bands follow the changes of modes.
    """
    modes, maxima = context.modes, context.largest
    inconsistent = run_record(context).blamed != consistency.CONSISTENT
    logged = 0
    for k in range(context[ft.SWITCHES]):
        slides, slid = modes[k] == SLIDING, context.former_modes[k] == SLIDING
        if slides and not slid:
            context.reserve[k] = maxima[k]
            maxima[k] = 1.0
        elif slid and not slides:
            maxima[k] = context.reserve[k]
        if slides:
            context.band[k] = 0.0
        changes = modes[k] != context.former_modes[k]
        takes_part = impact and context.struck[k] > 0.0
        if impact and k == crossing:
            continue
        if changes or takes_part or (k == crossing and inconsistent):
            direction = _HOLDS
            if changes and not slides:
                direction = _BEGAN if modes[k] != 0 else _CEASED
            elif takes_part and not slides:
                direction = _IMPACT
            log_event(context, t, k, direction)
            logged += 1
    return logged


@inner
def select_after_closing(context: Context, t: float, ahead: float) -> int:
    """Give modes to the velocities that a contact has brought to zero by closing; events logged.

    Where bouncing ends, its last velocity is not zero before the return onto the surfaces.
    """
    modes, first = context.modes, -1
    evaluate_now(context, t)
    for k in range(context[ft.SWITCHES]):
        moved = context.rigid[k] < 0 and modes[k] != SLIDING and context.band[k] == 0.0
        if moved and abs(context.now[k]) <= ON_SURFACE * context.largest[k]:
            context.band[k] = surface_band(context.now[k], context.largest[k])
            first = k
    if first < 0:
        return 0
    copy_vector(modes, context.former_modes)
    set_preferences(context)
    run_record(context).blamed = ft.select_modes_of(context)(context, first, t, ahead, ws.Y1)
    return log_changes(context, t, first, False)


@addressed(ft.TRANSITION)
def make_transition(context: Context, crossing: int, t: float, h: float) -> int:
    """Give the state in row Y1 its next modes and, after an impact, its next velocities.

    `h` is the length of the next step as far as it is known. `run.flight` receives the time until
    the next impact of a contact that bounces, `run.blamed` a function for which there is no
    consistent mode, or `CONSISTENT`.

    Returns the number of events that were logged.
    """
    modes, r, last = context.modes, run_record(context), 0.0
    former = int(modes[crossing])
    copy_vector(modes, context.former_modes)
    r.flight = np.inf
    impact = context.rigid[crossing] >= 0 and modes[crossing] != SLIDING
    if impact:
        last = resolve_impact(context, crossing, t)
    jumped = context.rigid[crossing] < 0 and modes[crossing] != SLIDING
    if jumped:
        evaluate_now(context, t)
        now = context.now[crossing]
        jumped = not abs(now) <= _JUMP * context.largest[crossing]  # nor a number, as beyond a root
        before = now > 0.0 if modes[crossing] != 0 else now < 0.0
        if jumped and before and r.length > 0.0:
            r.blamed = consistency.CONSISTENT
            return 0  # before its pole, or before it jumps: the next step begins there
    strikes = jumped and context.sticks[crossing] == ONE_WAY
    if strikes:
        last, jumped = resolve_impact(context, crossing, t), False
    if jumped:
        # It passes no zero, as the rate of a length where this vanishes.
        modes[crossing] = 1 - modes[crossing]
        consistency.count_sliding(context, modes)
    set_preferences(context)
    if impact:
        approach, mode = context.struck[crossing], int(modes[crossing])
        leaves = mode != SLIDING and context.rate_now[crossing] > _STILL * approach
        context.preferred[crossing] = consistency.fixed_entry(mode) if leaves else SLIDING
    elif context.table_part[crossing] == KNOTS:
        context.preferred[crossing] = consistency.decided_entry(1 - former)
        prefer_released(context, crossing, t)
        evaluate_now(context, t)
    else:
        if modes[crossing] == SLIDING:
            evaluate_accelerations(context, t, context.q1, context.v1, modes, context.first_scratch)
            if rests(context, crossing):
                evaluate_now(context, t)
                side, now = (1 if context.now[crossing] > 0.0 else 0), context.now[crossing]
                away = now * context.rate_now[crossing] > 0.0
                # It is so little off that a short look ahead would see no change.
                context.preferred[crossing] = consistency.decided_entry(side) if away else side
            else:
                prefer_release(context, t, crossing)
        prefer_released(context, crossing, t)
        evaluate_now(context, t)
    impact = impact or strikes
    mark_surfaces(context, t, h, crossing, impact, jumped)
    ahead = min(LOOK_AHEAD * h, 0.1 * r.flight)
    r.blamed = ft.select_modes_of(context)(context, crossing, t, ahead, ws.Y1)
    begins = modes[crossing] == SLIDING and context.former_modes[crossing] != SLIDING
    if (begins or r.blamed == crossing) and bends_on_surface(context, t, crossing):
        copy_vector(ws.row_of(context, ws.SAMPLE), ws.row_of(context, ws.Y1))
        r.blamed = ft.select_modes_of(context)(context, crossing, t, ahead, ws.Y1)
    logged, at = 0, r.logged_events
    if impact:
        direction = _HOLDS if modes[crossing] == SLIDING else _IMPACT
        if r.blamed != consistency.CONSISTENT:
            last = 0.0  # no mode is right: nothing comes after
        log_event(context, t + last, crossing, direction)
        logged = 1
    logged += log_changes(context, t, crossing, impact)
    if logged > 0 and r.blamed == consistency.CONSISTENT:
        if context[ft.SLIDING_COUNT] != 0:
            # From here on velocities off the surfaces are zero, and steps begin with them.
            ft.return_to_surfaces_of(context)(context, t, ws.Y1)
            if impact:
                logged += select_after_closing(context, t, ahead)
        write_derivative(context, t, ws.Y1, ws.K + r.last)
        switching.evaluate_switching_and_rates(context, t, ws.Y1, ws.K + r.last, ws.G1)
        r.rhs += 1
        if last > 0.0:
            move_event(context, at, last)
    return logged
