"""Mode transition at an event: impacts, new modes, and the log of events."""

import numpy as np

from runtime.core import function_table as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Integers, Vector
from runtime.core.jit import addressed, inner
from runtime.core.loop_record import run_record
from runtime.core.modes import SLIDING, Direction
from runtime.core.rhs import evaluate_accelerations, write_derivative
from runtime.core.rounding import EPS
from runtime.hybrid import mode_consistency as consistency
from runtime.hybrid import switching_functions as switching
from runtime.hybrid.impact import ON_SURFACE
from runtime.hybrid.mode_selection import prefer_released, set_preferences, surface_band
from runtime.hybrid.redundant_sliding import share_freedom
from runtime.linalg.vectors import copy_vector, largest_magnitude

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
    r, kinds = run_record(context), ft.event_kinds_of(context)
    ft.event_times_of(context)[r.logged_events] = t
    kinds[r.logged_events, 0], kinds[r.logged_events, 1] = k, direction
    copy_vector(ws.row_of(context, ws.Y1), ft.event_states_of(context)[r.logged_events])
    r.logged_events += 1
    r.events += 1


@inner
def evaluate_now(context: Integers, t: float) -> None:
    """Write g of the state in row Y1 into row NOW, and its rate into RATE_NOW.

    The accelerations do not count: of contacts, whose rates are read, they are no part.
    """
    p, q, v = ft.parameters_of(context), ws.positions(context, ws.Y1), ws.velocities(context, ws.Y1)
    a, rates = ws.first_half(context, ws.DELTA), ws.switch_row(context, ws.RATE_NOW)
    abi.switching_of(context)(t, q, v, p, ws.switch_row(context, ws.NOW))
    abi.switching_rates_of(context)(t, q, v, a, p, rates)


@inner
def measure_approach(context: Integers, t: float) -> None:
    """Write the closing rates of open contacts that touch into row STRUCK; 0 of all others."""
    modes, rigid = ft.modes_of(context), ft.rigid_of(context)
    largest, struck = ws.switch_row(context, ws.LARGEST), ws.switch_row(context, ws.STRUCK)
    g, rates = ws.switch_row(context, ws.NOW), ws.switch_row(context, ws.RATE_NOW)
    evaluate_now(context, t)
    for k in range(context[ft.SWITCHES]):
        touches = rigid[k] >= 0 and abs(g[k]) <= ON_SURFACE * largest[k]
        closing = touches and modes[k] == 1 and rates[k] < 0.0
        struck[k] = -rates[k] if closing else 0.0


@inner
def predict_flights(context: Integers, k: int, t: float, free: float) -> float:
    """Total time of all further flights of contact `k`.

    It is `free`, T/(1 - e), where they are free; where friction or another contact interferes, each
    is shorter than the one before in the ratio of the last two.
    """
    e = ft.restitution_of(context)[ft.rigid_of(context)[k]]
    before = ws.switch_row(context, ws.FLIGHT)[k]
    flight = t - ws.switch_row(context, ws.IMPACT_AT)[k]
    ratio = flight / before if before > 0.0 else e
    if abs(ratio - e) < _FREE * e or not 0.0 < ratio < 1.0:
        return free
    return float(flight * ratio / (1.0 - ratio))


@inner
def reset_modes(context: Integers, t: float, crossing: int) -> None:
    """After an impact, set the mode of every function by its value."""
    modes, rigid = ft.modes_of(context), ft.rigid_of(context)
    largest, reserve = ws.switch_row(context, ws.LARGEST), ws.switch_row(context, ws.RESERVE)
    g, rates = ws.switch_row(context, ws.NOW), ws.switch_row(context, ws.RATE_NOW)
    evaluate_now(context, t)
    rounding = 1e-12 * largest_magnitude(ws.velocities(context, ws.Y1))
    for k in range(context[ft.SWITCHES]):
        if rigid[k] >= 0:
            if k != crossing and modes[k] == SLIDING and rates[k] > rounding:
                modes[k] = 1
        elif abs(g[k]) > ON_SURFACE * max(largest[k], reserve[k]):
            modes[k] = 1 if g[k] > 0.0 else 0
    consistency.count_sliding(context, modes)


@inner
def prefer_release(context: Integers, t: float, crossing: int, q: Vector, v: Vector) -> None:
    """Let function `crossing`, whose share has reached a bound, go to that side, in row PREFERRED.

    At the bound the acceleration of that mode equals that of sliding, so that a look-ahead at
    constant acceleration would show no change. Frictions of the same freedom that have reached
    their bounds break loose together: one after the other, each would stop the other again. The
    accelerations must just have been evaluated.
    """
    modes, preferred = ft.modes_of(context), ws.switch_row(context, ws.PREFERRED)
    rigid = ft.rigid_of(context)
    unbounded = ft.share_low_of(context)[crossing] < switching.UNBOUNDED
    mode = 1 if unbounded else consistency.nearest_mode(context, crossing)
    preferred[crossing] = consistency.decided_entry(mode)
    for k in range(context[ft.SWITCHES]):
        if k == crossing or modes[k] != SLIDING or rigid[k] >= 0 or rigid[crossing] >= 0:
            continue
        if not share_freedom(context, k, crossing):
            continue
        if switching.compute_margin(context, t, q, v, k) <= consistency.MISSED:
            preferred[k] = consistency.decided_entry(consistency.nearest_mode(context, k))


