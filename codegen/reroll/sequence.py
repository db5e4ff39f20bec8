"""The values of a kernel as a sequence of operations, and the repeats in it.

The values of a program stand in the order in which they were derived: all sines, then all terms of
the constraints, then the elimination. A loop over the bars for each of these would pass everything
that a bar computes through memory. A depth-first search from what the kernel stores brings together
what belongs together: a bar's terms, its elimination, then the next bar.
"""

from collections.abc import Container, Mapping, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.lower.program import COMMUTATIVE, LOGICAL, Input, Kernel, Lookup, Op, Program, Value

OPERANDS = 3  # layout: of an operation at the most
_CODES = {op: k for k, op in enumerate(Op)}
_IS_COMMUTATIVE = np.array([op in COMMUTATIVE for op in Op])
_IS_LOGICAL = np.array([op in LOGICAL for op in Op])
NUMBER, TIME = "number", "t"
"""Where a leaf stands that is in no array."""
Slots = npt.NDArray[np.int64]
WORDS = (4, 16, 64)  # accuracy: lengths of the words whose distances suggest a period
CANDIDATES = 12  # measured: periods that are tried for a length of words
LEAST_SAVING = 12  # measured: operations that a loop must save, as its own text costs as much


def order_on_demand(
    values: Sequence[Value], kernel: Kernel, constants: Container[int]
) -> list[int]:
    """Numbers of the values that `kernel` computes, each right before the first that takes it.

    The opposite of a value that is stored or checked stands behind the value, and a pivot's
    reference behind the pivot: neither waits in memory. `constants` are read and not computed.
    """
    behind: dict[int, list[int]] = {}
    for root in dict.fromkeys(kernel.roots):
        if values[root].op is Op.NEG:
            behind.setdefault(values[root].args[0], []).append(root)
    for check in kernel.checks:
        behind.setdefault(check.pivot, []).append(check.reference)
    visited, found = bytearray(len(values)), list[int]()
    stack = [*reversed(kernel.roots)]
    while stack:
        number = stack.pop()
        if number < 0:  # all that it takes is there
            number = ~number
            found.append(number)
            if number in behind:
                stack += reversed(behind[number])
        elif not visited[number]:
            visited[number] = True
            args = values[number].args
            if args and number not in constants:
                stack.append(~number)
                stack += args[::-1]
    return found


