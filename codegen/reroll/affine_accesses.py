"""Affine accesses: a loop whose operands stand on straight lines in its counter needs no table.

Where an elimination treats every other bar in another way, a loop over single bars reads now at one
distance and now at another. A loop over pairs of bars reads on straight lines. So does a loop
without its first or last turn, where that turn alone reads elsewhere.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from codegen.reroll.parts import Slots
from codegen.reroll.repetition import Stretch

REPEATS = 12  # measured: copies of a body in a turn at the most; sums of `correction` need ten
PEELED = 12  # measured: turns that are written out at either end at the most
LEAST_TURNS = 4  # accuracy: of a loop, by which a straight line is told
WORTH = 12  # measured: statements of text that one column of a table may cost instead


def with_affine_accesses(s: Stretch, columns: Sequence[tuple[Slots, Slots]]) -> list[Stretch]:
    """The stretch as a loop with few columns that need a table, and the turns beside it.

    Parameters
    ----------
    s
        A stretch of several turns.
    columns
        What its turns take from outside: of each operand the kinds of place and the addresses, both
        of shape (turns,). Addresses of one kind are comparable.
    """
    if not columns or s.turns < LEAST_TURNS:
        return [s]
    kinds, addresses = (np.array(rows) for rows in zip(*columns, strict=True))
    choices = []
    for copies in range(1, min(REPEATS, s.turns // LEAST_TURNS) + 1):
        bends = np.cumsum(np.pad(_bends(kinds, addresses, copies), ((0, 0), (1, 0))), axis=1)
        ends = np.arange(min(PEELED, (s.turns - 3 * copies) // 2) + 1)
        # so many turns behind the first ones that the rest is a multiple of `copies`
        last = ends + (s.turns - ends[:, None] - ends) % copies
        curved = (bends[:, s.turns - copies - last] > bends[:, ends, None]).sum(axis=0)
        cost = s.period * (copies + ends[:, None] + last) + WORTH * curved
        first = int(cost.argmin()) // len(ends)
        place = int(cost[first].argmin())
        choices.append((int(cost[first, place]), copies, first, int(last[first, place])))
    _, copies, first, peeled_last = min(choices)
    turns = (s.turns - first - peeled_last) // copies
    body = Stretch(s.start + first * s.period, copies * s.period, turns)
    beside = [(s.start, first), (body.end, peeled_last)]
    peeled = [Stretch(start, count * s.period, 1) for start, count in beside if count]
    return sorted([body, *peeled])


def _bends(kinds: Slots, addresses: Slots, lag: int) -> npt.NDArray[np.bool_]:
    """Where each column leaves the line on which it is in its middle, shape (columns, turns - lag).

    Turns are compared with those `lag` later, so that there are as many lines as that.
    """
    steps = addresses[:, lag:] - addresses[:, :-lag]
    bends: npt.NDArray[np.bool_] = kinds[:, lag:] != kinds[:, :-lag]
    middle = steps.shape[1] // 2
    for offset in range(lag):
        column = np.arange(offset, steps.shape[1], lag)
        usual = steps[:, column[np.searchsorted(column, middle) - 1]]
        bends[:, column] |= steps[:, column] != usual[:, None]
    return bends