@inner
def resolve_impact(context: Integers, crossing: int, t: float) -> float:
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
    return last


@inner
def mark_surfaces(context: Integers, t: float, h: float, crossing: int, impact: bool) -> None:
    """Fill row BAND of the functions that are on their surface, and zero it for all others."""
    modes, before, rigid = ft.modes_of(context), ft.former_modes_of(context), ft.rigid_of(context)
    struck, preferred = ws.switch_row(context, ws.STRUCK), ws.switch_row(context, ws.PREFERRED)
    reserve, maxima = ws.switch_row(context, ws.RESERVE), ws.switch_row(context, ws.LARGEST)
    g, rates = ws.switch_row(context, ws.NOW), ws.switch_row(context, ws.RATE_NOW)
    band, r1 = ws.switch_row(context, ws.BAND), ws.switch_row(context, ws.G1 + 1)
    for k in range(context[ft.SWITCHES]):
        # An impact may give a function in sliding mode a velocity off its surface.
        slid = before[k] == SLIDING and (modes[k] == SLIDING or rigid[k] >= 0)
        largest = reserve[k] if slid else maxima[k]
        near = (
            k == crossing or slid or abs(g[k]) <= max(ON_SURFACE * largest, _CLOCK * abs(t * r1[k]))
        )
        if rigid[k] >= 0 and modes[k] == 1 and k != crossing and not slid:
            # A contact that touches took part in this impact, or rests against the one that opens;
            # any other will have an impact of its own.
            surface = ON_SURFACE * largest
            near = abs(g[k]) <= surface and (impact or abs(rates[k]) * LOOK_AHEAD * h <= surface)
            if near and impact and rates[k] > _STILL * struck[k]:
                preferred[k] = consistency.decided_entry(1)
        band[k] = surface_band(g[k], largest) if near else 0.0
        if k == crossing and slid and rigid[k] >= 0:
            # It parts with the third power of time: at first by less than a step's error, which is
            # no impact.
            band[k] = max(band[k], run_record(context).rtol * largest)


@inner
def log_changes(context: Integers, t: float, crossing: int, impact: bool) -> int:
    """Log the events of all functions but a contact `crossing` with an impact; their number.

    Running maxima and bands follow the changes of modes.
    """
    modes, before = ft.modes_of(context), ft.former_modes_of(context)
    struck, band = ws.switch_row(context, ws.STRUCK), ws.switch_row(context, ws.BAND)
    reserve, maxima = ws.switch_row(context, ws.RESERVE), ws.switch_row(context, ws.LARGEST)
    inconsistent = run_record(context).blamed != consistency.CONSISTENT
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
        changes, takes_part = modes[k] != before[k], impact and struck[k] > 0.0
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


@addressed(ft.TRANSITION)
def make_transition(context: Integers, crossing: int, t: float, h: float) -> int:
    """Give the state in row Y1 its next modes and, after an impact, its next velocities.

    `h` is the length of the next step as far as it is known. `run.flight` receives the time until
    the next impact of a contact that bounces, `run.blamed` a function for which there is no
    consistent mode, or `CONSISTENT`.

    Returns the number of events that were logged.
    """
    modes, r, last = ft.modes_of(context), run_record(context), 0.0
    preferred, rates = ws.switch_row(context, ws.PREFERRED), ws.switch_row(context, ws.RATE_NOW)
    q, v = ws.positions(context, ws.Y1), ws.velocities(context, ws.Y1)
    copy_vector(modes, ft.former_modes_of(context))
    r.flight = np.inf
    impact = ft.rigid_of(context)[crossing] >= 0 and modes[crossing] != SLIDING
    if impact:
        last = resolve_impact(context, crossing, t)
        set_preferences(context)
    else:
        set_preferences(context)
        if modes[crossing] == SLIDING:
            evaluate_accelerations(context, t, q, v, modes, ws.first_half(context, ws.DELTA))
            prefer_release(context, t, crossing, q, v)
        prefer_released(context, crossing, t, q, v)
    evaluate_now(context, t)
    if impact:
        approach = ws.switch_row(context, ws.STRUCK)[crossing]
        leaves = modes[crossing] != SLIDING and rates[crossing] > _STILL * approach
        mode = int(modes[crossing])
        preferred[crossing] = consistency.decided_entry(mode) if leaves else SLIDING
    mark_surfaces(context, t, h, crossing, impact)
    ahead = min(LOOK_AHEAD * h, 0.1 * r.flight)
    r.blamed = ft.select_modes_of(context)(context, crossing, t, ahead, ws.Y1)
    logged = 0
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
        write_derivative(context, t, ws.Y1, ws.K + r.last)
        switching.evaluate_switching_and_rates(context, t, ws.Y1, ws.K + r.last, ws.G1)
        r.rhs += 1
    return logged
