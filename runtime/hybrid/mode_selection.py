"""Mode selection: consistent modes just after an instant with functions on their surface.

The state is extrapolated with the accelerations of candidate modes, and every function on its
surface must go to the side that its mode claims: up for 1, not up for 0. The sign is taken at the
smallest look-ahead at which the change exceeds rounding, so that at a zero rate the acceleration
decides. Where no side is consistent, or where friction sticks or a contact closes, the mode may be
SLIDING: the share must lie between its bounds, and both vector fields push onto the surface.
"""

import numpy as np

from runtime.core import function_table as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace as ws
from runtime.core.array_types import Integers, Vector
from runtime.core.jit import addressed, inner
from runtime.core.modes import SLIDING
from runtime.core.rhs import evaluate_accelerations
from runtime.hybrid.impact import ON_SURFACE
from runtime.hybrid.mode_consistency import (
    CONSISTENT,
    MISSED,
    count_sliding,
    look_ahead,
    mark_known,
    preferred_mode,
)
from runtime.hybrid.mode_search import (
    MOST_COMBINED,
    MOST_WITH_SLIDING,
    search_all,
    search_by_pivots,
)
from runtime.hybrid.switching_functions import compute_margin

TOUCHING = 1e-9  # accuracy: of the machine's lengths; how closely assembly closes a gap
_RESTING = 1e-12  # accuracy: of the largest velocity; slower approaches at the start are no impact


