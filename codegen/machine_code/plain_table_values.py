"""Arrays that compiled code takes out of a table, by what numba's documentation has: `carray`."""

from collections.abc import Sequence
from typing import Any

import numba
from numba import extending, types
from numba.extending import intrinsic

_extending: Any = extending  # numba leaves its names untyped
_types: Any = types
_carray: Any = numba.carray  # type: ignore[attr-defined]
_njit: Any = numba.njit
_ADDRESSES = _types.Array(types.int64, 1, "C")


def _pointer_to(item: Any) -> Any:
    """What makes a pointer to numbers of type `item` of an address."""

    def fetch(typing_context: Any, address: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

        return _types.CPointer(item)(types.int64), codegen

    return intrinsic(fetch)


_POINTERS = {item: _pointer_to(item) for item in (types.float64, types.int64)}
_to_floats, _to_integers = _POINTERS[types.float64], _POINTERS[types.int64]


def _declare_attribute(name: str, fetch: Any, *numbers: int) -> None:
    def attribute(table):  # type: ignore[no-untyped-def]
        if table != _ADDRESSES:
            return None
        if numbers:
            (number,) = numbers
            return lambda table: fetch(table, number)
        return lambda table: fetch(table)  # noqa: PLW0108 (numba asks for the name)

    _extending.overload_attribute(_types.Array, name)(attribute)


def array_at(
    slot: int, item: Any, lengths: Sequence[tuple[int, int | None]], flat: bool,
    attributes: Sequence[str] = (),
) -> Any:  # fmt: skip
    """As `table_values.array_at`."""
    pointer = _POINTERS[item]
    factors = [factor for factor, _ in lengths] + [1]
    slots = [-1 if count is None else count for _, count in lengths] + [-1]
    first, second, of_first, of_second = factors[0], factors[1], slots[0], slots[1]
    is_vector = flat or len(lengths) == 1

    @_njit
    def vector(table):  # type: ignore[no-untyped-def]
        size = first if of_first < 0 else first * table[of_first]
        size *= second if of_second < 0 else second * table[of_second]
        return _carray(pointer(table[slot]), (size,))

    @_njit
    def matrix(table):  # type: ignore[no-untyped-def]
        rows = first if of_first < 0 else first * table[of_first]
        columns = second if of_second < 0 else second * table[of_second]
        return _carray(pointer(table[slot]), (rows, columns))

    fetch = vector if is_vector else matrix
    for name in attributes:
        _declare_attribute(name, fetch)
    return fetch


def row_at(slot: int, count: int, factor: int, part: int | None, **attributes: int) -> Any:
    """As `table_values.row_at`."""
    parts, offset = (factor, 0) if part is None else (1, part)

    @_njit
    def fetch(table, index):  # type: ignore[no-untyped-def]
        length = table[count]
        start = length * (factor * index + offset)
        return _carray(_to_floats(table[slot] + 8 * start), (parts * length,))

    for name, number in attributes.items():
        _declare_attribute(name, fetch, number)
    return fetch
