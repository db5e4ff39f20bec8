"""A kernel as loops: straight parts and loops over turns, on a workspace of its own.

A *part* is a small program that is run `count` times. What it takes from outside is an operand:
entries of arrays, one a turn, numbers, one a turn, or what the turn before it left in a scalar.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from codegen.lower.program import Input, Kernel, Label, Op, Output, Value
from codegen.reroll.sequence import NUMBER, OperationSequence, Slots

Numbers = npt.NDArray[np.float64]
WORK = "work"
"""The array of a call in which values outlive a turn."""


@dataclass(frozen=True, eq=False)
class Entries:
    """An entry of `array` a turn, at `slots`, shape (count,); `logical`: 0.0 means false."""

    array: str
    slots: Slots
    logical: bool = False


@dataclass(frozen=True, eq=False)
class Carried:
    """What `value` of the body was in the turn before; in the first turn an entry."""

    value: int
    first: "Entries | float"


Operand = Entries | Numbers | Carried


@dataclass(frozen=True, eq=False)
class Store:
    """Store `value` of the body in `array`, at `slots`, shape (count,), one a turn."""

    array: str
    slots: Slots
    value: int


@dataclass(frozen=True, eq=False)
class Part:
    """A body that runs `count` times, turn after turn.

    The first values of the body are its operands, in their order: inputs of the array "".
    """

    count: int
    body: tuple[Value, ...]
    operands: tuple[Operand, ...]
    stores: tuple[Store, ...]
    labels: tuple[Label, ...] = ()
    span: tuple[str, str] = ("", "")  # elements that the first and the last turn serve

    @property
    def statements(self) -> int:
        """Values that are written in the text."""
        return len(self.body) + len(self.stores)


@dataclass(frozen=True, eq=False)
class Batches:
    """Parts that take turns: each run does the next rows of one of them.

    Attributes
    ----------
    kinds
        What a run may be. Nothing is carried from row to row.
    runs
        Kind, first row and the row behind the last, shape (runs, 3).
    """

    kinds: tuple[Part, ...]
    runs: Slots

    @property
    def statements(self) -> int:
        """Values that are written in the text."""
        return sum(kind.statements for kind in self.kinds)


@dataclass(frozen=True, eq=False)
class Watch:
    """Checks on pivots in the workspace; shapes (count,)."""

    pivots: Slots
    references: Slots
    parts: Numbers
    constraints: Slots


@dataclass(frozen=True, eq=False)
class RolledKernel:
    """A kernel whose values are computed in parts."""

    parts: tuple[Part | Batches, ...]
    watch: Watch | None
    result: Entries | float | None  # what the kernel returns, where it returns a number
    workspace: int  # slots of the array `WORK`

    @property
    def statements(self) -> int:
        """Values that are written in the text."""
        return sum(part.statements for part in self.parts)


class Workspace:
    """Slots of the array `WORK`, for values that one part computes and another reads.

    First all that needs a slot is named (`need`), then slots are given (`assign`), then operands
    are asked for.
    """

    def __init__(self, sequence: OperationSequence, kernel: Kernel) -> None:
        self.sequence, self.kernel = sequence, kernel
        self.labels = {label.value: label.name for label in kernel.labels}
        self.needed = np.zeros(len(sequence.program.values), dtype=bool)
        # value → its slot, -1 where it has none
        self.slots: Slots = np.full(len(self.needed), -1, dtype=np.int64)
        self.leaves: list[int] = []  # leaves with a slot: copies, before anything is computed
        self.size = 0

    def need(self, *numbers: int) -> None:
        """Ask for slots of values."""
        self.needed[list(numbers)] = True

    def need_column(self, numbers: Sequence[int]) -> None:
        """Ask for slots of what an operand is, turn after turn."""
        column, homes = np.array(numbers), self._homes(numbers)
        array = homes[0] if len(np.unique(homes)) == 1 else WORK
        is_there = (self.sequence.home_of[column] > 0) & (homes == array)
        self.needed[column[~is_there]] = True

    def _homes(self, numbers: Sequence[int]) -> npt.NDArray[np.str_]:
        """The array of each value, the workspace of those that are computed."""
        names = np.array([home or WORK for home in self.sequence.homes])
        homes: npt.NDArray[np.str_] = names[self.sequence.home_of[np.array(numbers)]]
        return homes

    def need_results(self, outputs: Iterable[Output]) -> None:
        """Ask for slots of what the checks and these outputs read."""
        for check in self.kernel.checks:
            self.need(check.pivot, check.reference)
        self.need(*(out.value for out in outputs if self.sequence.home(out.value) == ""))

    def assign(self, blocks: Iterable[Slots]) -> None:
        """Give slots turn by turn, so that what a turn writes stands together.

        Blocks are values that are computed, (turns, period) each; a value of one turn that has a
        slot gives one to those of all its turns.
        """
        free = 0
        for turns in blocks:
            stored = turns[:, self.needed[turns].any(axis=0)]
            self.slots[stored.ravel()] = np.arange(free, free + stored.size)
            free += stored.size
        self.leaves = np.flatnonzero(self.needed & (self.slots < 0)).tolist()
        self.slots[self.leaves] = np.arange(free, free + len(self.leaves))
        self.size = free + len(self.leaves)

    def operand(self, numbers: Sequence[int]) -> Entries | Numbers:
        """The operand that is these values, turn after turn."""
        seq, column, homes = self.sequence, np.array(numbers), self._homes(numbers)
        array = str(homes[0]) if (homes == homes[0]).all() else WORK
        if array == NUMBER:
            return np.array([seq.program.values[n].literal for n in numbers], dtype=np.float64)
        is_there = (seq.home_of[column] > 0) & (homes == array)
        slots = np.where(is_there, seq.slot_of[column], self.slots[column])
        if (slots < 0).any():
            raise KeyError(f"a value of kernel {self.kernel.name} is read that nothing stores")
        logical = not is_there[0] and seq.home(numbers[0]) == "" and seq.is_logical(numbers[0])
        return Entries(array, slots, logical)

    def first(self, number: int) -> Entries | float:
        """Where a value stands, for one that is read once."""
        if self.sequence.home(number) == NUMBER:
            return float(self.sequence.program.values[number].literal)  # type: ignore[arg-type]
        operand = self.operand((number,))
        assert isinstance(operand, Entries)
        return operand

    def name(self, number: int) -> str:
        """What an operand is called: as an input, or as the value of another part."""
        literal = self.sequence.program.values[number].literal
        return literal.name if isinstance(literal, Input) else self.labels.get(number, "")

    def copies_of_leaves(self) -> list[Part]:
        """Parts that copy the leaves to their slots."""
        return self._copies([(k, WORK, int(self.slots[k])) for k in self.leaves])

    def copies_of_outputs(self, outputs: Iterable[Output]) -> list[Part]:
        """Parts that copy values to the arrays of outputs."""
        return self._copies([(out.value, out.array, out.slot) for out in outputs])

    def _copies(self, copies: Sequence[tuple[int, str, int]]) -> list[Part]:
        """Parts that copy leaves, or values of the workspace, to (array, slot)."""
        groups: dict[tuple[str, str], list[tuple[int, int]]] = {}
        for number, array, slot in copies:
            from_ = self.sequence.home(number) or WORK
            groups.setdefault((from_, array), []).append((number, slot))
        parts = []
        for (_, array), pairs in groups.items():
            numbers, slots = zip(*sorted(pairs, key=lambda pair: pair[1]), strict=True)
            body = (Value(Op.INPUT, literal=Input("", 0, "x")),)
            store = Store(array, np.array(slots), 0)
            parts.append(Part(len(slots), body, (self.operand(numbers),), (store,)))
        return parts

    def rolled(self, parts: Iterable[Part | Batches]) -> RolledKernel:
        """The kernel in these parts, its checks on pivots and what it returns."""
        kernel, watch = self.kernel, None
        returned = [self.first(out.value) for out in kernel.outputs if out.array == "return"]
        if kernel.watched:
            rows = [
                (self.slots[check.pivot], self.slots[check.reference], 1 + check.constraint)
                for check in kernel.checks
            ]
            pivots, references, constraints = np.array(rows, np.int64).reshape(-1, 3).T.copy()
            part = np.array([check.part for check in kernel.checks])
            watch = Watch(pivots, references, part, constraints)
        result = returned[0] if returned else None
        return RolledKernel(tuple(parts), watch, result, self.size)
