"""Mode transition at an event: impacts, new modes, and the log of events."""

import numpy as np

from runtime.core import function_table as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace as ws
from runtime.core.array_types import Integers, Vector
from runtime.core.jit import addressed, inner
from runtime.core.modes import SLIDING, Direction
from runtime.core.rhs import evaluate_accelerations
from runtime.core.rounding import EPS
from runtime.core.run_record import run_record
from runtime.hybrid.degenerate_sliding import share_freedom
from runtime.hybrid.impact import ON_SURFACE
from runtime.hybrid.mode_consistency import (
    CONSISTENT,
    MISSED,
    count_sliding,
    mark_known,
)
from runtime.hybrid.mode_selection import prefer_released, set_preferences
from runtime.hybrid.switching_functions import (
    UNBOUNDED,
    compute_margin,
    evaluate_switching_and_rates,
)

LOOK_AHEAD = 0.05  # measured: of a step; look-ahead in which modes are judged
_BEGAN, _CEASED = int(Direction.BEGAN), int(Direction.CEASED)
_HOLDS, _IMPACT = int(Direction.HOLDS), int(Direction.IMPACT)
_FREE = 0.02  # measured: difference of the ratio of two flights in a row from that of free flights
# accuracy: of the rate before an impact; contacts that are slower after it stay closed
_STILL = 1e-12
# accuracy: of the time; difference of two instants that the clock cannot resolve
_CLOCK = 8.0 * EPS


@inner
def log_event(context: Integers, t: float, k: int, direction: int) -> None:
    """Append an event of function `k` with the state in row Y1."""
    event_t, event_kind = ft.event_times_of(context), ft.event_kinds_of(context)
    event_y, y1 = ft.event_states_of(context), ws.row_of(context, ws.Y1)
    r = run_record(context)
    length = 2 * context[ft.COORDINATES]
    row = r.logged_events
    event_t[row] = t
    event_kind[row, 0] = k
    event_kind[row, 1] = direction
    for j in range(length):
        event_y[row, j] = y1[j]
    r.logged_events += 1
    r.events += 1


@inner
def measure_approach(context: Integers, t: float) -> None:
    """Write the closing rates of open contacts that touch into row STRUCK; 0 of all others."""
    p, modes = ft.parameters_of(context), ft.modes_of(context)
    largest, struck = ws.switch_row(context, ws.LARGEST), ws.switch_row(context, ws.STRUCK)
    s, rigid = context[ft.SWITCHES], ft.rigid_of(context)
    q, v = ws.positions(context, ws.Y1), ws.velocities(context, ws.Y1)
    g, rates = ws.switch_row(context, ws.NOW), ws.switch_row(context, ws.RATE_NOW)
    abi.switching_of(context)(t, q, v, p, g)
    abi.switching_rates_of(context)(t, q, v, ws.first_half(context, ws.DELTA), p, rates)
    for k in range(s):
        touches = rigid[k] >= 0 and abs(g[k]) <= ON_SURFACE * largest[k]
        closing = touches and modes[k] == 1 and rates[k] < 0.0
        struck[k] = -rates[k] if closing else 0.0


@inner
def predict_flights(context: Integers, k: int, t: float, free: float) -> float:
    """Total time of all further flights of contact `k`.

    It is `free`, T/(1 - e), where they are free; where friction or another contact interferes, each
    is shorter than the one before in the ratio of the last two.
    """
    flight_row, impact_at = ws.switch_row(context, ws.FLIGHT), ws.switch_row(context, ws.IMPACT_AT)
    e = ft.restitution_of(context)[ft.rigid_of(context)[k]]
    before, flight = flight_row[k], t - impact_at[k]
    ratio = flight / before if before > 0.0 else e
    if abs(ratio - e) < _FREE * e or not 0.0 < ratio < 1.0:
        return free
    return float(flight * ratio / (1.0 - ratio))


@inner
def reset_modes(context: Integers, t: float, crossing: int) -> None:
    """After an impact, set the mode of every function by its value."""
    p, modes = ft.parameters_of(context), ft.modes_of(context)
    largest_row, reserve = ws.switch_row(context, ws.LARGEST), ws.switch_row(context, ws.RESERVE)
    n, s = context[ft.COORDINATES], context[ft.SWITCHES]
    rigid = ft.rigid_of(context)
    q, v = ws.positions(context, ws.Y1), ws.velocities(context, ws.Y1)
    g, rates = ws.switch_row(context, ws.NOW), ws.switch_row(context, ws.RATE_NOW)
    abi.switching_of(context)(t, q, v, p, g)
    abi.switching_rates_of(context)(t, q, v, ws.first_half(context, ws.DELTA), p, rates)
    for k in range(s):
        largest = max(largest_row[k], reserve[k])
        if rigid[k] >= 0:
            if k != crossing and modes[k] == SLIDING and rates[k] > 0.0:
                speed = 0.0
                for j in range(n):
                    speed = max(speed, abs(v[j]))
                modes[k] = 1 if rates[k] > 1e-12 * speed else SLIDING
        elif abs(g[k]) > ON_SURFACE * largest:
            modes[k] = 1 if g[k] > 0.0 else 0


