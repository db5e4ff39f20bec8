"""What happens at an instant at which a switching function has crossed: impacts and new modes."""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.function_table import (
    COORDINATES,
    SLIDING_COUNT,
    SWITCHES,
    TRANSITION,
    event_kinds_of,
    event_states_of,
    event_times_of,
    former_modes_of,
    impact_of,
    modes_of,
    parameters_of,
    restitution_of,
    return_held_of,
    rigid_of,
    settle_of,
    share_high_of,
    share_low_of,
    share_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import switching_of, switching_rates_of
from runtime.core.rhs import field
from runtime.core.rounding import EPS
from runtime.core.run_record import run_record
from runtime.core.workspace import (
    BAND,
    DELTA,
    FLIGHT,
    G1,
    IMPACT_AT,
    LARGEST,
    NOW,
    PREFERRED,
    RATE_NOW,
    RESERVE,
    STRUCK,
    Y1,
    K,
    first_half,
    position_rates,
    positions,
    row_of,
    switch_row,
    velocities,
    velocity_rates,
)
from runtime.hybrid.degenerate_sliding import same
from runtime.hybrid.impact import ON_SURFACE
from runtime.hybrid.mode_consistency import CONSISTENT, GIVEN, MISSED, hold
from runtime.hybrid.mode_selection import go_on, prefer
from runtime.hybrid.sliding_modes import HELD_MODE
from runtime.hybrid.switching_functions import UNBOUNDED, margin, measure

LOOK_AHEAD = 0.05  # measured: of a step; how far ahead modes are judged
BEGAN, CEASED, HELD, IMPACT = 1, -1, 0, 2
"""Directions of an event."""

_FREE = 0.02  # measured: difference of the ratio of two flights in a row from that of free flights
# accuracy: of the rate before an impact; a contact that is slower after it does not leave
_STILL = 1e-12
# accuracy: of the time; difference of two instants that the clock cannot resolve
_CLOCK = 8.0 * EPS


@inner
def log_event(context: Integers, t: float, k: int, direction: int) -> None:
    """Append an event of function `k` with the state in row Y1."""
    event_t = event_times_of(context)
    event_kind = event_kinds_of(context)
    event_y = event_states_of(context)
    y1 = row_of(context, Y1)
    r = run_record(context)
    length = 2 * context[COORDINATES]
    at = r.logged_events
    event_t[at] = t
    event_kind[at, 0] = k
    event_kind[at, 1] = direction
    for j in range(length):
        event_y[at, j] = y1[j]
    r.logged_events += 1
    r.events += 1


@inner
def approaching(context: Integers, t: float) -> None:
    """Write in row STRUCK at what rate the open contacts that touch are closing; 0: they do not."""
    p = parameters_of(context)
    modes = modes_of(context)
    largest = switch_row(context, LARGEST)
    struck = switch_row(context, STRUCK)
    s = context[SWITCHES]
    rigid = rigid_of(context)
    q, v = positions(context, Y1), velocities(context, Y1)
    g, rates = switch_row(context, NOW), switch_row(context, RATE_NOW)
    switching_of(context)(t, q, v, p, g)
    switching_rates_of(context)(t, q, v, first_half(context, DELTA), p, rates)
    for k in range(s):
        touches = rigid[k] >= 0 and abs(g[k]) <= ON_SURFACE * largest[k]
        closing = touches and modes[k] == 1 and rates[k] < 0.0
        struck[k] = -rates[k] if closing else 0.0


@inner
def remaining(context: Integers, k: int, t: float, free: float) -> float:
    """Time that all further flights of contact `k` take together.

    That is `free`, T/(1 - e), where they are free; where friction or another contact meddles with
    them, each is shorter than the one before in the ratio of the last two.
    """
    flight_row = switch_row(context, FLIGHT)
    impact_at = switch_row(context, IMPACT_AT)
    e = restitution_of(context)[rigid_of(context)[k]]
    before, flight = flight_row[k], t - impact_at[k]
    ratio = flight / before if before > 0.0 else e
    if abs(ratio - e) < _FREE * e or not 0.0 < ratio < 1.0:
        return free
    return float(flight * ratio / (1.0 - ratio))


@inner
def jumped(context: Integers, t: float, crossing: int) -> None:
    """After velocities have jumped, give every function the mode that its value asks for."""
    p = parameters_of(context)
    modes = modes_of(context)
    largest_row = switch_row(context, LARGEST)
    reserve = switch_row(context, RESERVE)
    n = context[COORDINATES]
    s = context[SWITCHES]
    rigid = rigid_of(context)
    q, v = positions(context, Y1), velocities(context, Y1)
    g, rates = switch_row(context, NOW), switch_row(context, RATE_NOW)
    switching_of(context)(t, q, v, p, g)
    switching_rates_of(context)(t, q, v, first_half(context, DELTA), p, rates)
    for k in range(s):
        largest = max(largest_row[k], reserve[k])
        if rigid[k] >= 0:
            if k != crossing and modes[k] == HELD_MODE and rates[k] > 0.0:
                speed = 0.0
                for j in range(n):
                    speed = max(speed, abs(v[j]))
                modes[k] = 1 if rates[k] > 1e-12 * speed else HELD_MODE
        elif abs(g[k]) > ON_SURFACE * largest:
            modes[k] = 1 if g[k] > 0.0 else 0


@inner
def together(context: Integers, t: float, letting_go: int, q: Vector, v: Vector) -> None:
    """Let go, with `letting_go`, frictions of the same freedom that have reached bounds with it.

    One after the other, each would take up again what the other has just let go. The field must
    just have been evaluated.
    """
    modes = modes_of(context)
    preferred = switch_row(context, PREFERRED)
    s = context[SWITCHES]
    rigid, share = rigid_of(context), share_of(context)
    low, high = share_low_of(context), share_high_of(context)
    for k in range(s):
        if k == letting_go or modes[k] != HELD_MODE or rigid[k] >= 0 or rigid[letting_go] >= 0:
            continue
        if same(context, k, letting_go) and margin(context, t, q, v, s, k) <= MISSED:
            side = 1 if share[k] > 0.5 * (low[k] + high[k]) else 0
            preferred[k] = side + GIVEN


@addressed(TRANSITION)
def transition(context: Integers, crossing: int, t: float, h: float) -> int:
    """Give the state in row Y1 the modes and, after an impact, the velocities of what follows.

    `h` is the length of the next step as far as it is known. `run.flight` receives the time until
    the next impact of a contact that bounces, `run.blamed` a function for which there is no
    consistent mode, or `CONSISTENT`.

    Returns the number of events that were logged.
    """
    p = parameters_of(context)
    modes = modes_of(context)
    struck_row = switch_row(context, STRUCK)
    flight_row = switch_row(context, FLIGHT)
    impact_at = switch_row(context, IMPACT_AT)
    preferred = switch_row(context, PREFERRED)
    reserve = switch_row(context, RESERVE)
    largest_row = switch_row(context, LARGEST)
    band = switch_row(context, BAND)
    r = run_record(context)
    n = context[COORDINATES]
    s = context[SWITCHES]
    rigid = rigid_of(context)
    before = former_modes_of(context)
    q, v = positions(context, Y1), velocities(context, Y1)
    slope, a = position_rates(context, K + r.last), velocity_rates(context, K + r.last)
    for k in range(s):
        before[k] = modes[k]
    r.flight = np.inf
    letting_go, side, last = -1, 0, 0.0
    if modes[crossing] == HELD_MODE:
        letting_go = crossing
        field(context, t, q, v, modes, first_half(context, DELTA))
        share = share_of(context)[crossing]
        low, high = share_low_of(context)[crossing], share_high_of(context)[crossing]
        side = 1 if low < UNBOUNDED or share > 0.5 * (low + high) else 0
    hit = rigid[crossing] >= 0 and letting_go < 0
    if hit:
        approaching(context, t)
        flight = impact_of(context)(context, crossing, t, Y1)
        r.flight = flight if flight > 0.0 else np.inf
        last = remaining(context, crossing, t, -flight) if flight < 0.0 else 0.0
        for k in range(s):
            if k == crossing or struck_row[k] > 0.0:
                flight_row[k] = t - impact_at[k]
                impact_at[k] = t
        jumped(context, t, crossing)
        hold(context, modes)
    prefer(context, letting_go, side)
    if letting_go >= 0:
        together(context, t, letting_go, q, v)
    if not hit:
        go_on(context, crossing, t, q, v)
    rates = switch_row(context, RATE_NOW)
    switching_rates_of(context)(t, q, v, first_half(context, DELTA), p, rates)
    if hit:
        leaves = modes[crossing] != HELD_MODE and rates[crossing] > _STILL * struck_row[crossing]
        preferred[crossing] = modes[crossing] + GIVEN if leaves else HELD_MODE
    g = switch_row(context, NOW)
    switching_of(context)(t, q, v, p, g)
    for k in range(s):
        # An impact tears away from its surface what it has given a velocity.
        was_held = before[k] == HELD_MODE and (modes[k] == HELD_MODE or rigid[k] >= 0)
        largest = reserve[k] if was_held else largest_row[k]
        clock = _CLOCK * abs(t * switch_row(context, G1 + 1)[k]) if not was_held else 0.0
        band[k] = 0.0
        near = k == crossing or was_held or abs(g[k]) <= max(ON_SURFACE * largest, clock)
        if rigid[k] >= 0 and modes[k] == 1 and k != crossing and not was_held:
            # It took part in this impact where it touched, or rests against what lets go now; else
            # it will have an impact of its own.
            near = abs(g[k]) <= ON_SURFACE * largest and (
                hit or abs(rates[k]) * LOOK_AHEAD * h <= ON_SURFACE * largest
            )
            if near and hit and rates[k] > _STILL * struck_row[k]:
                preferred[k] = 1 + GIVEN
        if near:
            band[k] = 2.0 * abs(g[k]) + 1e-14 * largest + 1e-300
            if k == letting_go and rigid[k] >= 0:
                # It parts with the third power of time: at first by less than a step's error, which
                # is no impact.
                band[k] = max(band[k], r.rtol * largest)
    ahead = min(LOOK_AHEAD * h, 0.1 * r.flight)
    r.blamed = settle_of(context)(context, crossing, t, ahead, Y1, G1)
    logged = 0
    if hit:
        direction = HELD if modes[crossing] == HELD_MODE else IMPACT
        last = last if r.blamed == CONSISTENT else 0.0  # no mode is right: nothing comes after
        log_event(context, t + last, crossing, direction)
        logged = 1
    for k in range(s):
        held, was_held = modes[k] == HELD_MODE, before[k] == HELD_MODE
        if held and not was_held:
            reserve[k] = largest_row[k]
            largest_row[k] = 1.0
        elif was_held and not held:
            largest_row[k] = reserve[k]
        if held:
            band[k] = 0.0
        blamed = k == crossing and r.blamed != CONSISTENT
        struck = hit and struck_row[k] > 0.0
        if (modes[k] != before[k] or blamed or struck) and not (hit and k == crossing):
            direction = HELD
            if modes[k] != before[k] and not held:
                direction = BEGAN if modes[k] != 0 else CEASED
            elif struck and not held:
                direction = IMPACT
            log_event(context, t, k, direction)
            logged += 1
    if logged > 0 and r.blamed == CONSISTENT:
        if context[SLIDING_COUNT] != 0:
            # From here on velocities along what is held are none, and steps begin with these.
            return_held_of(context)(context, t, Y1)
        for j in range(n):
            slope[j] = v[j]
        field(context, t, q, v, modes, a)
        measure(context, t, Y1, K + r.last, G1)
        r.rhs += 1
    return logged
