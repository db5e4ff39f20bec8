"""Arrays that compiled code borrows: they own nothing, and cost nothing.

A slice looks at its bounds, and where references are counted it counts them with atomic
instructions, about 20 ns a slice: more than a whole stage of a small mechanism. `view` makes the
same contiguous array without either. Its base must outlive it, which holds for workspaces: the
caller of the compiled function owns them.
"""

from collections.abc import Callable
from typing import Any, cast

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np import arrayobj

from runtime.core.array_types import tuple_type

_arrays: Any = arrayobj  # numba leaves these untyped
_tools: Any = cgutils


def open_array(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """The first argument of an intrinsic, which is an array, in generated code."""
    return _arrays.make_array(signature.args[0])(context, builder, arguments[0])


def borrowed_array(context: Any, builder: Any, result: Any, data: Any, shape: list[Any]) -> Any:
    """A contiguous array of type `result` at the pointer `data`, in generated code."""
    array = _arrays.make_array(result)(context, builder)
    size = context.get_abi_sizeof(context.get_data_type(result.dtype))
    item = context.get_constant(types.intp, size)
    strides = [item] if len(shape) == 1 else [builder.mul(item, shape[1]), item]
    _arrays.populate_array(
        array, data=data, shape=shape, strides=strides, itemsize=item, meminfo=None
    )
    return array._getvalue()


def word(builder: Any, table: Any, slot: int) -> Any:
    """The word in a slot of a table, in generated code."""
    place = _tools.intp_t(slot)
    return builder.load(builder.gep(table.data, [place], inbounds=True))


def pointer(context: Any, builder: Any, table: Any, slot: int, item: Any) -> Any:
    """The address in a slot of a table, as a pointer to numbers of type `item`."""
    kind = context.get_data_type(item).as_pointer()
    return builder.inttoptr(word(builder, table, slot), kind)


def _view(typing_context: Any, base: Any, start: Any, shape: Any) -> Any:
    """An array in a flat float64 or int64 one from element `start` on; bounds unchecked.

    `shape` is its length, or its numbers of rows and columns.
    """
    if not (isinstance(base, types.Array) and base.ndim == 1 and base.layout == "C"):
        return None
    pair = isinstance(shape, types.BaseTuple)
    result = types.Array(base.dtype, 2 if pair else 1, "C")
    signature = result(base, types.intp, tuple_type((types.intp,) * 2) if pair else types.intp)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = open_array(context, builder, signature, arguments)
        data = builder.gep(source.data, [arguments[1]], inbounds=True)
        shape = _tools.unpack_tuple(builder, arguments[2]) if pair else [arguments[2]]
        return borrowed_array(context, builder, signature.return_type, data, shape)

    return signature, codegen


view: Callable[[Any, int, int | tuple[int, int]], Any] = cast(Any, intrinsic(_view))