@addressed(ft.SELECT_MODES)
def select_modes(context: Integers, first: int, t: float, d: float, state: int, slot: int) -> int:
    """Give consistent modes to the functions on their surface, those with BAND > 0.

    The modes of row PREFERRED are tried first, then those with one change, two, and so on; among
    equals those in which `first` changes, and those with fewer functions in sliding mode. Where
    many functions are on their surface, search by pivots comes first.

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
    p, s = ft.parameters_of(context), context[ft.SWITCHES]
    band, members = ws.switch_row(context, ws.BAND), ft.members_of(context)
    q, v = ws.positions(context, state), ws.velocities(context, state)
    abi.switching_of(context)(t, q, v, p, ws.switch_row(context, ws.NOW))
    count = 0
    for i in range(s):
        k = (first + i) % s
        if band[k] > 0.0:
            members[count] = k
            count += 1
    if count > MOST_WITH_SLIDING:
        blamed = search_by_pivots(context, t, d, state, count)
        if blamed == CONSISTENT:
            return CONSISTENT
    return search_all(context, t, d, state, min(count, MOST_COMBINED), count)


@inner
def set_preferences(context: Integers, letting_go: int, side: int) -> None:
    """Fill row PREFERRED: friction prefers to stick, all others keep their modes.

    `letting_go` is a function whose share has reached a bound; its next mode is `side`. At the
    bound the acceleration of that mode equals that of sliding, so that a look-ahead at constant
    acceleration would show no change.
    """
    modes, preferred = ft.modes_of(context), ws.switch_row(context, ws.PREFERRED)
    s, sticks = context[ft.SWITCHES], ft.sticks_of(context)
    for k in range(s):
        preferred[k] = SLIDING if sticks[k] != 0 else modes[k]
    if letting_go >= 0:
        preferred[letting_go] = mark_known(side)


@inner
def prefer_released(context: Integers, crossing: int, t: float, q: Vector, v: Vector) -> None:
    """Let friction that broke loose at this very instant go on, in row PREFERRED.

    Its share would miss its bounds by rounding alone. The event of another function must not make
    it stick again: two frictions that break loose together would stop each other for ever. Row BAND
    is that of the event before.
    """
    modes, preferred = ft.modes_of(context), ws.switch_row(context, ws.PREFERRED)
    band, s = ws.switch_row(context, ws.BAND), context[ft.SWITCHES]
    sticks, former = ft.sticks_of(context), ws.switch_row(context, ws.TRIAL)
    tested = 0
    for k in range(s):
        former[k] = modes[k]
        if k == crossing:
            modes[k] = preferred_mode(preferred[k])
        elif sticks[k] != 0 and modes[k] != SLIDING and band[k] > 0.0:
            modes[k] = SLIDING
            tested += 1
    if tested > 0:
        count_sliding(context, modes)
        evaluate_accelerations(context, t, q, v, modes, ws.second_half(context, ws.DELTA))
    for k in range(s):
        released = k != crossing and modes[k] == SLIDING and former[k] != SLIDING
        if released and compute_margin(context, t, q, v, k) <= MISSED:
            preferred[k] = mark_known(former[k])
    for k in range(s):
        modes[k] = int(former[k])
    count_sliding(context, modes)


@addressed(ft.SELECT_MODES)
def initialize_modes(
    context: Integers, first: int, t: float, d: float, state: int, slot: int
) -> int:
    """Set all modes from the functions at the start, by look-ahead where one is zero.

    Arguments and result as of `select_modes`; row `slot` of `sw` is filled here.
    """
    p, modes = ft.parameters_of(context), ft.modes_of(context)
    struck, n = ws.switch_row(context, ws.STRUCK), context[ft.COORDINATES]
    s, g = context[ft.SWITCHES], ws.switch_row(context, slot)
    ahead, largest = ws.switch_row(context, ws.TRIAL), ws.switch_row(context, ws.LARGEST)
    band, rigid = ws.switch_row(context, ws.BAND), ft.rigid_of(context)
    q, v = ws.positions(context, state), ws.velocities(context, state)
    abi.switching_of(context)(t, q, v, p, g)
    for k in range(s):
        modes[k] = 1 if g[k] > 0.0 or rigid[k] >= 0 else 0
    count_sliding(context, modes)
    places = ft.stiction_place_of(context)
    for k in range(s):
        if places[k] >= 0 and abs(g[k]) <= ON_SURFACE * largest[k]:
            p[places[k]] = 0.0
            modes[k] = SLIDING  # friction that sticks may jam in sliding
    evaluate_accelerations(context, t, q, v, modes, ws.second_half(context, ws.DELTA))
    look_ahead(context, t, d, state)
    for k in range(s):
        modes[k] = 0 if modes[k] == SLIDING else modes[k]
    rates = ws.switch_row(context, ws.RATE_NOW)
    abi.switching_rates_of(context)(t, q, v, ws.second_half(context, ws.DELTA), p, rates)
    speed = 0.0
    for j in range(n):
        speed = max(speed, abs(v[j]))
    for k in range(s):
        # A crossing within a millionth of the look-ahead is one now.
        near = ON_SURFACE * largest[k]
        if np.isfinite(ahead[k]):
            near = max(near, 1e-6 * abs(ahead[k] - g[k]))
        if rigid[k] >= 0:
            # An open gap that closes or opens is followed, narrow as the error of assembly.
            near = ON_SURFACE * largest[k]
            if g[k] <= 0.0 or abs(rates[k]) <= _RESTING * speed:
                near = TOUCHING * largest[k]
        largest[k] = max(largest[k], abs(g[k]))
        band[k] = 0.0
        if abs(g[k]) <= near:
            band[k] = 2.0 * abs(g[k]) + 1e-14 * largest[k] + 1e-300
    for k in range(s):
        struck[k] = 0.0
        if rigid[k] >= 0 and band[k] > 0.0 and rates[k] < 0.0:
            # A velocity of the size of rounding is corrected without an event.
            struck[k] = 1.0 if rates[k] < -_RESTING * speed else 0.0
            ft.impact_of(context)(context, k, t, state)
            abi.switching_rates_of(context)(t, q, v, ws.second_half(context, ws.DELTA), p, rates)
    count_sliding(context, modes)
    set_preferences(context, -1, 0)
    return select_modes(context, first, t, d, state, slot)