class OperationSequence:
    """The operations of a kernel, and the leaves of its values.

    Attributes
    ----------
    numbers
        Of the values that are computed, in the order of evaluation, shape (k,).
    operands
        Numbers of the values that each takes, shape (k, 3), -1 where there is none. Those of sums
        and products stand in the order in which they are computed, leaves first.
    codes
        Equal for operations of one kind, shape (k,).
    logical
        Whether they are true or false, shape (k,).
    place
        Value → its place among the computed, -1 for leaves; shape (all values,).
    home_of, slot_of
        Value → the place in `homes` of the array in which a leaf stands, and its slot there, 0 for
        numbers, the time and what is computed; shape (all values,).
    homes
        Names of arrays, of which the first stands for values that are computed.
    """

    def __init__(self, program: Program, kernel: Kernel, constants: Mapping[int, int]) -> None:
        """`constants`: value → slot in ``p``, of those that the kernel reads there."""
        self.program, self.constants = program, constants
        values = program.values
        computed = order_on_demand(values, kernel, constants)
        self.numbers = np.array(computed, dtype=np.int64)
        self.place = np.full(len(values), -1, dtype=np.int64)
        self.place[self.numbers] = np.arange(len(computed))
        operations = [values[k] for k in computed]
        self.codes = np.array([_CODES[value.op] for value in operations], dtype=np.int64)
        self.operands = np.full((len(computed), OPERANDS), -1, dtype=np.int64)
        taken = [value.args for value in operations]
        counts = np.fromiter(map(len, taken), dtype=np.int64, count=len(taken))
        rows = np.repeat(np.arange(len(computed)), counts)
        columns = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
        everything = chain.from_iterable(taken)
        self.operands[rows, columns] = np.fromiter(everything, np.int64, count=len(rows))
        self.logical = _IS_LOGICAL[self.codes]
        self._order_commutative()
        self._tell_lookups_apart(operations)
        self._find_leaves(kernel)

    def _tell_lookups_apart(self, operations: Sequence[Value]) -> None:
        """Give the lookups of each table and derivative a code of their own."""
        found: dict[Lookup, int] = {}
        for k in np.flatnonzero(self.codes == _CODES[Op.TABLE]).tolist():
            literal = operations[k].literal
            assert isinstance(literal, Lookup)
            self.codes[k] = len(_CODES) + found.setdefault(literal, len(found))

    def _find_leaves(self, kernel: Kernel) -> None:
        self.home_of, self.slot_of = np.zeros((2, len(self.place)), dtype=np.int64)
        taken = np.zeros(len(self.place), dtype=bool)
        taken[self.operands[self.operands >= 0]] = True
        taken[kernel.roots] = True
        homes = {"": 0}
        for number in np.flatnonzero(taken & (self.place < 0)).tolist():
            home = self.home(number)
            self.home_of[number] = homes.setdefault(home, len(homes))
            if home not in (NUMBER, TIME):
                self.slot_of[number] = self.slot(number)
        self.homes = tuple(homes)

    def _order_commutative(self) -> None:
        operands, rows = self.operands, _IS_COMMUTATIVE[self.codes]
        first, second = operands[rows, 0], operands[rows, 1]
        places = self.place[first], self.place[second]
        swap = places[0] > places[1]
        both = (places[0] < 0) & (places[1] < 0)
        for k in np.flatnonzero(both):
            one, other = int(first[k]), int(second[k])
            swap[k] = (self.home(one), one) > (self.home(other), other)
        operands[rows, 0] = np.where(swap, second, first)
        operands[rows, 1] = np.where(swap, first, second)

    def home(self, number: int) -> str:
        """The array in which a leaf stands, or where else; "" for a value that is computed."""
        if number in self.constants:
            return "p"
        value = self.program.values[number]
        if value.op is Op.CONST:
            return NUMBER
        if value.op is Op.MODE:
            return "modes"
        return value.literal.array if isinstance(value.literal, Input) else ""

    def slot(self, number: int) -> int:
        """The slot of a leaf in its array."""
        if number in self.constants:
            return self.constants[number]
        literal = self.program.values[number].literal
        return literal.slot if isinstance(literal, Input) else int(literal)  # type: ignore[arg-type]

    def is_logical(self, number: int) -> bool:
        """Whether a value is true or false."""
        return self.program.values[number].op in LOGICAL

    def crossings(self) -> Slots:
        """How many values are alive before each operation, shape (k + 1,)."""
        count = len(self.numbers)
        last = np.arange(count)  # place of the last use
        for column in self.operands.T:
            users = np.flatnonzero(column >= 0)
            sources = self.place[column[users]]
            inner = sources >= 0
            np.maximum.at(last, sources[inner], users[inner])
        change = np.zeros(count + 2, dtype=np.int64)
        change[1 : count + 1] += 1  # alive from behind its own place
        np.subtract.at(change, last + 1, 1)
        return np.cumsum(change)[: count + 1]


class Stretch(NamedTuple):
    """`turns` times `period` codes from `start` on; straight ones have one turn."""

    start: int
    period: int
    turns: int

    @property
    def end(self) -> int:
        """The first code behind it."""
        return self.start + self.period * self.turns


def stretches(codes: Slots, crossings: Slots) -> tuple[Stretch, ...]:
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


def _longest_repeat(codes: Slots) -> tuple[int, int, int] | None:
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


def _periods(codes: Slots) -> list[int]:
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


def _words(codes: Slots, length: int) -> npt.NDArray[np.uint64]:
    """A number for each word of so many codes, equal for equal words."""
    numbers = codes.astype(np.uint64)
    width = 1
    with np.errstate(over="ignore"):
        while width < length:  # words of twice the length from two neighbours
            mixed = numbers[:-width] * np.uint64(0x9E3779B97F4A7C15) + numbers[width:]
            numbers = (mixed ^ (mixed >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)
            width *= 2
    return numbers


def _best_phase(crossings: Slots, start: int, period: int, length: int) -> tuple[int, int]:
    """Where the turns of a repeat begin, and how many there are."""
    middle = start + (length // period // 2) * period
    room = length % period
    phases = range(room + 1) if length // period < 3 else range(min(period, length - 2 * period))
    alive = [(int(crossings[middle + k]), k > room, k) for k in phases]
    _, _, phase = min(alive)
    return start + phase, (length - phase) // period
