"""Layout of a function table: one array of integers through which compiled code reaches a machine.

A table holds addresses of functions and of arrays, and a few numbers. It travels as `context` from
function to function in place of them all. A layout is the one declaration of a table: each line
allots a slot and answers with what compiled code takes out of it. The arrays of a run's table are
also attributes of `context` in compiled code: ``context.modes``.
"""

from collections.abc import Callable
from functools import cached_property
from math import prod
from typing import Any, NamedTuple, cast

import numpy as np
from numba import types

from codegen.machine_code.table_values import array_at
from runtime.core.arrays import IntegerMatrix, Integers, Matrix, Vector
from runtime.core.jit import at
from runtime.core.kernel_abi import KERNELS

_ALIGNED = 8  # layout: words of a cache line, in which an array of its own begins

Length = int | tuple[int, int | None]
"""A slot that holds a length; or a factor and such a slot, or a factor alone and None."""
_OfIntegers = Callable[[Integers], Integers]


class ArraySlot(NamedTuple):
    """An array in a table: its slot, its element type and its lengths."""

    slot: int
    item: Any
    lengths: tuple[tuple[int, int | None], ...]
    flat: bool
    allotted: bool


class TableLayout:
    """Slots of one kind of table: those of the kernels, then the others as they are declared."""

    def __init__(self, attributes: bool = False) -> None:
        self.attributes = attributes
        self.slots: dict[str, int] = {name: slot for slot, name in enumerate(KERNELS)}
        self.size = len(KERNELS)
        self.arrays: dict[str, ArraySlot] = {}

    def number(self, name: str) -> int:
        """Slot of a number, which compiled code reads as ``context[SLOT]``.

        Raises ValueError if the table, or its kernels, have the name.
        """
        if name in self.slots:
            raise ValueError(f"a table has one slot of a name, and {name!r} is taken")
        slot = self.slots[name] = self.size
        self.size += 1
        return slot

    def function(self, name: str, signature: Any) -> Callable[[Integers], Callable[..., Any]]:
        """Declare the function `name`; answers with what takes it out of a table."""
        return at(types.FunctionType(signature), self.number(name))

    def floats(
        self, names: str, *lengths: Length, allotted: bool = True, flat: bool = True,
        item: Any = types.float64,
    ) -> Callable[[Integers], Vector]:  # fmt: skip
        """Declare arrays of float64 by their `names`: flat, or with `lengths` as their shape.

        Answers with what takes the first out of a table. One that is not `allotted` is made
        elsewhere.
        """
        pairs = tuple(length if isinstance(length, tuple) else (1, length) for length in lengths)
        for name in names.split():
            self.arrays[name] = ArraySlot(self.number(name), item, pairs, flat, allotted)
        fetchers = [self._fetcher(name, self.arrays[name]) for name in names.split()]
        return fetchers[0]

    def matrix(self, names: str, *lengths: Length, **form: Any) -> Callable[[Integers], Matrix]:
        """As `floats`, of two dimensions."""
        return self.floats(names, *lengths, flat=False, **form)

    def integers(self, names: str, *lengths: Length, **form: Any) -> Callable[[Integers], Integers]:
        """As `floats`, of int64."""
        return cast(_OfIntegers, self.floats(names, *lengths, item=types.int64, **form))

    def integer_matrix(
        self, names: str, *lengths: Length, **form: Any
    ) -> Callable[[Integers], IntegerMatrix]:
        """As `matrix`, of int64."""
        return self.integers(names, *lengths, flat=False, **form)

    def flat(self, name: str, matrix: str) -> Callable[[Integers], Vector]:
        """Declare the array `matrix`, flat, by a name of its own; answers as `floats`."""
        return self._fetcher(name, self.arrays[matrix]._replace(flat=True))

    def _fetcher(self, name: str, array: ArraySlot) -> Callable[[Integers], Any]:
        """What makes an array, not owned, of what lies at an address in a table."""
        attributes = (name,) if self.attributes else ()
        found = array_at(array.slot, array.item, array.lengths, array.flat, attributes)
        return cast(Callable[[Integers], Any], found)

    def allot(self, table: Integers) -> dict[str, Any]:
        """Arrays of zeros for a table whose numbers are set, their addresses written into it.

        They lie in one block, and are made when they are first asked for.
        """
        numbers, end, starts = table.tolist(), 0, {}
        for name, array in self.arrays.items():
            if array.allotted:
                size = 1
                for factor, count in array.lengths:
                    size *= factor if count is None else factor * numbers[count]
                starts[name] = end
                end += -(-size // _ALIGNED) * _ALIGNED
        block = np.zeros(end, np.int64)
        address = block.ctypes.data
        for name, start in starts.items():
            numbers[self.slots[name]] = address + 8 * start
        table[:] = numbers
        return _Allotted(self, table, block, starts)


class _Allotted(dict[str, Any]):
    """Arrays of a table by name: those that it allots, in one block, and some made elsewhere."""

    def __init__(
        self, layout: TableLayout, table: Integers, block: Integers, starts: dict[str, int]
    ) -> None:
        self.layout, self.table, self.block, self.starts = layout, table, block, starts

    @cached_property
    def slots(self) -> Integers:
        """Of the arrays in the block."""
        return np.array([self.layout.slots[name] for name in self.starts])

    def copied(self) -> "_Allotted":
        """The same with a table and a block of its own; arrays made elsewhere are shared."""
        table, block = self.table.copy(), self.block.copy()
        table[self.slots] += block.ctypes.data - self.block.ctypes.data
        other = _Allotted(self.layout, table, block, self.starts)
        other |= {name: array for name, array in self.items() if name not in self.starts}
        return other

    def __missing__(self, name: str) -> Any:
        array, start = self.layout.arrays[name], self.starts[name]
        shape = [f if count is None else f * int(self.table[count]) for f, count in array.lengths]
        words = self.block[start : start + prod(shape)]
        words = words.view(np.float64) if array.item is types.float64 else words
        self[name] = words = words if array.flat else words.reshape(shape)
        return words
