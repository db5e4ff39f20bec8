"""Calls from Python of machine code at an address: one compiled function for each signature.

Kernels have no entries from Python of their own, which nearly no call needs.
"""

from functools import cache
from pathlib import Path
from typing import Any

from numba import types
from numba.extending import intrinsic

from codegen.machine_code.compiled_functions import compiled_function, own_folder, prepare
from codegen.machine_code.table_values import function_value

_types: Any = types  # numba leaves its names untyped
_OPTIONS = {"error_model": "numpy", "_nrt": False, "no_cfunc_wrapper": True}


@cache
def caller(signature: Any, name: str = "a kernel") -> Any:
    """What calls functions of a signature, given the address; TypeError for another result."""
    if (kind := signature.return_type) not in _CALLERS:
        known = ", ".join(map(str, _CALLERS))
        raise TypeError(f"{name} returns {kind}; Python calls kernels that return {known}.")
    packed = _types.BaseTuple.from_types(signature.args)
    folder = own_folder(Path(__file__).parent, [])
    made = compiled_function(_CALLERS[kind], kind(types.int64, packed), _OPTIONS, folder)
    prepare(made)  # now: numba packs the arguments of a first call before it compiles
    return made


def _function_at(result: Any) -> Any:
    """For compiled code: the function with this result at an address, for a tuple of arguments."""

    def fetch(typing_context: Any, address: Any, arguments: Any) -> Any:
        kind = _types.FunctionType(result(*arguments.types))

        def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return function_value(context, builder, kind, values[0])

        return kind(address, arguments), codegen

    return intrinsic(fetch)


_nothing_at, _integer_at, _number_at = map(_function_at, (types.none, types.int64, types.float64))


def _call_for_nothing(address: Any, *arguments: Any) -> None:
    _nothing_at(address, arguments)(*arguments)


def _call_for_integer(address: Any, *arguments: Any) -> Any:
    return _integer_at(address, arguments)(*arguments)


def _call_for_number(address: Any, *arguments: Any) -> Any:
    return _number_at(address, arguments)(*arguments)


_CALLERS = {
    types.none: _call_for_nothing,
    types.int64: _call_for_integer,
    types.float64: _call_for_number,
}
