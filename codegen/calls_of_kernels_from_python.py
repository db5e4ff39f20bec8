"""Kernels are compiled without entries from Python and from C, which nearly no call needs.

Numba compiles both with every function, in up to two thirds of a small kernel's time. Compiled code
calls kernels by their addresses. Python calls them through one compiled function for each
signature, which takes the address and is made when it is first needed; all scenes share it. An
entry from C is made for a kernel that is handed to compiled code as a value.
"""

import re
from collections.abc import Iterable
from functools import cache, cached_property
from typing import Any

import numba
import numpy as np
from numba import types
from numba.core import cgutils
from numba.core.registry import CPUDispatcher
from numba.extending import intrinsic

from codegen.numba_cache import checked_caches
from codegen.termination_signals import SignalDeferral

_numba: Any = numba  # its types are for its own use
_types: Any = types
_tools: Any = cgutils
_Dispatcher: Any = CPUDispatcher
_Array: Any = np.ndarray

_OPTIONS = re.compile(r"^OPTIONS = \{.*(?=\}$)", re.MULTILINE)  # of a generated text
_WITHOUT = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
_CALLER = {"cache": True, "error_model": "numpy", "_nrt": False, "no_cfunc_wrapper": True}


def without_entries(text: str) -> str:
    """The text of a module whose kernels have no entries; the lines keep their numbers."""
    more = "".join(f', "{name}": {value}' for name, value in _WITHOUT.items())
    return _OPTIONS.sub(lambda options: options.group() + more, text, count=1)


def give_entries(functions: Iterable[Any]) -> None:
    """Let Python call those of the functions that were compiled without entries."""
    for function in functions:
        if type(function) is _Dispatcher and _WITHOUT.items() <= function.targetoptions.items():
            function.__class__ = KernelWithoutEntries


class KernelWithoutEntries(_Dispatcher):  # type: ignore[misc]
    """A compiled kernel that is called through its address."""

    def __call__(self, *arguments: Any) -> Any:
        """Call it from Python; TypeError where the arguments are not those of its signature."""
        caller, address = self._entry
        for argument in arguments:  # numba sees no order of bytes in what is packed for a caller
            if isinstance(argument, _Array) and not argument.dtype.isnative:
                raise TypeError(f"{self.__name__}: {argument.dtype} is not in the machine's order.")
        return caller(address, *arguments)

    @cached_property
    def _entry(self) -> tuple[Any, int]:
        """What calls functions of its signature, and its address."""
        if len(self.overloads) != 1:
            raise TypeError(f"{self.py_func.__module__}.{self.__name__} has no one signature.")
        (result,) = self.overloads.values()
        address = result.library.get_pointer_to_function(result.fndesc.llvm_func_name)
        return _caller(result.signature), int(address)

    def __wrapper_address__(self) -> int:
        """The address of an entry from C; numba asks for it where a kernel is a value."""
        return int(self._entry_from_c.address)

    @cached_property
    def _entry_from_c(self) -> Any:
        (result,) = self.overloads.values()
        with SignalDeferral(in_commands=False):  # LLVM would lose an interrupt
            return _numba.cfunc(result.signature, error_model="numpy")(self.py_func)


@cache
def _caller(signature: Any) -> Any:
    """What calls functions of a signature: nothing else, and not with other arguments."""
    function = _CALLERS[signature.return_type]
    packed = _types.BaseTuple.from_types(signature.args)
    with checked_caches():
        caller = _numba.njit(**_CALLER)(function)
        caller.compile(signature.return_type(types.int64, packed))
    caller.disable_compile()
    return caller


def _function_at(result: Any) -> Any:
    """For compiled code: the function with this result at an address, for a tuple of arguments."""

    def fetch(typing_context: Any, address: Any, arguments: Any) -> Any:
        function_type = types.FunctionType(result(*arguments.types))

        def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            pointer = builder.inttoptr(values[0], _tools.voidptr_t)
            function = _tools.create_struct_proxy(function_type)(context, builder)
            function.jit_addr = pointer
            function.c_addr = pointer
            return function._getvalue()

        return function_type(address, arguments), codegen

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
