"""Which switching conditions hold just after an instant at which some are on their surface.

The state is carried ahead under candidate modes, with the accelerations that these give, and every
function on its surface must go to the side that its mode claims: up for 1, not up for 0. The sign
is taken at the smallest look-ahead at which the change stands out of rounding, so that a rate which
is zero leaves the word to the acceleration. Where no side is consistent, or where friction sticks
or a contact closes, the function may be held at zero: its share must lie between its bounds, and
both fields must push onto the surface.
"""

import numpy as np

from runtime.core.array_views import integers_at, view
from runtime.core.function_table import (
    RIGID,
    SOUGHT,
    STICKS,
    impact_of,
    switching_of,
    switching_rates_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.rhs import field
from runtime.core.signatures import SETTLE, Integers, Vector
from runtime.core.workspace import (
    BAND,
    DELTA,
    LARGEST,
    NOW,
    PREFERRED,
    RATE_NOW,
    ROWS,
    STRUCK,
    TRIAL,
)
from runtime.hybrid.impact import ON_SURFACE
from runtime.hybrid.mode_consistency import CONSISTENT, GIVEN, MISSED, carry, hold
from runtime.hybrid.mode_search import MOST, MOST_THREE, exhaustively, in_turn
from runtime.hybrid.sliding_modes import HELD_MODE
from runtime.hybrid.switching_functions import margin

TOUCHING = 1e-9  # accuracy: of the machine's lengths; assembly closes a gap at the start no better
_TOLD = 1e-12  # accuracy: of the largest velocity; an approach at the start that is no impact


@addressed(SETTLE)
def settle(
    machine: Integers,
    first: int,
    t: float,
    d: float,
    state: int,
    slot: int,
    w: Vector,
    sw: Vector,
    p: Vector,
    modes: Integers,
    scratch: Integers,
    lam: Vector,
) -> int:
    """Give consistent modes to the functions on their surface, those with BAND > 0.

    Row PREFERRED has the modes that are tried first, then those with one change, two, and so on;
    among equals those in which `first` changes, and those that hold less. Many functions are first
    settled one after the other.

    Parameters
    ----------
    first
        The function that crossed.
    d
        Look-ahead, small against a step.
    slot
        Row of `sw` that may be overwritten.
    modes : (s,) int64
        In and out.
    scratch : (3 s,) int64 or more
        Workspace.

    Returns
    -------
    int
        `CONSISTENT`, or a function for which no mode is; `modes` is then unchanged.
    """
    n = w.size // (2 * ROWS)
    s = modes.size
    band = view(sw, BAND * s, s)
    members = view(scratch, s, s)
    q, v = view(w, state * 2 * n, n), view(w, state * 2 * n + n, n)
    switching_of(machine)(t, q, v, p, view(sw, NOW * s, s))
    count = 0
    for i in range(s):
        k = (first + i) % s
        if band[k] > 0.0:
            members[count] = k
            count += 1
    if count > MOST_THREE:
        blamed = in_turn(machine, t, d, state, w, sw, p, modes, lam, members, count, scratch)
        if blamed == CONSISTENT:
            return CONSISTENT
    return exhaustively(
        machine, t, d, state, w, sw, p, modes, lam, members, min(count, MOST), count, scratch
    )


@inner
def prefer(machine: Integers, letting_go: int, side: int, sw: Vector, modes: Integers) -> None:
    """Fill row PREFERRED: what friction that sticks and what is held already would rather do.

    `letting_go` is a function whose share has reached a bound, with the mode on that `side`. At the
    bound the acceleration of that mode is still that of the surface, so that looking ahead at a
    constant one would show nothing.
    """
    s = modes.size
    sticks = integers_at(machine, STICKS, s)
    for k in range(s):
        sw[PREFERRED * s + k] = HELD_MODE if sticks[k] != 0 else modes[k]
    if letting_go >= 0:
        sw[PREFERRED * s + letting_go] = side + GIVEN


@inner
def go_on(
    machine: Integers,
    crossing: int,
    t: float,
    q: Vector,
    v: Vector,
    w: Vector,
    sw: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> None:
    """Prefer to let slide, in row PREFERRED, what has left its surface at this very instant.

    To hold it would take a share that just misses its bounds, as when it was let go. It must not be
    caught by the event of another function: two that break loose together would hold each other up
    for ever. Rows BAND are those of the event before.
    """
    n = v.size
    s = modes.size
    sticks = integers_at(machine, STICKS, s)
    was = view(sw, TRIAL * s, s)
    asked = 0
    for k in range(s):
        was[k] = modes[k]
        if k == crossing:
            modes[k] = int(sw[PREFERRED * s + k]) % GIVEN
        elif sticks[k] != 0 and modes[k] != HELD_MODE and sw[BAND * s + k] > 0.0:
            modes[k] = HELD_MODE
            asked += 1
    if asked > 0:
        hold(machine, modes)
        field(machine, t, q, v, p, modes, view(w, DELTA * 2 * n + n, n), lam)
    for k in range(s):
        released = k != crossing and modes[k] == HELD_MODE and was[k] != HELD_MODE
        if released and margin(machine, t, q, v, p, lam, s, k) <= MISSED:
            sw[PREFERRED * s + k] = was[k] + GIVEN
    for k in range(s):
        modes[k] = int(was[k])
    hold(machine, modes)


@addressed(SETTLE)
def begin(
    machine: Integers,
    first: int,
    t: float,
    d: float,
    state: int,
    slot: int,
    w: Vector,
    sw: Vector,
    p: Vector,
    modes: Integers,
    scratch: Integers,
    lam: Vector,
) -> int:
    """Set all modes from the functions at the start, by look-ahead where one is zero.

    Arguments and result as in `settle`; row `slot` of `sw` is filled here.
    """
    n = w.size // (2 * ROWS)
    s = modes.size
    g = view(sw, slot * s, s)
    ahead = view(sw, TRIAL * s, s)
    largest = view(sw, LARGEST * s, s)
    band = view(sw, BAND * s, s)
    rigid = integers_at(machine, RIGID, s)
    q = view(w, state * 2 * n, n)
    v = view(w, state * 2 * n + n, n)
    switching_of(machine)(t, q, v, p, g)
    for k in range(s):
        modes[k] = 1 if g[k] > 0.0 or rigid[k] >= 0 else 0
    hold(machine, modes)
    sought = integers_at(machine, SOUGHT, s)
    for k in range(s):
        if sought[k] >= 0 and abs(g[k]) <= ON_SURFACE * largest[k]:
            p[sought[k]] = 0.0
            modes[k] = HELD_MODE  # without friction: one that sticks may jam in sliding
    field(machine, t, q, v, p, modes, view(w, DELTA * 2 * n + n, n), lam)
    carry(machine, t, d, state, w, sw, p)
    for k in range(s):
        modes[k] = 0 if modes[k] == HELD_MODE else modes[k]
    rates = view(sw, RATE_NOW * s, s)
    switching_rates_of(machine)(t, q, v, view(w, DELTA * 2 * n + n, n), p, rates)
    speed = 0.0
    for j in range(n):
        speed = max(speed, abs(v[j]))
    for k in range(s):
        # What is crossed within a millionth of the look-ahead is crossed now.
        near = ON_SURFACE * largest[k]
        if np.isfinite(ahead[k]):
            near = max(near, 1e-6 * abs(ahead[k] - g[k]))
        if rigid[k] >= 0:
            # An open gap that closes or opens is followed, be it as narrow as assembling misses.
            near = ON_SURFACE * largest[k]
            if g[k] <= 0.0 or abs(rates[k]) <= _TOLD * speed:
                near = TOUCHING * largest[k]
        largest[k] = max(largest[k], abs(g[k]))
        band[k] = 0.0
        if abs(g[k]) <= near:
            band[k] = 2.0 * abs(g[k]) + 1e-14 * largest[k] + 1e-300
    for k in range(s):
        sw[STRUCK * s + k] = 0.0
        if rigid[k] >= 0 and band[k] > 0.0 and rates[k] < 0.0:
            # A velocity of the size of rounding is corrected and not worth a word.
            sw[STRUCK * s + k] = 1.0 if rates[k] < -_TOLD * speed else 0.0
            impact_of(machine)(machine, k, t, state, w, sw, p, modes, lam)
            switching_rates_of(machine)(t, q, v, view(w, DELTA * 2 * n + n, n), p, rates)
    hold(machine, modes)
    prefer(machine, -1, 0, sw, modes)
    return settle(machine, first, t, d, state, slot, w, sw, p, modes, scratch, lam)
