"""Which modes are tried, where several functions are on their surface: in turn, or all of them."""

import numpy as np

from runtime.core.array_types import Integers
from runtime.core.function_table import (
    SWITCHES,
    candidate_modes_of,
    members_of,
    modes_of,
    rigid_of,
    share_high_of,
    share_low_of,
    share_of,
    sticks_of,
)
from runtime.core.jit import inner
from runtime.core.workspace import BAND, PREFERRED, switch_row
from runtime.hybrid.mode_consistency import CONSISTENT, GIVEN, contradicted, hold
from runtime.hybrid.sliding_modes import HELD_MODE

MOST = 10  # safety: functions whose modes are tried in all combinations
MOST_THREE = 6  # safety: of those that may also slide; more are first settled in turn


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


@inner
def flipped(context: Integers, k: int, mode: int, preferred: int) -> int:
    """What function `k` is to try next, whose `mode` is contradicted.

    What nothing holds goes where the force that would hold it exceeds what it may be.
    """
    if mode == HELD_MODE:
        share = share_of(context)[k]
        low, high = share_low_of(context)[k], share_high_of(context)[k]
        if rigid_of(context)[k] >= 0 or not np.isfinite(share):
            return 1
        return 1 if share > 0.5 * (low + high) else 0
    freely = rigid_of(context)[k] < 0 and sticks_of(context)[k] == 0
    return 1 - mode if freely and mode == preferred else HELD_MODE


@inner
def in_turn(context: Integers, t: float, d: float, state: int, count: int) -> int:
    """Modes by changing the first that is contradicted, again and again, as Murty's pivots do.

    (K. G. Murty, Note on a Bard-type scheme for solving the complementarity problem, Opsearch 11,
    1974.) Functions that know nothing of each other settle one after the other. Where friction or a
    surface that repels makes it run in circles, it gives up: each function has three
    modes, and may be met again once for each of the others.
    """
    modes = modes_of(context)
    members = members_of(context)
    band = switch_row(context, BAND)
    preferred_row = switch_row(context, PREFERRED)
    s = context[SWITCHES]
    candidate = candidate_modes_of(context)
    for k in range(s):
        candidate[k] = modes[k]
    for i in range(count):
        candidate[members[i]] = int(preferred_row[members[i]]) % GIVEN
    wrong = CONSISTENT
    for _ in range(3 * count * count):
        wrong = contradicted(context, t, d, state, candidate, count)
        if wrong == CONSISTENT:
            for k in range(s):
                modes[k] = candidate[k]
            hold(context, modes)
            break
        if not band[wrong] > 0.0:
            break
        preferred = int(preferred_row[wrong]) % GIVEN
        candidate[wrong] = flipped(context, wrong, int(candidate[wrong]), preferred)
    return wrong


@inner
def exhaustively(context: Integers, t: float, d: float, state: int, tried: int, count: int) -> int:
    """Modes by trying all combinations for the first `tried` members; result as of `settle`."""
    modes = modes_of(context)
    members = members_of(context)
    s = context[SWITCHES]
    candidate = candidate_modes_of(context)
    preferred, rigid = switch_row(context, PREFERRED), rigid_of(context)
    choices = 3 if tried <= MOST_THREE else 2
    combinations = choices**tried
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
                wrong = contradicted(context, t, d, state, candidate, count)
                if wrong == CONSISTENT:
                    for k in range(s):
                        modes[k] = candidate[k]
                    hold(context, modes)
                    return CONSISTENT
                if blamed == CONSISTENT:
                    blamed = wrong
    hold(context, modes)
    return blamed
