"""Layout of a function table: one array of integers through which compiled code reaches a machine.

A table holds addresses of functions and of arrays, and a few numbers. It travels as `context` from
function to function in place of them all. A layout is the one declaration of a table: each line
allots a slot and answers with what compiled code takes out of it.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, cast

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np import arrayobj

from runtime.core.jit import at
from runtime.core.signatures import IntegerMatrix, Integers, Matrix, Vector

_arrays: Any = arrayobj
_tools: Any = cgutils

Length = int | tuple[int, int | None]
"""A slot that holds a length; or a factor and such a slot, or a factor alone and None."""


class ArraySlot(NamedTuple):
    """An array in a table: its slot, its element type and its lengths."""

    slot: int
    item: Any
    lengths: tuple[Length, ...]
    flat: bool
    allotted: bool

    def shape(self, table: Integers) -> tuple[int, ...]:
        """The shape where the numbers of `table` hold."""
        lengths = [_length(table, length) for length in self.lengths]
        return (int(np.prod(lengths)),) if self.flat else tuple(lengths)

    def zeros(self, table: Integers) -> np.ndarray:
        """An array of this shape."""
        kind = np.float64 if self.item is types.float64 else np.int64
        return np.zeros(self.shape(table), kind)


class TableLayout:
    """Slots of one kind of table, in the order in which they are declared."""

    def __init__(self) -> None:
        self.size = 0
        self.slots: dict[str, int] = {}
        self.arrays: dict[str, ArraySlot] = {}

    def _next(self, name: str) -> int:
        slot = self.slots[name] = self.size
        self.size += 1
        return slot

    def number(self, name: str) -> int:
        """Slot of a number, which compiled code reads as ``context[SLOT]``."""
        return self._next(name)

    def function(self, name: str, signature: Any) -> Callable[[Integers], Callable[..., Any]]:
        """What takes the function `name` out of a table."""
        return at(types.FunctionType(signature), self._next(name))

    def floats(
        self, name: str, *lengths: Length, allotted: bool = True
    ) -> Callable[[Integers], Vector]:
        """What takes a flat array of float64, as long as the product of `lengths`, out of a table.

        An array that is not `allotted` is made elsewhere.
        """
        return self._array(name, types.float64, lengths, True, allotted)

    def integers(
        self, name: str, *lengths: Length, allotted: bool = True
    ) -> Callable[[Integers], Integers]:
        """As `floats`, for int64."""
        return self._array(name, types.int64, lengths, True, allotted)

    def matrix(
        self, name: str, rows: Length, columns: Length, allotted: bool = True
    ) -> Callable[[Integers], Matrix]:
        """What takes a matrix of float64 out of a table."""
        return self._array(name, types.float64, (rows, columns), False, allotted)

    def integer_matrix(
        self, name: str, rows: Length, columns: Length, allotted: bool = True
    ) -> Callable[[Integers], IntegerMatrix]:
        """As `matrix`, for int64."""
        return self._array(name, types.int64, (rows, columns), False, allotted)

    def flat(self, name: str) -> Callable[[Integers], Vector]:
        """The matrix `name` as a flat array."""
        array = self.arrays[name]
        return _fetcher(array._replace(flat=True))

    def _array(
        self, name: str, item: Any, lengths: tuple[Length, ...], flat: bool, allotted: bool
    ) -> Callable[[Integers], Any]:
        array = ArraySlot(self._next(name), item, lengths, flat, allotted)
        self.arrays[name] = array
        return _fetcher(array)

    def allot(self, table: Integers) -> dict[str, Any]:
        """Arrays of zeros for a table whose numbers are set, their addresses written into it.

        They must live as long as the table.
        """
        made = {}
        for name, array in self.arrays.items():
            if array.allotted:
                made[name] = values = array.zeros(table)
                table[array.slot] = values.ctypes.data
        return made


def _length(table: Integers, length: Length) -> int:
    factor, slot = length if isinstance(length, tuple) else (1, length)
    return factor if slot is None else factor * int(table[slot])


def word(builder: Any, table: Any, slot: int) -> Any:
    """The word in a slot of a table, in generated code."""
    place = _tools.intp_t(slot)
    return builder.load(builder.gep(table.data, [place], inbounds=True))


def _fetcher(array: ArraySlot) -> Callable[[Integers], Any]:
    """An intrinsic that makes an array, not owned, of what lies at an address in a table."""

    def fetch(typing_context: Any, context: Any) -> Any:
        result = types.Array(array.item, 1 if array.flat else len(array.lengths), "C")
        signature = result(context)

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            table = _arrays.make_array(signature.args[0])(context, builder, arguments[0])
            target = _arrays.make_array(signature.return_type)(context, builder)
            shape = [_emitted(builder, table, length) for length in array.lengths]
            if array.flat:
                product = shape[0]
                for other in shape[1:]:
                    product = builder.mul(product, other)
                shape = [product]
            step = _tools.intp_t(8)
            strides = [step] if len(shape) == 1 else [builder.mul(step, shape[1]), step]
            _arrays.populate_array(
                target,
                data=builder.inttoptr(word(builder, table, array.slot), target.data.type),
                shape=shape,
                strides=strides,
                itemsize=step,
                meminfo=None,
            )
            return target._getvalue()

        return signature, codegen

    return cast(Callable[[Integers], Any], intrinsic(fetch))


def _emitted(builder: Any, table: Any, length: Length) -> Any:
    factor, slot = length if isinstance(length, tuple) else (1, length)
    if slot is None:
        return _tools.intp_t(factor)
    value = word(builder, table, slot)
    return value if factor == 1 else builder.mul(value, _tools.intp_t(factor))
