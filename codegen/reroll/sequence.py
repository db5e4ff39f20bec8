"""The values of a kernel as arrays: operations in the order of evaluation, and what they take."""

from collections.abc import Mapping, Sequence
from itertools import chain

import numpy as np

from codegen.lower.program import COMMUTATIVE, LOGICAL, Input, Kernel, Lookup, Op, Program, Value
from codegen.reroll.evaluation_order import order_on_demand
from codegen.reroll.parts import Slots

OPERANDS = 3  # layout: of an operation at the most
_CODES = {op: k for k, op in enumerate(Op)}
_IS_COMMUTATIVE = np.array([op in COMMUTATIVE for op in Op])
_IS_LOGICAL = np.array([op in LOGICAL for op in Op])
NUMBER, TIME = "number", "t"
"""Where a leaf stands that is in no array."""


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
