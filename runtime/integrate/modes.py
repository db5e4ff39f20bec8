"""Which switching conditions hold just after an instant at which some are on their surface.

The state is carried ahead under candidate modes, with the accelerations that these give, and every
function on its surface must go to the side that its mode claims: up for 1, not up for 0. The sign
is taken at the smallest look-ahead at which the change stands out of rounding, so that a rate which
is zero leaves the word to the acceleration.
"""

from runtime.compiled import compiled, inner
from runtime.integrate.field import field
from runtime.integrate.signatures import SETTLE, Integers, Vector
from runtime.integrate.slots import switching_of
from runtime.integrate.views import view
from runtime.integrate.workspace import (
    BAND,
    DELTA,
    LARGEST,
    ROWS,
    SAMPLE,
    SWITCH_ROWS,
    TRIAL,
)

ON_SURFACE = 1e-13  # |g| over its running maximum below which g counts as zero at an event
CONSISTENT = -1
_SIGNIFICANT = 1e-14  # change of g over its maximum that is no rounding
_FIRST = 1e-7  # first look-ahead over the last
_MOST = 10  # functions whose modes are tried in all combinations


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
def contradicted(
    machine: Integers,
    t: float,
    d: float,
    state: int,
    slot: int,
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
    g = view(sw, slot * s, s)
    ahead = view(sw, TRIAL * s, s)
    largest = view(sw, LARGEST * s, s)
    q = view(w, state * 2 * n, n)
    v = view(w, state * 2 * n + n, n)
    field(machine, t, q, v, p, candidate, view(w, DELTA * 2 * n + n, n), lam)
    for i in range(count):
        signs[i] = 0
    distance = d * _FIRST
    open_members = count
    while open_members > 0 and distance <= 1.5 * d:
        carry(machine, t, distance, state, w, sw, p)
        for i in range(count):
            k = members[i]
            change = ahead[k] - g[k]
            if signs[i] == 0 and abs(change) > _SIGNIFICANT * max(largest[k], abs(g[k])):
                signs[i] = 1 if change > 0.0 else -1
                open_members -= 1
        distance *= 10.0
    for i in range(count):
        k = int(members[i])
        if (signs[i] > 0) != (candidate[k] != 0):
            return k
    return CONSISTENT


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

    The modes that hold are tried first, then those with one change, two, and so on; among equals
    those in which `first` changes.

    Parameters
    ----------
    first
        The function that crossed.
    d
        Look-ahead, small against a step.
    slot
        Row of `sw` with g now.
    modes : (s,) int64
        In and out.
    scratch : (3 s,) int64 or more
        Workspace.

    Returns
    -------
    int
        `CONSISTENT`, or a function onto whose surface both sides push; `modes` is then unchanged.
    """
    s = modes.size
    band = view(sw, BAND * s, s)
    candidate = view(scratch, 0, s)
    members = view(scratch, s, s)
    signs = view(scratch, 2 * s, s)
    count = 0
    for i in range(s):
        k = (first + i) % s
        if band[k] > 0.0:
            members[count] = k
            count += 1
    tried = min(count, _MOST)
    blamed = CONSISTENT
    for changes in range(tried + 1):
        for mask in range(1 << tried):
            ones = 0
            for bit in range(tried):
                ones += (mask >> bit) & 1
            if ones != changes:
                continue
            for k in range(s):
                candidate[k] = modes[k]
            for bit in range(tried):
                if (mask >> bit) & 1:
                    candidate[members[bit]] = 1 - candidate[members[bit]]
            wrong = contradicted(
                machine,
                t,
                d,
                state,
                slot,
                w,
                sw,
                p,
                candidate,
                lam,
                members,
                count,
                signs,
            )
            if wrong == CONSISTENT:
                for k in range(s):
                    modes[k] = candidate[k]
                return CONSISTENT
            if blamed == CONSISTENT:
                blamed = wrong
    return blamed


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
    q = view(w, state * 2 * n, n)
    v = view(w, state * 2 * n + n, n)
    switching_of(machine)(t, q, v, p, g)
    for k in range(s):
        modes[k] = 1 if g[k] > 0.0 else 0
    field(machine, t, q, v, p, modes, view(w, DELTA * 2 * n + n, n), lam)
    carry(machine, t, d, state, w, sw, p)
    for k in range(s):
        # What is crossed within a millionth of the look-ahead is crossed now.
        near = max(ON_SURFACE * largest[k], 1e-6 * abs(ahead[k] - g[k]))
        largest[k] = max(largest[k], abs(g[k]))
        band[k] = 0.0
        if abs(g[k]) <= near:
            band[k] = 2.0 * abs(g[k]) + 1e-14 * largest[k] + 1e-300
    return settle(machine, first, t, d, state, slot, w, sw, p, modes, scratch, lam)
