"""Which switching conditions hold just after an instant at which some are on their surface.

The state is carried ahead under candidate modes, with the accelerations that these give, and every
function on its surface must go to the side that its mode claims: up for 1, not up for 0. The sign
is taken at the smallest look-ahead at which the change stands out of rounding, so that a rate which
is zero leaves the word to the acceleration. Where no side is consistent, or where friction sticks
or a contact closes, the function may be held at zero: its share must lie between its bounds, and
both fields must push onto the surface.
"""

from runtime.compiled import compiled, inner
from runtime.integrate.field import field
from runtime.integrate.held import HELD_MODE
from runtime.integrate.impact import ON_SURFACE
from runtime.integrate.signatures import SETTLE, Integers, Vector
from runtime.integrate.slots import (
    BENDS,
    CONSTRAINT_COUNT,
    COORDINATES,
    HELD,
    HIGH,
    LIMITS,
    LOW,
    PLAIN,
    RIGID,
    RIGID_COUNT,
    SHARE,
    STABILIZED,
    STICKS,
    WORK,
    impact_of,
    limited_of,
    switching_of,
    switching_rates_of,
)
from runtime.integrate.views import floats_at, integers_at, view
from runtime.integrate.workspace import (
    BAND,
    DELTA,
    LARGEST,
    NOW,
    PREFERRED,
    RATE_NOW,
    ROWS,
    SAMPLE,
    SWITCH_ROWS,
    TRIAL,
)

CONSISTENT = -1
GIVEN = 4  # is added to a preferred mode that is known to be right, and needs no look-ahead
_SIGNIFICANT = 1e-14  # change of g over its maximum that is no rounding
TOUCHING = 1e-9  # of the machine's lengths: a gap at the start is assembled no closer
_FIRST = 1e-7  # first look-ahead over the last
_MOST = 10  # functions whose modes are tried in all combinations
_MOST_THREE = 6  # of those that may also be held
_SHARE = 1e-9  # by which a share may miss its bounds at an event


@inner
def carry(
    machine: Integers, t: float, d: float, state: int, w: Vector, sw: Vector, p: Vector
) -> None:
    """Write into row TRIAL of `sw` the functions after a time `d` at constant acceleration.

    The acceleration is the second half of row DELTA.
    """
    n = w.size // (2 * ROWS)
    s = sw.size // SWITCH_ROWS
    y = view(w, state * 2 * n, 2 * n)
    a = view(w, DELTA * 2 * n + n, n)
    z = view(w, SAMPLE * 2 * n, 2 * n)
    for j in range(n):
        z[j] = y[j] + d * (y[n + j] + 0.5 * d * a[j])
        z[n + j] = y[n + j] + d * a[j]
    q, v = view(w, SAMPLE * 2 * n, n), view(w, SAMPLE * 2 * n + n, n)
    switching_of(machine)(t + d, q, v, p, view(sw, TRIAL * s, s))


@inner
def hold(machine: Integers, modes: Integers) -> None:
    """Make the field that of `modes`: count what is held."""
    count = 0
    for k in range(modes.size):
        count += 1 if modes[k] == HELD_MODE else 0
    machine[HELD] = count
    machine[BENDS] = count + machine[STABILIZED]


@inner
def loose(machine: Integers, t: float, q: Vector, v: Vector, p: Vector, lam: Vector, s: int) -> int:
    """First function that is said to be held and that nothing holds, else `CONSISTENT`.

    To be called after the field was evaluated.
    """
    n, m = machine[COORDINATES], machine[CONSTRAINT_COUNT]
    size = n + m
    work = floats_at(machine, WORK, (s + 2) * size + 2 * s * s + 4 * s + machine[RIGID_COUNT])
    matrix = view(work, (s + 1) * size, s * s)
    share = floats_at(machine, SHARE, s)
    low, high = floats_at(machine, LOW, s), floats_at(machine, HIGH, s)
    count = machine[HELD]
    held = view(integers_at(machine, PLAIN, 2 * s), s, s)
    for c in range(count):
        k = int(held[c])
        inside = low[k] - _SHARE <= share[k] <= high[k] + _SHARE
        if integers_at(machine, LIMITS, 2 * s)[2 * k] >= 0:
            inside = limited_of(machine)(machine, t, q, v, p, lam, k) >= -_SHARE
        if not inside or not matrix[c * count + c] < 0.0:
            return k
    return CONSISTENT


