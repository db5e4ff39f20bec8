"""Which switching conditions hold just after an instant at which some are on their surface.

The state is carried ahead under candidate modes, with the accelerations that these give, and every
function on its surface must go to the side that its mode claims: up for 1, not up for 0. The sign
is taken at the smallest look-ahead at which the change stands out of rounding, so that a rate which
is zero leaves the word to the acceleration. Where no side is consistent, or where friction sticks
or a contact closes, the function may be held at zero: its share must lie between its bounds, and
both fields must push onto the surface.
"""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.function_table import (
    COORDINATES,
    SETTLE,
    SWITCHES,
    impact_of,
    members_of,
    modes_of,
    parameters_of,
    rigid_of,
    sticks_of,
    stiction_place_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import switching_of, switching_rates_of
from runtime.core.rhs import field
from runtime.core.workspace import (
    BAND,
    DELTA,
    LARGEST,
    NOW,
    PREFERRED,
    RATE_NOW,
    STRUCK,
    TRIAL,
    positions,
    second_half,
    switch_row,
    velocities,
)
from runtime.hybrid.impact import ON_SURFACE
from runtime.hybrid.mode_consistency import CONSISTENT, GIVEN, MISSED, carry, hold
from runtime.hybrid.mode_search import MOST, MOST_THREE, exhaustively, in_turn
from runtime.hybrid.sliding_modes import HELD_MODE
from runtime.hybrid.switching_functions import margin

TOUCHING = 1e-9  # accuracy: of the machine's lengths; assembly closes a gap at the start no better
_TOLD = 1e-12  # accuracy: of the largest velocity; an approach at the start that is no impact


@addressed(SETTLE)
def settle(context: Integers, first: int, t: float, d: float, state: int, slot: int) -> int:
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

    Returns
    -------
    int
        `CONSISTENT`, or a function for which no mode is; `modes` is then unchanged.
    """
    p = parameters_of(context)
    s = context[SWITCHES]
    band = switch_row(context, BAND)
    members = members_of(context)
    q, v = positions(context, state), velocities(context, state)
    switching_of(context)(t, q, v, p, switch_row(context, NOW))
    count = 0
    for i in range(s):
        k = (first + i) % s
        if band[k] > 0.0:
            members[count] = k
            count += 1
    if count > MOST_THREE:
        blamed = in_turn(context, t, d, state, count)
        if blamed == CONSISTENT:
            return CONSISTENT
    return exhaustively(context, t, d, state, min(count, MOST), count)


@inner
def prefer(context: Integers, letting_go: int, side: int) -> None:
    """Fill row PREFERRED: what friction that sticks and what is held already would rather do.

    `letting_go` is a function whose share has reached a bound, with the mode on that `side`. At the
    bound the acceleration of that mode is still that of the surface, so that looking ahead at a
    constant one would show nothing.
    """
    modes = modes_of(context)
    preferred = switch_row(context, PREFERRED)
    s = context[SWITCHES]
    sticks = sticks_of(context)
    for k in range(s):
        preferred[k] = HELD_MODE if sticks[k] != 0 else modes[k]
    if letting_go >= 0:
        preferred[letting_go] = side + GIVEN


@inner
def go_on(context: Integers, crossing: int, t: float, q: Vector, v: Vector) -> None:
    """Prefer to let slide, in row PREFERRED, what has left its surface at this very instant.

    To hold it would take a share that just misses its bounds, as when it was let go. It must not be
    caught by the event of another function: two that break loose together would hold each other up
    for ever. Rows BAND are those of the event before.
    """
    modes = modes_of(context)
    preferred = switch_row(context, PREFERRED)
    band = switch_row(context, BAND)
    s = context[SWITCHES]
    sticks = sticks_of(context)
    was = switch_row(context, TRIAL)
    asked = 0
    for k in range(s):
        was[k] = modes[k]
        if k == crossing:
            modes[k] = int(preferred[k]) % GIVEN
        elif sticks[k] != 0 and modes[k] != HELD_MODE and band[k] > 0.0:
            modes[k] = HELD_MODE
            asked += 1
    if asked > 0:
        hold(context, modes)
        field(context, t, q, v, modes, second_half(context, DELTA))
    for k in range(s):
        released = k != crossing and modes[k] == HELD_MODE and was[k] != HELD_MODE
        if released and margin(context, t, q, v, s, k) <= MISSED:
            preferred[k] = was[k] + GIVEN
    for k in range(s):
        modes[k] = int(was[k])
    hold(context, modes)


@addressed(SETTLE)
def begin(context: Integers, first: int, t: float, d: float, state: int, slot: int) -> int:
    """Set all modes from the functions at the start, by look-ahead where one is zero.

    Arguments and result as in `settle`; row `slot` of `sw` is filled here.
    """
    p = parameters_of(context)
    modes = modes_of(context)
    struck = switch_row(context, STRUCK)
    n = context[COORDINATES]
    s = context[SWITCHES]
    g = switch_row(context, slot)
    ahead = switch_row(context, TRIAL)
    largest = switch_row(context, LARGEST)
    band = switch_row(context, BAND)
    rigid = rigid_of(context)
    q = positions(context, state)
    v = velocities(context, state)
    switching_of(context)(t, q, v, p, g)
    for k in range(s):
        modes[k] = 1 if g[k] > 0.0 or rigid[k] >= 0 else 0
    hold(context, modes)
    sought = stiction_place_of(context)
    for k in range(s):
        if sought[k] >= 0 and abs(g[k]) <= ON_SURFACE * largest[k]:
            p[sought[k]] = 0.0
            modes[k] = HELD_MODE  # without friction: one that sticks may jam in sliding
    field(context, t, q, v, modes, second_half(context, DELTA))
    carry(context, t, d, state)
    for k in range(s):
        modes[k] = 0 if modes[k] == HELD_MODE else modes[k]
    rates = switch_row(context, RATE_NOW)
    switching_rates_of(context)(t, q, v, second_half(context, DELTA), p, rates)
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
        struck[k] = 0.0
        if rigid[k] >= 0 and band[k] > 0.0 and rates[k] < 0.0:
            # A velocity of the size of rounding is corrected and not worth a word.
            struck[k] = 1.0 if rates[k] < -_TOLD * speed else 0.0
            impact_of(context)(context, k, t, state)
            switching_rates_of(context)(t, q, v, second_half(context, DELTA), p, rates)
    hold(context, modes)
    prefer(context, -1, 0)
    return settle(context, first, t, d, state, slot)
