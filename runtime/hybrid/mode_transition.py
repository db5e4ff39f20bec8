"""What happens at an instant at which a switching function has crossed: impacts and new modes."""

import numpy as np

from runtime.core.array_views import floats_at, integers_at, view
from runtime.core.function_table import HELD as HELD_COUNT
from runtime.core.function_table import (
    HIGH,
    LOW,
    RESTITUTION,
    RIGID,
    RIGID_COUNT,
    SHARE,
    SWITCHES,
    impact_of,
    return_held_of,
    settle_of,
    switching_of,
    switching_rates_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.rhs import field
from runtime.core.rounding import EPS
from runtime.core.signatures import (
    TRANSITION,
    IntegerMatrix,
    Integers,
    Matrix,
    Vector,
)
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
    ROWS,
    STRUCK,
    Y1,
    K,
    Run,
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
def log_event(
    t: float,
    k: int,
    direction: int,
    w: Vector,
    run: Run,
    event_t: Vector,
    event_kind: IntegerMatrix,
    event_y: Matrix,
) -> None:
    """Append an event of function `k` with the state in row Y1."""
    r = run[0]
    length = w.size // ROWS
    at = r.logged_events
    event_t[at] = t
    event_kind[at, 0] = k
    event_kind[at, 1] = direction
    for j in range(length):
        event_y[at, j] = w[Y1 * length + j]
    r.logged_events += 1
    r.events += 1


@inner
def approaching(
    machine: Integers, t: float, w: Vector, sw: Vector, p: Vector, modes: Integers
) -> None:
    """Write in row STRUCK at what rate the open contacts that touch are closing; 0: they do not."""
    n = w.size // (2 * ROWS)
    s = modes.size
    rigid = integers_at(machine, RIGID, s)
    q, v = view(w, Y1 * 2 * n, n), view(w, Y1 * 2 * n + n, n)
    g, rates = view(sw, NOW * s, s), view(sw, RATE_NOW * s, s)
    switching_of(machine)(t, q, v, p, g)
    switching_rates_of(machine)(t, q, v, view(w, DELTA * 2 * n, n), p, rates)
    for k in range(s):
        touches = rigid[k] >= 0 and abs(g[k]) <= ON_SURFACE * sw[LARGEST * s + k]
        closing = touches and modes[k] == 1 and rates[k] < 0.0
        sw[STRUCK * s + k] = -rates[k] if closing else 0.0


@inner
def remaining(machine: Integers, k: int, t: float, free: float, sw: Vector) -> float:
    """Time that all further flights of contact `k` take together.

    That is `free`, T/(1 - e), where they are free; where friction or another contact meddles with
    them, each is shorter than the one before in the ratio of the last two.
    """
    s = machine[SWITCHES]
    e = floats_at(machine, RESTITUTION, machine[RIGID_COUNT])[integers_at(machine, RIGID, s)[k]]
    before, flight = sw[FLIGHT * s + k], t - sw[IMPACT_AT * s + k]
    ratio = flight / before if before > 0.0 else e
    if abs(ratio - e) < _FREE * e or not 0.0 < ratio < 1.0:
        return free
    return float(flight * ratio / (1.0 - ratio))


@inner
def jumped(
    machine: Integers, t: float, crossing: int, w: Vector, sw: Vector, p: Vector, modes: Integers
) -> None:
    """After velocities have jumped, give every function the mode that its value asks for."""
    n = w.size // (2 * ROWS)
    s = modes.size
    rigid = integers_at(machine, RIGID, s)
    q, v = view(w, Y1 * 2 * n, n), view(w, Y1 * 2 * n + n, n)
    g, rates = view(sw, NOW * s, s), view(sw, RATE_NOW * s, s)
    switching_of(machine)(t, q, v, p, g)
    switching_rates_of(machine)(t, q, v, view(w, DELTA * 2 * n, n), p, rates)
    for k in range(s):
        largest = max(sw[LARGEST * s + k], sw[RESERVE * s + k])
        if rigid[k] >= 0:
            if k != crossing and modes[k] == HELD_MODE and rates[k] > 0.0:
                speed = 0.0
                for j in range(n):
                    speed = max(speed, abs(v[j]))
                modes[k] = 1 if rates[k] > 1e-12 * speed else HELD_MODE
        elif abs(g[k]) > ON_SURFACE * largest:
            modes[k] = 1 if g[k] > 0.0 else 0


@inner
def together(
    machine: Integers,
    t: float,
    letting_go: int,
    q: Vector,
    v: Vector,
    sw: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> None:
    """Let go, with `letting_go`, frictions of the same freedom that have reached bounds with it.

    One after the other, each would take up again what the other has just let go. The field must
    just have been evaluated.
    """
    s = modes.size
    rigid, share = integers_at(machine, RIGID, s), floats_at(machine, SHARE, s)
    low, high = floats_at(machine, LOW, s), floats_at(machine, HIGH, s)
    for k in range(s):
        if k == letting_go or modes[k] != HELD_MODE or rigid[k] >= 0 or rigid[letting_go] >= 0:
            continue
        if same(machine, k, letting_go) and margin(machine, t, q, v, p, lam, s, k) <= MISSED:
            side = 1 if share[k] > 0.5 * (low[k] + high[k]) else 0
            sw[PREFERRED * s + k] = side + GIVEN


@addressed(TRANSITION)
def transition(
    machine: Integers,
    crossing: int,
    t: float,
    h: float,
    w: Vector,
    sw: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    scratch: Integers,
    lam: Vector,
    event_t: Vector,
    event_kind: IntegerMatrix,
    event_y: Matrix,
) -> int:
    """Give the state in row Y1 the modes and, after an impact, the velocities of what follows.

    `h` is the length of the next step as far as it is known. `run.flight` receives the time until
    the next impact of a contact that bounces, `run.blamed` a function for which there is no
    consistent mode, or `CONSISTENT`.

    Returns the number of events that were logged.
    """
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    s = modes.size
    rigid = integers_at(machine, RIGID, s)
    before = view(scratch, 3 * s + 1, s)
    q, v = view(w, Y1 * length, n), view(w, Y1 * length + n, n)
    slope, a = view(w, (K + r.last) * length, n), view(w, (K + r.last) * length + n, n)
    for k in range(s):
        before[k] = modes[k]
    r.flight = np.inf
    letting_go, side, last = -1, 0, 0.0
    if modes[crossing] == HELD_MODE:
        letting_go = crossing
        field(machine, t, q, v, p, modes, view(w, DELTA * length, n), lam)
        share = floats_at(machine, SHARE, s)[crossing]
        low, high = floats_at(machine, LOW, s)[crossing], floats_at(machine, HIGH, s)[crossing]
        side = 1 if low < UNBOUNDED or share > 0.5 * (low + high) else 0
    hit = rigid[crossing] >= 0 and letting_go < 0
    if hit:
        approaching(machine, t, w, sw, p, modes)
        flight = impact_of(machine)(machine, crossing, t, Y1, w, sw, p, modes, lam)
        r.flight = flight if flight > 0.0 else np.inf
        last = remaining(machine, crossing, t, -flight, sw) if flight < 0.0 else 0.0
        for k in range(s):
            if k == crossing or sw[STRUCK * s + k] > 0.0:
                sw[FLIGHT * s + k] = t - sw[IMPACT_AT * s + k]
                sw[IMPACT_AT * s + k] = t
        jumped(machine, t, crossing, w, sw, p, modes)
        hold(machine, modes)
    prefer(machine, letting_go, side, sw, modes)
    if letting_go >= 0:
        together(machine, t, letting_go, q, v, sw, p, modes, lam)
    if not hit:
        go_on(machine, crossing, t, q, v, w, sw, p, modes, lam)
    rates = view(sw, RATE_NOW * s, s)
    switching_rates_of(machine)(t, q, v, view(w, DELTA * length, n), p, rates)
    if hit:
        leaves = (
            modes[crossing] != HELD_MODE and rates[crossing] > _STILL * sw[STRUCK * s + crossing]
        )
        sw[PREFERRED * s + crossing] = modes[crossing] + GIVEN if leaves else HELD_MODE
    g = view(sw, NOW * s, s)
    switching_of(machine)(t, q, v, p, g)
    for k in range(s):
        # An impact tears away from its surface what it has given a velocity.
        was_held = before[k] == HELD_MODE and (modes[k] == HELD_MODE or rigid[k] >= 0)
        largest = sw[RESERVE * s + k] if was_held else sw[LARGEST * s + k]
        clock = _CLOCK * abs(t * sw[(G1 + 1) * s + k]) if not was_held else 0.0
        sw[BAND * s + k] = 0.0
        near = k == crossing or was_held or abs(g[k]) <= max(ON_SURFACE * largest, clock)
        if rigid[k] >= 0 and modes[k] == 1 and k != crossing and not was_held:
            # It took part in this impact where it touched, or rests against what lets go now; else
            # it will have an impact of its own.
            near = abs(g[k]) <= ON_SURFACE * largest and (
                hit or abs(rates[k]) * LOOK_AHEAD * h <= ON_SURFACE * largest
            )
            if near and hit and rates[k] > _STILL * sw[STRUCK * s + k]:
                sw[PREFERRED * s + k] = 1 + GIVEN
        if near:
            sw[BAND * s + k] = 2.0 * abs(g[k]) + 1e-14 * largest + 1e-300
            if k == letting_go and rigid[k] >= 0:
                # It parts with the third power of time: at first by less than a step's error, which
                # is no impact.
                sw[BAND * s + k] = max(sw[BAND * s + k], r.rtol * largest)
    ahead = min(LOOK_AHEAD * h, 0.1 * r.flight)
    r.blamed = settle_of(machine)(
        machine, crossing, t, ahead, Y1, G1, w, sw, p, modes, scratch, lam
    )
    logged = 0
    if hit:
        direction = HELD if modes[crossing] == HELD_MODE else IMPACT
        last = last if r.blamed == CONSISTENT else 0.0  # no mode is right: nothing comes after
        log_event(t + last, crossing, direction, w, run, event_t, event_kind, event_y)
        logged = 1
    for k in range(s):
        held, was_held = modes[k] == HELD_MODE, before[k] == HELD_MODE
        if held and not was_held:
            sw[RESERVE * s + k] = sw[LARGEST * s + k]
            sw[LARGEST * s + k] = 1.0
        elif was_held and not held:
            sw[LARGEST * s + k] = sw[RESERVE * s + k]
        if held:
            sw[BAND * s + k] = 0.0
        blamed = k == crossing and r.blamed != CONSISTENT
        struck = hit and sw[STRUCK * s + k] > 0.0
        if (modes[k] != before[k] or blamed or struck) and not (hit and k == crossing):
            direction = HELD
            if modes[k] != before[k] and not held:
                direction = BEGAN if modes[k] != 0 else CEASED
            elif struck and not held:
                direction = IMPACT
            log_event(t, k, direction, w, run, event_t, event_kind, event_y)
            logged += 1
    if logged > 0 and r.blamed == CONSISTENT:
        if machine[HELD_COUNT] != 0:
            # From here on velocities along what is held are none, and steps begin with these.
            return_held_of(machine)(machine, t, Y1, w, p, modes, lam)
        for j in range(n):
            slope[j] = v[j]
        field(machine, t, q, v, p, modes, a, lam)
        measure(machine, t, Y1, K + r.last, G1, w, sw, p, modes, lam)
        r.rhs += 1
    return logged