@inner
def contradicted(
    machine: Integers,
    t: float,
    d: float,
    state: int,
    w: Vector,
    sw: Vector,
    p: Vector,
    candidate: Integers,
    lam: Vector,
    members: Integers,
    count: int,
    signs: Integers,
) -> int:
    """First of the `count` members that does not go to the side that its candidate mode claims.

    Returns `CONSISTENT` where all do. `signs` receives where each goes: -1, 0 or 1.
    """
    n = w.size // (2 * ROWS)
    s = sw.size // SWITCH_ROWS
    g = view(sw, NOW * s, s)
    ahead = view(sw, TRIAL * s, s)
    largest = view(sw, LARGEST * s, s)
    preferred = view(sw, PREFERRED * s, s)
    q = view(w, state * 2 * n, n)
    v = view(w, state * 2 * n + n, n)
    hold(machine, candidate)
    field(machine, t, q, v, p, candidate, view(w, DELTA * 2 * n + n, n), lam)
    if machine[HELD] != 0:
        k = loose(machine, t, q, v, p, lam, s)
        if k != CONSISTENT:
            return k
    open_members = 0
    for i in range(count):
        signs[i] = 0
        open_members += 1 if candidate[members[i]] != HELD_MODE else 0
    distance = d * _FIRST
    while open_members > 0 and distance <= 1.5 * d:
        carry(machine, t, distance, state, w, sw, p)
        for i in range(count):
            k = members[i]
            change = ahead[k] - g[k]
            significant = abs(change) > _SIGNIFICANT * max(largest[k], abs(g[k]))
            if signs[i] == 0 and significant and candidate[k] != HELD_MODE:
                signs[i] = 1 if change > 0.0 else -1
                open_members -= 1
        distance *= 10.0
    for i in range(count):
        k = int(members[i])
        given = int(preferred[k]) == candidate[k] + GIVEN
        if candidate[k] != HELD_MODE and not given and (signs[i] > 0) != (candidate[k] != 0):
            return k
    return CONSISTENT


@inner
def alternative(rigid: int, preferred: int, choice: int) -> int:
    """The mode that stands for `choice`, 0 being the preferred one; -1 where there is none.

    A rigid contact is open (1) or held; others are 0, 1 or held, and are held last.
    """
    if choice == 0:
        return preferred
    if rigid >= 0:
        return (HELD_MODE if preferred == 1 else 1) if choice == 1 else -1
    if preferred == HELD_MODE:
        return choice - 1
    return 1 - preferred if choice == 1 else HELD_MODE


@compiled(SETTLE)
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
    among equals those in which `first` changes, and those that hold less.

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
    preferred = view(sw, PREFERRED * s, s)
    candidate = view(scratch, 0, s)
    members = view(scratch, s, s)
    signs = view(scratch, 2 * s, s)
    rigid = integers_at(machine, RIGID, s)
    q, v = view(w, state * 2 * n, n), view(w, state * 2 * n + n, n)
    switching_of(machine)(t, q, v, p, view(sw, NOW * s, s))
    count = 0
    for i in range(s):
        k = (first + i) % s
        if band[k] > 0.0:
            members[count] = k
            count += 1
    tried = min(count, _MOST)
    choices = 3 if tried <= _MOST_THREE else 2
    combinations = 1
    for _ in range(tried):
        combinations *= choices
    blamed = CONSISTENT
    for changes in range(tried + 1):
        for holds in range(changes + 1):
            for number in range(combinations):
                changed, late, rest, known = 0, 0, number, True
                for k in range(s):
                    candidate[k] = modes[k]
                for i in range(tried):
                    choice = rest % choices
                    rest //= choices
                    changed += 1 if choice > 0 else 0
                    late += 1 if choice == 2 else 0
                    k = members[i]
                    mode = alternative(rigid[k], int(preferred[k]) % GIVEN, choice)
                    known = known and mode >= 0
                    candidate[k] = mode
                if changed != changes or late != holds or not known:
                    continue
                wrong = contradicted(
                    machine, t, d, state, w, sw, p, candidate, lam, members, count, signs
                )
                if wrong == CONSISTENT:
                    for k in range(s):
                        modes[k] = candidate[k]
                    hold(machine, modes)
                    return CONSISTENT
                if blamed == CONSISTENT:
                    blamed = wrong
    hold(machine, modes)
    return blamed


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


@compiled(SETTLE)
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
    field(machine, t, q, v, p, modes, view(w, DELTA * 2 * n + n, n), lam)
    carry(machine, t, d, state, w, sw, p)
    for k in range(s):
        # What is crossed within a millionth of the look-ahead is crossed now.
        near = max(ON_SURFACE * largest[k], 1e-6 * abs(ahead[k] - g[k]))
        if rigid[k] >= 0:
            near = max(near, TOUCHING * largest[k])
        largest[k] = max(largest[k], abs(g[k]))
        band[k] = 0.0
        if abs(g[k]) <= near:
            band[k] = 2.0 * abs(g[k]) + 1e-14 * largest[k] + 1e-300
    rates = view(sw, RATE_NOW * s, s)
    switching_rates_of(machine)(t, q, v, view(w, DELTA * 2 * n + n, n), p, rates)
    for k in range(s):
        if rigid[k] >= 0 and band[k] > 0.0 and rates[k] < 0.0:
            impact_of(machine)(machine, k, t, state, w, sw, p, modes, lam)
            switching_rates_of(machine)(t, q, v, view(w, DELTA * 2 * n + n, n), p, rates)
    hold(machine, modes)
    prefer(machine, -1, 0, sw, modes)
    return settle(machine, first, t, d, state, slot, w, sw, p, modes, scratch, lam)
