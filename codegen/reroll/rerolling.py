"""A kernel's values → parts: repeats become loops, whose turns take their operands from tables.

A loop whose operands stand on straight lines in its counter needs no table. Where an elimination
treats every other bar in another way, a loop over single bars reads now at one distance and now at
another; a loop over pairs of bars reads on straight lines. So does a loop without its first or last
turn, where that turn alone reads elsewhere.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.lower.program import Input, Kernel, Label, Op, Output, Program, Value
from codegen.reroll.parts import WORK, Carried, Operand, Part, RolledKernel, Store, Workspace
from codegen.reroll.sequence import (
    NUMBER,
    TIME,
    OperationSequence,
    Slots,
    Stretch,
    merged,
    stretches,
    without,
)

REPEATS = 12  # measured: most copies of a body in one turn; sums of `correction` need ten
PEELED = 12  # measured: most turns that are written out at each end
LEAST_TURNS = 4  # accuracy: turns of the shortest loop, which show whether indices are linear
WORTH = 12  # measured: statements of text that cost as much as one column of a table


class Outside(NamedTuple):
    """A column of operands that are no values of the same turn: one value a turn."""

    numbers: tuple[int, ...]


class FromTurnBefore(NamedTuple):
    """A column of operands that are the value at `position` of the turn before; `first` before."""

    position: int
    first: int


Column = int | Outside | FromTurnBefore
"""A column of operands: a position in the body, or what comes from outside."""


class Rerolling:
    """The stretches of a kernel, the operands of their bodies, and the workspace.

    `program` is that of its values, `constants` map values that it reads in ``p`` instead of
    computing them to slots there.
    """

    def __init__(self, program: Program, kernel: Kernel, constants: Mapping[int, int]) -> None:
        self.kernel, self.values = kernel, program.values
        self.sequence = seq = OperationSequence(program, kernel, constants)
        self.sorts = self._sorts()
        self.blocks = self._cut(stretches(seq.codes, seq.crossings()))
        places = self._places()
        unrolled = [with_affine_accesses(s, self._accesses(s, *places)) for s in self.blocks]
        self.stretches = self._cut([piece for pieces in unrolled for piece in pieces])
        self.columns = [self._columns(s) for s in self.stretches]
        self.workspace = Workspace(seq, kernel)

    def _cut(self, found: Sequence[Stretch]) -> list[Stretch]:
        """The stretches with turns that stand by themselves where they must."""
        whole = merged(found)
        while any(crossed := [self._crossed_turns(s) for s in whole]):
            cut = [without(s, turns) for s, turns in zip(whole, crossed, strict=True)]
            whole = merged([piece for pieces in cut for piece in pieces])
        return whole

    # -- columns of operands -----------------------------------------------------------------

    def _turns(self, s: Stretch) -> Slots:
        """Places of the operations, shape (turns, period)."""
        return np.arange(s.start, s.end).reshape(s.turns, s.period)

    def _crossed_turns(self, s: Stretch) -> list[int]:
        """Turns that stand by themselves, for an operand of theirs comes from elsewhere.

        What a turn takes is loaded before it computes anything. An operand that some turns compute
        themselves and others do not is no column: the fewer turns are written out. Neither do truth
        values and numbers stand in one column.
        """
        if s.turns == 1:
            return []
        found: set[int] = set()
        begins = s.start + s.period * np.arange(s.turns)
        for column in self._operand_columns(s):
            if not isinstance(self._kind(s, column), Outside):
                continue
            places = self.sequence.place[column] - begins
            within = places >= 0
            if within.any():
                place = int(np.bincount(places[within]).argmax())
                same = places == place
                few = ~same if 2 * np.count_nonzero(same) > s.turns else within
                found |= set(np.flatnonzero(few).tolist())
            sorts = self.sorts[column]
            if (sorts != sorts[0]).any():
                found |= set(range(s.turns))
        return sorted(found)

    def _sorts(self) -> Slots:
        """What kind of number each value is in the text: a float, a truth value or a mode."""
        seq = self.sequence
        sorts = np.zeros(len(self.values), dtype=np.int64)
        sorts[seq.numbers] = seq.logical
        if "modes" in seq.homes:
            sorts[seq.home_of == seq.homes.index("modes")] = 2
        return sorts

    def _operand_columns(self, s: Stretch) -> Sequence[Slots]:
        rows = self.sequence.operands[s.start : s.end].reshape(s.turns, s.period, -1)
        return [
            rows[:, j, k]
            for j in range(s.period)
            for k in range(rows.shape[2])
            if rows[0, j, k] >= 0
        ]

    def _kind(self, s: Stretch, column: Slots) -> Column:
        places = self.sequence.place[column]
        begins = s.start + s.period * np.arange(s.turns)
        position = int(places[0]) - s.start
        if 0 <= position < s.period and np.array_equal(places, begins + position):
            return position
        if s.turns > 1 and not self.sequence.is_logical(int(column[0])):
            position = int(places[1]) - s.start
            before = begins[:-1] + position
            if 0 <= position < s.period and np.array_equal(places[1:], before):
                return FromTurnBefore(position, int(column[0]))
        return Outside(tuple(column.tolist()))

    def _columns(self, s: Stretch) -> Sequence[Sequence[Column]]:
        """Of each operation of the body, where its operands come from."""
        rows = self.sequence.operands[s.start : s.end].reshape(s.turns, s.period, -1)
        return [
            [self._kind(s, rows[:, j, k]) for k in range(rows.shape[2]) if rows[0, j, k] >= 0]
            for j in range(s.period)
        ]

    def _places(self) -> tuple[Slots, Slots]:
        """Of each value the kind of its place, and its address, which are as its slot will be."""
        seq, homes = self.sequence, self.sequence.home_of
        begins = np.array([s.start for s in self.blocks])
        kinds = np.where(homes > 0, -homes, np.searchsorted(begins, seq.place, side="right"))
        if NUMBER in seq.homes:  # those are of one kind that are equal
            numbers = np.flatnonzero(homes == seq.homes.index(NUMBER))
            kinds[numbers] = -len(seq.homes) - numbers
        return kinds, np.where(homes > 0, seq.slot_of, seq.place)

    def _accesses(self, s: Stretch, kinds: Slots, addresses: Slots) -> list[tuple[Slots, Slots]]:
        """Kinds of place and addresses of what the turns of a stretch take from outside."""
        if s.turns == 1:
            return []
        columns = {c for row in self._columns(s) for c in row if isinstance(c, Outside)}
        numbers = (np.array(column.numbers) for column in columns)
        return [(kinds[column], addresses[column]) for column in numbers]

    # -- workspace ---------------------------------------------------------------------------

    def _ask_for_slots(self, outputs: Sequence[Output]) -> None:
        """Note every value that another part, a check or an output reads."""
        for column in (c for columns in self.columns for row in columns for c in row):
            if isinstance(column, FromTurnBefore):
                if self.sequence.home(column.first) == "":
                    self.workspace.need(column.first)
            elif isinstance(column, Outside):
                self.workspace.need_column(column.numbers)
        self.workspace.need_results(outputs)

    # -- parts -------------------------------------------------------------------------------

    def rolled(self) -> RolledKernel:
        """The kernel in parts."""
        written = [out for out in self.kernel.outputs if out.array != "return"]
        stores, others = self._stores_of_bodies(written)
        returned = [out for out in self.kernel.outputs if out.array == "return"]
        self._ask_for_slots([*others, *returned])
        space = self.workspace
        space.assign(self.sequence.numbers[self._turns(s)] for s in self.blocks)
        parts = space.copies_of_leaves()
        for s, columns, own in zip(self.stretches, self.columns, stores, strict=True):
            parts.append(self._part(s, columns, own))
        parts += space.copies_of_outputs(others)
        return space.rolled(parts)

    def _stores_of_bodies(
        self, outputs: Sequence[Output]
    ) -> tuple[list[list[Store]], list[Output]]:
        """Stretch by stretch the outputs that each of its turns has, and the other outputs."""
        of: dict[int, list[Output]] = {}
        for out in outputs:
            of.setdefault(out.value, []).append(out)
        found = []
        for s in self.stretches:
            stores = []
            turns = self.sequence.numbers[self._turns(s)]
            for position, column in enumerate(turns.T.tolist()):
                while all(of.get(k) for k in column):
                    outs = [of[k][0] for k in column]
                    if len({out.array for out in outs}) > 1:
                        break
                    slots = np.array([of[k].pop(0).slot for k in column])
                    stores.append(Store(outs[0].array, slots, position))
            found.append(stores)
        return found, [out for outs in of.values() for out in outs]

    def _part(
        self, s: Stretch, columns: Sequence[Sequence[Column]], stores: Sequence[Store]
    ) -> Part:
        turns = self.sequence.numbers[self._turns(s)]
        sample = turns[min(1, s.turns - 1)].tolist()  # the turn after which things are called
        columns_outside = (c for row in columns for c in row if not isinstance(c, int))
        places = {column: k for k, column in enumerate(dict.fromkeys(columns_outside))}
        leaves, operands, shift = list[Value](), list[Operand](), len(places)
        for column in places:
            if (fixed := self._fixed_value(column)) is not None:
                leaves.append(fixed)
                continue
            if isinstance(column, FromTurnBefore):
                called = self.workspace.name(int(turns[0, column.position]))
                operands.append(
                    Carried(column.position + shift, self.workspace.first(column.first))
                )
            else:
                called = self.workspace.name(column.numbers[min(1, s.turns - 1)])
                operands.append(self.workspace.operand(column.numbers))
            leaves.append(Value(Op.INPUT, literal=Input("", len(operands) - 1, called)))
        body, slots_of = list(leaves), self.workspace.slots
        for number, row in zip(sample, columns, strict=True):
            args = tuple(c + shift if isinstance(c, int) else places[c] for c in row)
            value = self.values[number]
            body.append(Value(value.op, args, value.literal, value.serves))
        kept = [Store(st.array, st.slots, st.value + shift) for st in stores]
        for position, numbers in enumerate(turns.T):
            if slots_of[numbers[0]] >= 0:
                kept.append(Store(WORK, slots_of[numbers], position + shift))
        labels = tuple(
            Label(position + shift, self.workspace.labels[number])
            for position, number in enumerate(sample)
            if number in self.workspace.labels
        )
        span = self._served(turns[0].tolist()), self._served(turns[-1].tolist())
        return Part(s.turns, tuple(body), tuple(operands), tuple(kept), labels, span)

    def _fixed_value(self, column: Outside | FromTurnBefore) -> Value | None:
        """The number that a column is in every turn, or the time; None for others."""
        if isinstance(column, FromTurnBefore) or len(set(column.numbers)) > 1:
            return None
        value, home = self.values[column.numbers[0]], self.sequence.home(column.numbers[0])
        return value if home in (NUMBER, TIME) else None

    def _served(self, numbers: Sequence[int]) -> str:
        return next((v.serves for k in numbers if (v := self.values[k]).serves), "")


def with_affine_accesses(s: Stretch, columns: Sequence[tuple[Slots, Slots]]) -> list[Stretch]:
    """The stretch as a loop with few columns that need a table, and the turns beside it.

    The columns are what its turns take from outside: of each operand the kinds of place and the
    addresses, both (turns,). Addresses of one kind are comparable.
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
    """Where each column leaves the line of its middle, in `lag` lines, (columns, turns - lag)."""
    steps = addresses[:, lag:] - addresses[:, :-lag]
    bends: npt.NDArray[np.bool_] = kinds[:, lag:] != kinds[:, :-lag]
    middle = steps.shape[1] // 2
    for offset in range(lag):
        column = np.arange(offset, steps.shape[1], lag)
        usual = steps[:, column[np.searchsorted(column, middle) - 1]]
        bends[:, column] |= steps[:, column] != usual[:, None]
    return bends
