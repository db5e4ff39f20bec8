"""Mode search: candidate modes of several functions on their surfaces, by pivots or all."""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core.array_types import Context
from runtime.core.jit import inner
from runtime.core.modes_and_event_kinds import SLIDING
from runtime.hybrid import mode_consistency as consistency
from runtime.hybrid.redundant_sliding import is_unilateral, rests
from runtime.linalg.vectors import copy_vector

MOST_COMBINED = 10  # safety: functions of which all combinations of modes are tried
MOST_WITH_SLIDING = 6  # safety: the same where all may slide; more are first searched by pivots


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
