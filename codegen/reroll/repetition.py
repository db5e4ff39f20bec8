"""Tandem repeats: stretches of a sequence that recur one behind the other.

A sequence of codes, one an operation of a kernel in the order of evaluation, repeats itself where
the machine does: bar after bar, loop after loop. The longest repeat is taken, then those of the
stretches before and behind it.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Codes = npt.NDArray[np.int64]

WORDS = (4, 16, 64)  # accuracy: lengths of the words whose distances suggest a period
CANDIDATES = 12  # measured: periods that are tried for a length of words
LEAST_SAVING = 12  # measured: operations that a loop must save, what it costs in text


class Stretch(NamedTuple):
    """`turns` times `period` codes from `start` on; straight ones have one turn."""

    start: int
    period: int
    turns: int

    @property
    def end(self) -> int:
        """The first code behind it."""
        return self.start + self.period * self.turns


def stretches(codes: Codes, crossings: Codes) -> tuple[Stretch, ...]:
    """The sequence cut into repeats and what stands between them.

    `crossings` counts at each place the values that are alive there, shape (len(codes) + 1,): where
    a repeat may begin at several places, it begins where least crosses from one turn to the next.
    """
    found: list[Stretch] = []
    pending = [(0, len(codes))]
    while pending:
        low, high = pending.pop()
        repeat = _longest_repeat(codes[low:high])
        if repeat is None:
            if high > low:
                found.append(Stretch(low, high - low, 1))
            continue
        first, period, length = repeat
        start, count = _best_phase(crossings, low + first, period, length)
        pending += [(low, start), (start + period * count, high)]
        found.append(Stretch(start, period, count))
    return tuple(sorted(found))


def merged(found: Sequence[Stretch]) -> list[Stretch]:
    """Stretches in order, neighbours without repetition made one."""
    whole: list[Stretch] = []
    for s in found:
        if whole and s.turns == 1 == whole[-1].turns:
            whole[-1] = Stretch(whole[-1].start, s.end - whole[-1].start, 1)
        else:
            whole.append(s)
    return whole


def without(s: Stretch, turns: Sequence[int]) -> list[Stretch]:
    """The stretch cut so that these turns stand by themselves."""
    pieces, begin = [], 0
    for turn in [*turns, s.turns]:
        if turn > begin:
            pieces.append(Stretch(s.start + begin * s.period, s.period, turn - begin))
        if turn < s.turns:
            pieces.append(Stretch(s.start + turn * s.period, s.period, 1))
        begin = turn + 1
    return pieces


def _longest_repeat(codes: Codes) -> tuple[int, int, int] | None:
    """Start, period and length of the repeat that saves most, the shortest period of these."""
    best, saving = None, LEAST_SAVING - 1
    for period in _periods(codes):
        same = codes[:-period] == codes[period:]
        edges = np.flatnonzero(np.diff(same, prepend=False, append=False))
        if not len(edges):
            continue
        starts, lengths = edges[::2], edges[1::2] - edges[::2] + period
        k = int(np.argmax(lengths))
        saved = (int(lengths[k]) // period - 1) * period
        if saved > saving:
            best, saving = (int(starts[k]), period, int(lengths[k])), saved
    return best


def _periods(codes: Codes) -> list[int]:
    """Periods worth a trial, ascending: the commonest distances between equal words."""
    counts: dict[int, int] = {}
    for length in WORDS:
        if len(codes) <= length:
            break
        words = _words(codes, length)
        order = np.argsort(words, kind="stable")
        again = words[order[1:]] == words[order[:-1]]
        distances, often = np.unique((order[1:] - order[:-1])[again], return_counts=True)
        weight = distances * often  # operations that a repeat of the distance may hold
        for k in np.argsort(-weight, kind="stable")[:CANDIDATES]:
            counts[int(distances[k])] = 1
    return sorted(period for period in counts if 2 * period <= len(codes))


def _words(codes: Codes, length: int) -> npt.NDArray[np.uint64]:
    """A number for each word of so many codes, equal for equal words."""
    numbers = codes.astype(np.uint64)
    width = 1
    with np.errstate(over="ignore"):
        while width < length:  # words of twice the length from two neighbours
            mixed = numbers[:-width] * np.uint64(0x9E3779B97F4A7C15) + numbers[width:]
            numbers = (mixed ^ (mixed >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)
            width *= 2
    return numbers


def _best_phase(crossings: Codes, start: int, period: int, length: int) -> tuple[int, int]:
    """Where the turns of a repeat begin, and how many there are.

    Each later beginning than the first may cost a turn at the end, which is then written out.
    """
    middle = start + (length // period // 2) * period
    room = length % period
    phases = range(room + 1) if length // period < 3 else range(min(period, length - 2 * period))
    alive = [(int(crossings[middle + k]), k > room, k) for k in phases]
    _, _, phase = min(alive)
    return start + phase, (length - phase) // period
