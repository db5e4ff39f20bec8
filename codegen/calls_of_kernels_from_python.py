"""Kernels are compiled without entries from Python and from C, which nearly no call needs.

Numba compiles both with every function, in up to two thirds of a small kernel's time. Compiled code
calls kernels by their addresses. Python calls them through one compiled function for each
signature, which takes the address and is made when it is first needed; all scenes share it. An
entry from C is made for a kernel that is handed to compiled code as a value.
"""

import inspect
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

from codegen.kernel_compiler.numba_pipeline import KernelCompiler
from codegen.numba_cache import checked_caches
from codegen.termination_signals import SignalDeferral

_numba: Any = numba  # its types are for its own use
_types: Any = types
_tools: Any = cgutils
_Dispatcher: Any = CPUDispatcher
_Array: Any = np.ndarray

_OPTIONS = re.compile(r"^OPTIONS = \{.*(?=\}$)", re.MULTILINE)  # of a generated text
_WITHOUT = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
KERNEL_OPTIONS = {**_WITHOUT, "pipeline_class": KernelCompiler}
"""What numba gets besides the options of the text, which knows them by this name."""

_CALLER = {"cache": True, "error_model": "numpy", "_nrt": False, "no_cfunc_wrapper": True}


def with_kernel_options(text: str) -> str:
    """The text of a module whose kernels get KERNEL_OPTIONS; the lines keep their numbers."""
    return _OPTIONS.sub(lambda options: f"{options.group()}, **KERNEL_OPTIONS", text, count=1)


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
                raise TypeError(self._mismatch(arguments))
        try:
            return caller(address, *arguments)
        except TypeError as error:
            raise TypeError(self._mismatch(arguments)) from error

    def _mismatch(self, arguments: tuple[Any, ...]) -> str:
        """A sentence: the parameters of the kernel, and what was given in their place."""
        kinds = self.nopython_signatures[0].args
        names = inspect.signature(self.py_func).parameters
        wanted = ", ".join(f"{name}: {kind}" for name, kind in zip(names, kinds, strict=True))
        given = ", ".join(map(_kind, arguments)) or "nothing"
        return f"{self.__name__}({wanted}) is called with ({given})."

    @cached_property
    def _entry(self) -> tuple[Any, int]:
        """What calls functions of its signature, and its address."""
        if len(self.overloads) != 1:
            raise TypeError(f"{self.py_func.__module__}.{self.__name__} has no one signature.")
        (result,) = self.overloads.values()
        if (kind := result.signature.return_type) not in _CALLERS:
            known = ", ".join(map(str, _CALLERS))
            raise TypeError(
                f"{self.py_func.__module__}.{self.__name__} returns {kind}; Python calls kernels "
                f"that return {known}."
            )
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


def _kind(argument: Any) -> str:
    """The kind of an argument, much as numba writes it."""
    if not isinstance(argument, _Array):
        return type(argument).__name__
    order = "C" if argument.flags.c_contiguous else "F" if argument.flags.f_contiguous else "A"
    more = "" if argument.flags.writeable else ", read-only"
    if not argument.dtype.isnative:
        more += ", not in the machine's order of bytes"
    return f"array({argument.dtype.name}, {argument.ndim}d, {order}{more})"


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