@inner
def release_together(context: Integers, t: float, letting_go: int, q: Vector, v: Vector) -> None:
    """Let frictions of the same freedom that have reached their bounds break loose together.

    One after the other, each would stop the other again. The right-hand side must just have been
    evaluated.
    """
    modes, preferred = ft.modes_of(context), ws.switch_row(context, ws.PREFERRED)
    s = context[ft.SWITCHES]
    rigid, share = ft.rigid_of(context), ft.share_of(context)
    low, high = ft.share_low_of(context), ft.share_high_of(context)
    for k in range(s):
        if k == letting_go or modes[k] != SLIDING or rigid[k] >= 0 or rigid[letting_go] >= 0:
            continue
        if share_freedom(context, k, letting_go) and compute_margin(context, t, q, v, k) <= MISSED:
            side = 1 if share[k] > 0.5 * (low[k] + high[k]) else 0
            preferred[k] = mark_known(side)


@inner
def find_release_mode(context: Integers, k: int) -> int:
    """The mode, 0 or 1, of function `k` after its share has reached a bound."""
    share = ft.share_of(context)[k]
    low, high = ft.share_low_of(context)[k], ft.share_high_of(context)[k]
    return 1 if low < UNBOUNDED or share > 0.5 * (low + high) else 0


@inner
def collide(context: Integers, crossing: int, t: float) -> float:
    """Impact of contact `crossing`, and the modes of all others after it; time until it closes.

    `run.flight` receives the time of the next flight.
    """
    r, struck = run_record(context), ws.switch_row(context, ws.STRUCK)
    flights, impact_at = ws.switch_row(context, ws.FLIGHT), ws.switch_row(context, ws.IMPACT_AT)
    measure_approach(context, t)
    flight = ft.impact_of(context)(context, crossing, t, ws.Y1)
    r.flight = flight if flight > 0.0 else np.inf
    last = predict_flights(context, crossing, t, -flight) if flight < 0.0 else 0.0
    for k in range(context[ft.SWITCHES]):
        if k == crossing or struck[k] > 0.0:
            flights[k] = t - impact_at[k]
            impact_at[k] = t
    reset_modes(context, t, crossing)
    count_sliding(context, ft.modes_of(context))
    return last


@inner
def mark_surfaces(
    context: Integers, t: float, h: float, crossing: int, hit: bool, letting_go: int
) -> None:
    """Fill row BAND of the functions that are on their surface, and zero it for all others."""
    modes, before, rigid = ft.modes_of(context), ft.former_modes_of(context), ft.rigid_of(context)
    struck, preferred = ws.switch_row(context, ws.STRUCK), ws.switch_row(context, ws.PREFERRED)
    reserve, maxima = ws.switch_row(context, ws.RESERVE), ws.switch_row(context, ws.LARGEST)
    g, rates = ws.switch_row(context, ws.NOW), ws.switch_row(context, ws.RATE_NOW)
    band = ws.switch_row(context, ws.BAND)
    q, v = ws.positions(context, ws.Y1), ws.velocities(context, ws.Y1)
    abi.switching_of(context)(t, q, v, ft.parameters_of(context), g)
    for k in range(context[ft.SWITCHES]):
        # An impact may give a function in sliding mode a velocity off its surface.
        slid = before[k] == SLIDING and (modes[k] == SLIDING or rigid[k] >= 0)
        largest = reserve[k] if slid else maxima[k]
        clock = _CLOCK * abs(t * ws.switch_row(context, ws.G1 + 1)[k]) if not slid else 0.0
        band[k] = 0.0
        near = k == crossing or slid or abs(g[k]) <= max(ON_SURFACE * largest, clock)
        if rigid[k] >= 0 and modes[k] == 1 and k != crossing and not slid:
            # A contact that touches took part in this impact, or rests against the one that opens;
            # any other will have an impact of its own.
            near = abs(g[k]) <= ON_SURFACE * largest and (
                hit or abs(rates[k]) * LOOK_AHEAD * h <= ON_SURFACE * largest
            )
            if near and hit and rates[k] > _STILL * struck[k]:
                preferred[k] = mark_known(1)
        if near:
            band[k] = 2.0 * abs(g[k]) + 1e-14 * largest + 1e-300
            if k == letting_go and rigid[k] >= 0:
                # It parts with the third power of time: at first by less than a step's error, which
                # is no impact.
                band[k] = max(band[k], run_record(context).rtol * largest)


