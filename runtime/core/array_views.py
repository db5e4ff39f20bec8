"""Views of workspace arrays that cost nothing inside compiled code.

A slice looks at its bounds, and where references are counted it counts them with atomic
instructions, about 20 ns a slice: more than a whole stage of a small mechanism. `view` makes the
same contiguous array without either. Its base must outlive it, which holds for workspaces: the
caller of the compiled function owns them.
"""

from collections.abc import Callable
from typing import Any, cast

from numba import types
from numba.extending import intrinsic
from numba.np import arrayobj

_arrays: Any = arrayobj


def _view(typing_context: Any, base: Any, start: Any, length: Any) -> Any:
    """Elements `start` to `start + length` of a contiguous one-dimensional array, not owned.

    No bounds are checked. Works for float64 and int64 arrays.
    """
    if not (isinstance(base, types.Array) and base.ndim == 1 and base.layout == "C"):
        return None
    result = types.Array(base.dtype, 1, "C")
    signature = result(base, types.intp, types.intp)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = _arrays.make_array(signature.args[0])(context, builder, arguments[0])
        target = _arrays.make_array(signature.return_type)(context, builder)
        size = context.get_abi_sizeof(context.get_data_type(signature.return_type.dtype))
        item = context.get_constant(types.intp, size)
        _arrays.populate_array(
            target,
            data=builder.gep(source.data, [arguments[1]], inbounds=True),
            shape=[arguments[2]],
            strides=[item],
            itemsize=item,
            meminfo=None,
        )
        return target._getvalue()

    return signature, codegen


def _at(item: Any, dimensions: int) -> Any:
    """An intrinsic that makes an array, not owned, of what lies at an address in a table."""

    def fetch(typing_context: Any, table: Any, slot: Any, *lengths: Any) -> Any:
        result = types.Array(item, dimensions, "C")
        signature = result(table, types.intp, *([types.intp] * dimensions))

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            source = _arrays.make_array(signature.args[0])(context, builder, arguments[0])
            target = _arrays.make_array(signature.return_type)(context, builder)
            number = builder.load(builder.gep(source.data, [arguments[1]], inbounds=True))
            size = context.get_abi_sizeof(context.get_data_type(item))
            step = context.get_constant(types.intp, size)
            shape = list(arguments[2:])
            strides = [step] if dimensions == 1 else [builder.mul(step, shape[1]), step]
            _arrays.populate_array(
                target,
                data=builder.inttoptr(number, target.data.type),
                shape=shape,
                strides=strides,
                itemsize=step,
                meminfo=None,
            )
            return target._getvalue()

        return signature, codegen

    if dimensions == 1:

        def one(typing_context: Any, table: Any, slot: Any, length: Any) -> Any:
            return fetch(typing_context, table, slot, length)

        return intrinsic(one)

    def two(typing_context: Any, table: Any, slot: Any, rows: Any, columns: Any) -> Any:
        return fetch(typing_context, table, slot, rows, columns)

    return intrinsic(two)


view: Callable[[Any, int, int], Any] = cast(Any, intrinsic(_view))
floats_at: Callable[[Any, int, int], Any] = _at(types.float64, 1)
integers_at: Callable[[Any, int, int], Any] = _at(types.int64, 1)
matrix_at: Callable[[Any, int, int, int], Any] = _at(types.float64, 2)
integer_matrix_at: Callable[[Any, int, int, int], Any] = _at(types.int64, 2)
