"""Layout of a function table: one array of integers through which compiled code reaches a machine.

A table holds addresses of functions and of arrays, and a few numbers. It travels as `context` from
function to function in place of them all. A layout is the one declaration of a table: each line
allots a slot and answers with what compiled code takes out of it. The arrays of a run's table are
also attributes of `context` in compiled code: ``context.modes``.
"""

from collections.abc import Callable
from functools import reduce
from math import prod
from typing import Any, ClassVar, NamedTuple, cast

import numpy as np
from numba import extending, types
from numba.core import cgutils
from numba.core.typing import templates
from numba.extending import intrinsic

from runtime.core.array_types import IntegerMatrix, Integers, Matrix, Vector
from runtime.core.jit import ADDRESSES, at
from runtime.core.kernel_abi import KERNELS
from runtime.core.unowned_array_views import borrowed_array, open_array, pointer, word

_ALIGNED = 8  # layout: words of a cache line, in which an array of its own begins
_tools: Any = cgutils  # numba leaves these untyped
_extending: Any = extending
_AttributeTemplate: Any = templates.AttributeTemplate

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
        """Slot of a number, which compiled code reads as ``context[SLOT]``."""
        slot = self.slots[name] = self.size
        self.size += 1
        return slot

    def function(self, name: str, signature: Any) -> Callable[[Integers], Callable[..., Any]]:
        """Take the function `name` out of a table."""
        return at(types.FunctionType(signature), self.number(name))

    def floats(
        self, names: str, *lengths: Length, allotted: bool = True, flat: bool = True,
        item: Any = types.float64,
    ) -> Callable[[Integers], Vector]:  # fmt: skip
        """Take an array of float64 out of a table: flat, or with `lengths` as its shape.

        One that is not `allotted` is made elsewhere. Of several `names` the first is taken.
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
        """The array `matrix`, flat, by a name of its own."""
        return self._fetcher(name, self.arrays[matrix]._replace(flat=True))

    def _fetcher(self, name: str, array: ArraySlot) -> Callable[[Integers], Any]:
        """An intrinsic that makes an array, not owned, of what lies at an address in a table."""

        def fetch(typing_context: Any, context: Any) -> Any:
            result = types.Array(array.item, 1 if array.flat else len(array.lengths), "C")
            signature = result(context)

            def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
                table = open_array(context, builder, signature, arguments)
                shape = [_length(builder, table, *length) for length in array.lengths]
                if array.flat:
                    shape = [reduce(builder.mul, shape)]
                data = pointer(context, builder, table, array.slot, array.item)
                return borrowed_array(context, builder, signature.return_type, data, shape)

            return signature, codegen

        if self.attributes:
            declare_attribute(name, fetch)
        return cast(Callable[[Integers], Any], intrinsic(fetch))

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


@_extending.infer_getattr
class _Attributes(_AttributeTemplate):  # type: ignore[misc]
    """The arrays that a run's table has as attributes, in compiled code: name → type."""

    key = types.Array
    found: ClassVar[dict[str, Any]] = {}

    def generic_resolve(self, array: Any, name: str) -> Any:
        return self.found.get(name) if array == ADDRESSES else None


def declare_attribute(name: str, fetch: Any, *numbers: int) -> None:
    """Let ``context.name`` in compiled code be what the intrinsic of `fetch` takes out of a table.

    `numbers` are the intrinsic's arguments behind the table.
    """
    signature, codegen = fetch(None, ADDRESSES, *[types.intp] * len(numbers))
    _Attributes.found[name] = signature.return_type

    def lower(context: Any, builder: Any, kind: Any, table: Any) -> Any:
        constants = [context.get_constant(types.intp, number) for number in numbers]
        return codegen(context, builder, signature, [table, *constants])

    _extending.lower_getattr(ADDRESSES, name)(lower)


class _Allotted(dict[str, Any]):
    """Arrays of a table by name."""

    def __init__(
        self, layout: TableLayout, table: Integers, block: Integers, starts: dict[str, int]
    ) -> None:
        self.layout, self.table, self.block, self.starts = layout, table, block, starts

    def __missing__(self, name: str) -> Any:
        array, start = self.layout.arrays[name], self.starts[name]
        shape = [f if count is None else f * int(self.table[count]) for f, count in array.lengths]
        words = self.block[start : start + prod(shape)]
        words = words.view(np.float64) if array.item is types.float64 else words
        self[name] = words = words if array.flat else words.reshape(shape)
        return words


def _length(builder: Any, table: Any, factor: int, count: int | None) -> Any:
    if count is None:
        return _tools.intp_t(factor)
    value = word(builder, table, count)
    return value if factor == 1 else builder.mul(value, _tools.intp_t(factor))
