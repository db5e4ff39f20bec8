"""Functions, arrays and records that compiled code takes out of a table of addresses.

Arrays are borrowed: they own nothing, and their base must outlive them, which holds for tables and
workspaces, since the caller of the compiled code owns them. A slice looks at its bounds, and where
references are counted it counts them with atomic instructions, about 20 ns a slice: more than a
whole stage of a small mechanism.
"""

from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any

import numpy as np
from numba import extending, types
from numba.extending import intrinsic

from codegen.machine_code.undocumented_names import PLAIN, AttributeTemplate

_extending: Any = extending  # numba leaves its names untyped
_types: Any = types

ADDRESSES = _types.Array(types.int64, 1, "C")
"""The type of a table."""

Lengths = Sequence[tuple[int, int | None]]
"""Of an array, a factor and the slot that holds the other; or None, where that is 1."""


def _taken(result: Any, read: Callable[[Any, Any, Any], Any]) -> Any:
    """What an intrinsic takes out of a table, by generated code."""

    def fetch(typing_context: Any, table: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return read(context, builder, arguments)

        return result(ADDRESSES), codegen

    return fetch


def function_at(kind: Any, slot: int) -> Any:
    """What takes the function at an address out of a table."""

    def read(context: Any, builder: Any, arguments: Any) -> Any:
        """Nothing checks that it has this type."""
        address = _word(context, builder, arguments, slot)
        function = context.make_helper(builder, kind)
        function.jit_addr = builder.inttoptr(address, context.get_value_type(types.voidptr))
        function.c_addr = function.jit_addr
        return function._getvalue()

    return intrinsic(_taken(kind, read))


def record_at(record: Any, slot: int) -> Any:
    """What takes a record out of a table."""

    def read(context: Any, builder: Any, arguments: Any) -> Any:
        address = _word(context, builder, arguments, slot)
        return builder.inttoptr(address, context.get_value_type(record))

    return intrinsic(_taken(record, read))


def array_at(
    slot: int, item: Any, lengths: Lengths, flat: bool, attributes: Sequence[str] = ()
) -> Any:
    """What takes an array out of a table, which may also be an attribute of tables."""
    result = _types.Array(item, 1 if flat else len(lengths), "C")

    def read(context: Any, builder: Any, arguments: Any) -> Any:
        shape = [_length(context, builder, arguments, *length) for length in lengths]
        if flat:
            shape = [reduce(builder.mul, shape)]
        data = _pointer(context, builder, arguments, slot, item)
        return _borrowed(context, builder, result, data, shape)

    fetch = _taken(result, read)
    for name in attributes:
        _declare_attribute(name, fetch)
    return intrinsic(fetch)


def row_at(slot: int, count: int, factor: int, part: int | None, **attributes: int) -> Any:
    """What takes a row by its number out of an array of float64 in a table, or a part of it.

    Rows have `factor` parts, each as long as the number in slot `count`. The rows named become
    attributes of tables.
    """

    def fetch(typing_context: Any, table: Any, index: Any) -> Any:
        result = _types.Array(types.float64, 1, "C")

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            length = _word(context, builder, arguments, count)
            row = builder.mul(length, context.get_constant(types.intp, factor))
            start = builder.mul(arguments[1], row)
            if part:
                start = builder.add(start, length)
            base = _pointer(context, builder, arguments, slot, types.float64)
            data = builder.gep(base, [start], inbounds=True)
            shape = [row if part is None else length]
            return _borrowed(context, builder, result, data, shape)

        return result(table, types.intp), codegen

    for name, number in attributes.items():
        _declare_attribute(name, fetch, number)
    return intrinsic(fetch)


def _view(typing_context: Any, base: Any, start: Any, shape: Any) -> Any:
    """An array in a flat one from `start` on, unchecked; `shape`: length, or rows and columns."""
    if not (isinstance(base, _types.Array) and base.ndim == 1 and base.layout == "C"):
        return None
    pair = isinstance(shape, _types.BaseTuple)
    result = _types.Array(base.dtype, 2 if pair else 1, "C")
    lengths = _types.UniTuple(types.intp, 2) if pair else types.intp

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = context.make_array(base)(context, builder, arguments[0])
        data = builder.gep(source.data, [arguments[1]], inbounds=True)
        places = (0, 1) if pair else ()
        shape = [builder.extract_value(arguments[2], k) for k in places] or [arguments[2]]
        return _borrowed(context, builder, result, data, shape)

    return result(base, types.intp, lengths), codegen


view: Any = intrinsic(_view)


_attributes: dict[str, Any] = {}  # of tables, in compiled code: name → type

if not PLAIN:

    @_extending.infer_getattr
    class _Attributes(AttributeTemplate):  # type: ignore[misc]
        """What numba asks for the type of an attribute."""

        key = types.Array

        def generic_resolve(self, array: Any, name: str) -> Any:
            return _attributes.get(name) if array == ADDRESSES else None


def _declare_attribute(name: str, fetch: Any, *numbers: int) -> None:
    """Let ``table.name`` in compiled code be what the intrinsic of `fetch` takes out of a table."""
    if name in _attributes or hasattr(np.ndarray, name):
        raise ValueError(f"context.{name} is taken: choose another name")
    signature, codegen = fetch(None, ADDRESSES, *[types.intp] * len(numbers))
    _attributes[name] = signature.return_type
    if PLAIN:
        _declare_plainly(name, intrinsic(fetch), *numbers)
        return

    def lower(context: Any, builder: Any, kind: Any, table: Any) -> Any:
        constants = [context.get_constant(types.intp, number) for number in numbers]
        return codegen(context, builder, signature, [table, *constants])

    _extending.lower_getattr(ADDRESSES, name)(lower)


def _declare_plainly(name: str, take: Any, number: int | None = None) -> None:
    """As numba's documentation has it: each attribute is a function of its own to compile."""

    def attribute(table):  # type: ignore[no-untyped-def]
        if table != ADDRESSES:
            return None
        if number is None:
            return lambda table: take(table)  # noqa: PLW0108 (numba asks for the name)
        return lambda table: take(table, number)

    _extending.overload_attribute(_types.Array, name)(attribute)


def _word(context: Any, builder: Any, arguments: Any, slot: int) -> Any:
    """The word in a slot of the first argument, a table."""
    table = context.make_array(ADDRESSES)(context, builder, arguments[0])
    place = context.get_constant(types.intp, slot)
    return builder.load(builder.gep(table.data, [place], inbounds=True))


def _length(context: Any, builder: Any, arguments: Any, factor: int, count: int | None) -> Any:
    if count is None:
        return context.get_constant(types.intp, factor)
    value = _word(context, builder, arguments, count)
    return value if factor == 1 else builder.mul(value, context.get_constant(types.intp, factor))


def _pointer(context: Any, builder: Any, arguments: Any, slot: int, item: Any) -> Any:
    """The address in a slot of a table, as a pointer to numbers of type `item`."""
    kind = context.get_data_type(item).as_pointer()
    return builder.inttoptr(_word(context, builder, arguments, slot), kind)


def _borrowed(context: Any, builder: Any, result: Any, data: Any, shape: list[Any]) -> Any:
    """A contiguous array of type `result` at the pointer `data`."""
    array = context.make_array(result)(context, builder)
    item = context.get_constant(
        types.intp, context.get_abi_sizeof(context.get_data_type(result.dtype))
    )
    strides = [item] if len(shape) == 1 else [builder.mul(item, shape[1]), item]
    context.populate_array(
        array, data=data, shape=shape, strides=strides, itemsize=item, meminfo=None
    )
    return array._getvalue()