@inner
def log_changes(context: Integers, t: float, crossing: int, hit: bool) -> int:
    """Log the events of all functions but the contact `crossing` that was hit; their number.

    Running maxima and bands follow the changes of modes.
    """
    modes, before = ft.modes_of(context), ft.former_modes_of(context)
    struck_row, band = ws.switch_row(context, ws.STRUCK), ws.switch_row(context, ws.BAND)
    reserve, maxima = ws.switch_row(context, ws.RESERVE), ws.switch_row(context, ws.LARGEST)
    inconsistent = run_record(context).blamed != CONSISTENT
    logged = 0
    for k in range(context[ft.SWITCHES]):
        slides, slid = modes[k] == SLIDING, before[k] == SLIDING
        if slides and not slid:
            reserve[k] = maxima[k]
            maxima[k] = 1.0
        elif slid and not slides:
            maxima[k] = reserve[k]
        if slides:
            band[k] = 0.0
        blamed = k == crossing and inconsistent
        struck = hit and struck_row[k] > 0.0
        if (modes[k] != before[k] or blamed or struck) and not (hit and k == crossing):
            direction = _HOLDS
            if modes[k] != before[k] and not slides:
                direction = _BEGAN if modes[k] != 0 else _CEASED
            elif struck and not slides:
                direction = _IMPACT
            log_event(context, t, k, direction)
            logged += 1
    return logged


@addressed(ft.TRANSITION)
def change_modes(context: Integers, crossing: int, t: float, h: float) -> int:
    """Give the state in row Y1 its next modes and, after an impact, its next velocities.

    `h` is the length of the next step as far as it is known. `run.flight` receives the time until
    the next impact of a contact that bounces, `run.blamed` a function for which there is no
    consistent mode, or `CONSISTENT`.

    Returns the number of events that were logged.
    """
    modes, before = ft.modes_of(context), ft.former_modes_of(context)
    preferred, r = ws.switch_row(context, ws.PREFERRED), run_record(context)
    q, v = ws.positions(context, ws.Y1), ws.velocities(context, ws.Y1)
    for k in range(context[ft.SWITCHES]):
        before[k] = modes[k]
    r.flight = np.inf
    letting_go, side, last = -1, 0, 0.0
    if modes[crossing] == SLIDING:
        letting_go = crossing
        evaluate_accelerations(context, t, q, v, modes, ws.first_half(context, ws.DELTA))
        side = find_release_mode(context, crossing)
    hit = ft.rigid_of(context)[crossing] >= 0 and letting_go < 0
    if hit:
        last = collide(context, crossing, t)
    set_preferences(context, letting_go, side)
    if letting_go >= 0:
        release_together(context, t, letting_go, q, v)
    if not hit:
        prefer_released(context, crossing, t, q, v)
    rates, a = ws.switch_row(context, ws.RATE_NOW), ws.first_half(context, ws.DELTA)
    abi.switching_rates_of(context)(t, q, v, a, ft.parameters_of(context), rates)
    if hit:
        approach = ws.switch_row(context, ws.STRUCK)[crossing]
        leaves = modes[crossing] != SLIDING and rates[crossing] > _STILL * approach
        preferred[crossing] = mark_known(modes[crossing]) if leaves else SLIDING
    mark_surfaces(context, t, h, crossing, hit, letting_go)
    ahead = min(LOOK_AHEAD * h, 0.1 * r.flight)
    r.blamed = ft.select_modes_of(context)(context, crossing, t, ahead, ws.Y1, ws.G1)
    logged = 0
    if hit:
        direction = _HOLDS if modes[crossing] == SLIDING else _IMPACT
        last = last if r.blamed == CONSISTENT else 0.0  # no mode is right: nothing comes after
        log_event(context, t + last, crossing, direction)
        logged = 1
    logged += log_changes(context, t, crossing, hit)
    if logged > 0 and r.blamed == CONSISTENT:
        if context[ft.SLIDING_COUNT] != 0:
            # From here on velocities off the surfaces are zero, and steps begin with them.
            ft.return_to_surfaces_of(context)(context, t, ws.Y1)
        slope = ws.position_rates(context, ws.K + r.last)
        for j in range(context[ft.COORDINATES]):
            slope[j] = v[j]
        evaluate_accelerations(context, t, q, v, modes, ws.velocity_rates(context, ws.K + r.last))
        evaluate_switching_and_rates(context, t, ws.Y1, ws.K + r.last, ws.G1)
        r.rhs += 1
    return logged
