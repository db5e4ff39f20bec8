"""Mode selection: consistent modes just after an instant with functions on their surface.

The state is extrapolated with the accelerations of candidate modes, and every function on its
surface must go to the side that its mode claims: up for 1, not up for 0. The sign is taken at the
smallest look-ahead at which the change exceeds rounding, so that at a zero rate the acceleration
decides. Where no side is consistent, or where friction sticks or a contact closes, the mode may be
SLIDING: the share must lie between its bounds, and both vector fields push onto the surface.

Candidate modes of several functions on their surfaces are tried by pivots, or all of them. A force
that is zero on its surface, as k g + c ġ where a gap closes without speed, is the same in both
modes but for rounding, and so is the motion that follows. No look ahead tells its modes apart, and
where several such functions act on one body, each contradicts the others by rounding: such modes
make no difference, and are dropped.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context
from runtime.core.jit import addressed, inlined, inner
from runtime.core.kinds import BALANCED, KNOTS, MIXED, ONE_WAY, SLIDING
from runtime.core.state_derivative import evaluate_accelerations
from runtime.hybrid import mode_consistency as consistency
from runtime.hybrid.impact import ON_SURFACE
from runtime.hybrid.rest_forces import is_unilateral, rests
from runtime.hybrid.sliding_motion import compute_margin
from runtime.linalg.vectors import copy_vector, largest_magnitude

MOST_COMBINED = 10  # safety: functions of which all combinations of modes are tried
MOST_WITH_SLIDING = 6  # safety: the same where all may slide; more are first searched by pivots

_SAME = 1e-9  # accuracy: of the largest acceleration; a smaller effect of a mode is none

TOUCHING = 1e-9  # accuracy: of the machine's lengths; how closely assembly closes a gap
_RESTING = 1e-12  # accuracy: of the largest velocity; slower approaches at the start are no impact


@inner
def choose_mode(unilateral: bool, preferred: int, choice: int) -> int:
    """The mode that stands for `choice`, 0 being the preferred one; -1 where there is none.

    A contact is open (1) or closed, a freewheel overruns or grips; others are 0, 1 or sliding, and
    sliding comes last.
    """
    if choice == 0:
        return preferred
    if unilateral:
        return (SLIDING if preferred == 1 else 1) if choice == 1 else -1
    if preferred == SLIDING:
        return choice - 1
    return 1 - preferred if choice == 1 else SLIDING


@inner
def flip_mode(context: Context, k: int, mode: int, preferred: int) -> int:
    """The next mode of function `k`, whose `mode` is contradicted.

    From sliding mode it goes to the side of the bound that its share exceeds; one that rests has no
    share, and goes where the look ahead saw it go.
    """
    if mode == SLIDING and rests(context, k):
        for i in range(context[ft.SWITCHES]):
            if context.members[i] == k:
                return 1 if context.signs[i] > 0 else 0
    if mode == SLIDING:
        if is_unilateral(context, k) or not np.isfinite(context.share[k]):
            return 1
        return consistency.nearest_mode(context, k)
    alternates = context.rigid[k] < 0 and context.sticks[k] == 0
    return 1 - mode if alternates and mode == preferred else SLIDING


@inner
def search_by_pivots(context: Context, t: float, d: float, state: int, count: int) -> int:
    """Modes by changing the first that is contradicted, again and again, as Murty's pivots do.

    (K. G. Murty, Note on a Bard-type scheme for solving the complementarity problem, Opsearch 11,
    1974.) Independent functions are settled one after the other. As friction or a repelling surface
    may make pivots cycle, their number is bounded: each function has three modes, and may return
    once for each of the others.
    """
    modes, candidate = context.modes, context.candidate_modes
    copy_vector(modes, candidate)
    for i in range(count):
        k = context.members[i]
        candidate[k] = consistency.preferred_mode(context.preferred[k])
    wrong = consistency.CONSISTENT
    for _ in range(3 * count * count):
        wrong = consistency.find_contradiction(context, t, d, state, candidate, count)
        if wrong == consistency.CONSISTENT:
            copy_vector(candidate, modes)
            break
        if not context.band[wrong] > 0.0:
            break
        preferred = consistency.preferred_mode(context.preferred[wrong])
        candidate[wrong] = flip_mode(context, wrong, int(candidate[wrong]), preferred)
    return wrong


@inner
def search_all(context: Context, t: float, d: float, state: int, tried: int, count: int) -> int:
    """Modes by trying all combinations of the first `tried` members; result as `select_modes`."""
    modes, candidate = context.modes, context.candidate_modes
    choices = 3 if tried <= MOST_WITH_SLIDING else 2
    combinations = choices**tried
    blamed = consistency.CONSISTENT
    for changes in range(tried + 1):
        for holds in range(changes + 1):
            for number in range(combinations):
                changed, late, rest, known = 0, 0, number, True
                copy_vector(modes, candidate)
                for i in range(tried):
                    choice = rest % choices
                    rest //= choices
                    changed += 1 if choice > 0 else 0
                    late += 1 if choice == 2 else 0
                    k = context.members[i]
                    entry = context.preferred[k]
                    preferred = consistency.preferred_mode(entry)
                    mode = choose_mode(is_unilateral(context, k), preferred, choice)
                    known = known and mode >= 0 and not (choice > 0 and consistency.is_fixed(entry))
                    candidate[k] = mode
                if changed != changes or late != holds or not known:
                    continue
                wrong = consistency.find_contradiction(context, t, d, state, candidate, count)
                if wrong == consistency.CONSISTENT:
                    copy_vector(candidate, modes)
                    return wrong
                if blamed == consistency.CONSISTENT:
                    blamed = wrong
    consistency.count_sliding(context, modes)
    return blamed


@inner
def is_plain(context: Context, k: int) -> bool:
    """Whether function `k` has two modes and no force of its own on its surface."""
    plain = context.rigid[k] < 0 and context.sticks[k] == 0 and context.modes[k] != SLIDING
    return bool(plain and context.boundary[k] < BALANCED)


@inner
def drop_indifferent(context: Context, t: float, state: int, first: int, count: int) -> int:
    """Take from the `count` members those whose modes make no difference; how many are left.

    They keep their modes, but for `first`, the function that crossed, which changes its own.
    """
    modes, members = context.modes, context.members
    before, after = context.first_scratch, context.second_scratch
    q, v = ws.positions(context, state), ws.velocities(context, state)
    consistency.count_sliding(context, modes)
    evaluate_accelerations(context, t, q, v, modes, before)
    least, left = _SAME * largest_magnitude(before), 0
    for i in range(count):
        k = members[i]
        same = is_plain(context, k)
        if same:
            modes[k] = 1 - modes[k]
            evaluate_accelerations(context, t, q, v, modes, after)
            for j in range(after.size):
                same = same and abs(after[j] - before[j]) <= least
            if not (same and k == first):
                modes[k] = 1 - modes[k]
        if not same:
            members[left] = k
            left += 1
    return left


@inlined
def surface_band(g: float, largest: float) -> float:
    """Width of the band about g = 0 of a function on its surface, whose maximum is `largest`."""
    return 2.0 * abs(g) + 1e-14 * largest + 1e-300


@addressed(ft.SELECT_MODES)
def select_modes(context: Context, first: int, t: float, d: float, state: int) -> int:
    """Give consistent modes to the functions on their surface, those with BAND > 0.

    The modes of row PREFERRED are tried first, then those with one change, two, and so on; among
    equals those in which `first`, the function that crossed, changes, and those with fewer
    functions in sliding mode. Where many functions are on their surface, search by pivots comes
    first. The look-ahead `d` is small against a step.

    Returns `CONSISTENT`, or a function for which no mode is; MODES is then unchanged.
    """
    s = context[ft.SWITCHES]
    q, v = ws.positions(context, state), ws.velocities(context, state)
    abi.switching_of(context)(t, q, v, context.parameters, context.now)
    count = 0
    for i in range(s):
        k = (first + i) % s
        if context.band[k] > 0.0:
            context.members[count] = k
            count += 1
    blamed = count
    if count > MOST_WITH_SLIDING:
        blamed = search_by_pivots(context, t, d, state, count)
        if blamed != consistency.CONSISTENT:
            kept, left = context.modes[first], drop_indifferent(context, t, state, first, count)
            if left < count:
                blamed = search_by_pivots(context, t, d, state, left)
                count = left
            if blamed != consistency.CONSISTENT:
                context.modes[first] = kept
    if blamed != consistency.CONSISTENT:
        tried = min(count, MOST_COMBINED)
        blamed = search_all(context, t, d, state, tried, count)
    for i in range(count):
        k = context.members[i]
        held = context.rigid[k] >= 0 or context.sticks[k] != 0
        if context[ft.CONSTRAINT_COUNT] > 0 and context.signs[i] == 0 and not held:
            # What the joints keep at zero is zero as closely as these are closed.
            context.band[k] = max(context.band[k], consistency.RESTS * context.largest[k])
    return blamed


@inner
def set_preferences(context: Context) -> None:
    """Fill row PREFERRED: friction prefers to stick, all others keep their modes.

    Both sides of a table's knot have one force, and no look ahead tells them apart.
    """
    for k in range(context[ft.SWITCHES]):
        context.preferred[k] = SLIDING if context.sticks[k] != 0 else context.modes[k]
        if context.table_part[k] == KNOTS:
            context.preferred[k] = consistency.decided_entry(int(context.modes[k]))


@inner
def prefer_released(context: Context, crossing: int, t: float) -> None:
    """Let friction that broke loose at this very instant go on, in row PREFERRED.

    Its share would miss its bounds by rounding alone. The event of another function must not make
    it stick again: two frictions that break loose together would stop each other for ever. Row BAND
    is that of the event before.
    """
    q, v, modes, former = context.q1, context.v1, context.modes, context.trial
    s, tested = context[ft.SWITCHES], 0
    copy_vector(modes, former)
    modes[crossing] = consistency.preferred_mode(context.preferred[crossing])
    for k in range(s):
        slips = context.sticks[k] != 0 and modes[k] != SLIDING
        if k != crossing and slips and context.band[k] > 0.0:
            modes[k] = SLIDING
            tested += 1
    if tested > 0:
        consistency.count_sliding(context, modes)
        evaluate_accelerations(context, t, q, v, modes, context.second_scratch)
    for k in range(s):
        released = k != crossing and modes[k] == SLIDING and former[k] != SLIDING
        if released and compute_margin(context, t, q, v, k) <= consistency.MISSED:
            context.preferred[k] = consistency.decided_entry(former[k])
    for k in range(s):
        modes[k] = int(former[k])
    consistency.count_sliding(context, modes)


@addressed(ft.SELECT_MODES)
def initialize_modes(context: Context, first: int, t: float, d: float, state: int) -> int:
    """Set all modes from the functions at the start, by look-ahead where one is zero.

    Arguments and result as of `select_modes`; row G0 is filled here.
    """
    p, modes, g, rates = context.parameters, context.modes, context.g0, context.rate_now
    largest, rigid, a, s = (
        context.largest,
        context.rigid,
        context.second_scratch,
        context[ft.SWITCHES],
    )
    q, v = ws.positions(context, state), ws.velocities(context, state)
    abi.switching_of(context)(t, q, v, p, g)
    for k in range(s):
        modes[k] = 1 if g[k] > 0.0 or is_unilateral(context, k) else 0
    consistency.count_sliding(context, modes)
    for k in range(s):
        if context.stiction_place[k] >= 0 and abs(g[k]) <= ON_SURFACE * largest[k]:
            p[context.stiction_place[k]] = 0.0
            modes[k] = SLIDING  # friction that sticks may jam in sliding
    evaluate_accelerations(context, t, q, v, modes, a)
    consistency.look_ahead(context, t, d, state)
    abi.switching_rates_of(context)(t, q, v, a, p, rates)
    resting = _RESTING * largest_magnitude(v)
    for k in range(s):
        modes[k] = 0 if modes[k] == SLIDING else modes[k]
        # A crossing within a millionth of the look-ahead is one now.
        near = ON_SURFACE * largest[k]
        if rigid[k] < 0 and np.isfinite(context.trial[k]):
            near = max(near, 1e-6 * abs(context.trial[k] - g[k]))
        elif rigid[k] >= 0 and (g[k] <= 0.0 or abs(rates[k]) <= resting):
            # An open gap that closes or opens is followed, narrow as the error of assembly.
            near = TOUCHING * largest[k]
        largest[k] = max(largest[k], abs(g[k]))
        context.band[k] = surface_band(g[k], largest[k]) if abs(g[k]) <= near else 0.0
    struck = False
    for k in range(s):
        context.struck[k] = 0.0
        if rigid[k] >= 0 and context.band[k] > 0.0 and rates[k] < 0.0:
            # A velocity of the size of rounding is corrected without an event.
            context.struck[k] = 1.0 if rates[k] < -resting else 0.0
            ft.impact_of(context)(context, k, t, state)
            abi.switching_rates_of(context)(t, q, v, a, p, rates)
            struck = struck or context.struck[k] > 0.0
        elif context.sticks[k] == ONE_WAY:
            abi.switching_of(context)(t, q, v, p, g)
            if g[k] < -context.band[k]:
                ft.impact_of(context)(context, k, t, state)
                abi.switching_rates_of(context)(t, q, v, a, p, rates)
                struck = True
                abi.switching_of(context)(t, q, v, p, g)
                if g[k] < -TOUCHING * largest_magnitude(v):
                    return k  # drivers force it against its way
    if struck:
        abi.switching_of(context)(t, q, v, p, g)
        for k in range(s):
            if context.sticks[k] == ONE_WAY:
                grips = g[k] <= max(_RESTING * largest_magnitude(v), ON_SURFACE * largest[k])
                context.band[k] = surface_band(g[k], largest[k]) if grips else 0.0
            elif rigid[k] < 0 and abs(g[k]) > context.band[k]:
                # An impact may give a function on its surface a velocity off it.
                modes[k], context.band[k] = 1 if g[k] > 0.0 else 0, 0.0
                largest[k] = max(largest[k], abs(g[k]))
    consistency.count_sliding(context, modes)
    set_preferences(context)
    for k in range(s):
        if rigid[k] >= 0 and modes[k] == 1 and rates[k] > resting:
            context.preferred[k] = consistency.fixed_entry(1)
        # Where conditions written apart let a velocity rest, it does not set off by itself.
        if context.boundary[k] == MIXED and context.band[k] > 0.0:
            context.preferred[k] = SLIDING
        if context.table_part[k] == KNOTS:
            mode = 1 if context.trial[k] > 0.0 else 0
            context.preferred[k] = consistency.decided_entry(
                mode if context.band[k] > 0.0 else modes[k]
            )
    return select_modes(context, first, t, d, state)
