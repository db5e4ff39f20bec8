"""How the runtime's own loops are compiled: once, for explicit signatures, and kept on disk.

Five things here work round numba as it is.

A cached function is taken for fresh as long as its *own* file is unchanged, although it contains
what it calls. So the cache of every function is stamped with the hash of all files of the runtime
that hold compiled code: an edit anywhere makes all of them stale.

Each function has a lock, under which one process compiles it while the others wait; different
functions compile in different processes at the same time. What lies in the cache is checked before
it is run (`codegen.numba_cache`).

A function that is handed to compiled code as an argument costs about 0.1 ms a call, in which numba
looks up its address. So addresses are looked up once and handed over as integers, and `at` turns
them back into functions inside.

A function is compiled apart from those that it calls, but for what is short
(`codegen.separate_compilation`), and loads with them.

Numba compiles or loads a function with an explicit signature when its module is imported. Here that
waits until somebody calls the function, asks for its address or compiles what calls it: a run loads
two thirds of what it imports.
"""

import hashlib
from collections.abc import Callable, Iterable
from contextlib import nullcontext
from pathlib import Path
from typing import Any, TypeVar, cast
from weakref import WeakSet

import numpy as np
import numpy.typing as npt
from numba import njit, types
from numba.core import cgutils
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.extending import intrinsic

from codegen.files.generated_modules import locked
from codegen.files.library_folders import LIBRARY, methods_folder
from codegen.numba_cache import checked_caches
from codegen.scalar_compiler import ScalarCompiler
from codegen.separate_compilation import give_interface

F = TypeVar("F", bound=Callable[..., Any])

_tools: Any = cgutils  # numba leaves these untyped
_Dispatcher: Any = CPUDispatcher

OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "fastmath": {"contract"}}
ADDRESSES = types.Array(types.int64, 1, "C")
# Counting references to arrays took a seventh of a run's time. What says nothing takes it over from
# what calls it. Nothing takes the entry from C, an eighth of a compilation.
_COUNTED: dict[str, Any] = {**OPTIONS, "_nrt": True, "no_cfunc_wrapper": True}
_BARE: dict[str, Any] = {**_COUNTED, "_nrt": False, "pipeline_class": ScalarCompiler}
_INSIDE: dict[str, Any] = {"no_cpython_wrapper": True}


def compiled(signature: Any) -> Callable[[F], F]:
    """Compile for one explicit signature, keep it on disk, divide as the hardware does.

    Nothing counts references: arrays belong to the caller, and what makes one does not compile.
    """
    return lambda function: _lazy(function, signature, _BARE, _Locked)


def allocating(signature: Any) -> Callable[[F], F]:
    """As `compiled`, for what makes arrays of its own: no part of the loop over steps."""
    return lambda function: _lazy(function, signature, _COUNTED, _Locked)


def unlocked(signature: Any) -> Callable[[F], F]:
    """As `compiled`; while it runs, other threads run Python: for what takes a good while."""
    return lambda function: _lazy(function, signature, {**_BARE, "nogil": True}, _Locked)


def addressed(signature: Any) -> Callable[[F], F]:
    """As `compiled`, for what compiled code alone calls, by its name or its address.

    Without a way in from Python it compiles in two thirds of the time, and loads in half.
    """
    return lambda function: _lazy(function, signature, {**_BARE, **_INSIDE}, _Addressed)


class _Locked(_Dispatcher):  # type: ignore[misc]
    """A function that one process at a time compiles or loads.

    Numba's own lock comes first: a thread that held the file and waited for numba would block
    another that holds numba and waits for the file.
    """

    def compile(self, signature: Any) -> Any:
        files = _cache_files(self)
        alone = locked(Path(f"{files._index_path}.lock")) if files else nullcontext()
        with global_compiler_lock, alone:
            entry = super().compile(signature)
            give_interface(self)
            return entry

    def result_for(self, kinds: tuple[Any, ...]) -> Any:
        """The result of its compilation for arguments of these types."""
        prepare(self)
        if kinds not in self.overloads:
            self.compile(kinds)
        return self.overloads[kinds]

    def get_call_template(self, arguments: Any, named: Any) -> Any:
        """Compile once for all integers: numba would once more for each constant argument."""
        unliteral: Any = types.unliteral
        positional = [unliteral(kind) for kind in arguments]
        keywords = {name: unliteral(kind) for name, kind in dict(named).items()}
        return super().get_call_template(positional, keywords)


class _Addressed(_Locked):
    """A function that has no way in from Python: numba would jump to nowhere."""

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        raise TypeError(
            f"{self.py_func.__module__}.{self.__name__} is called by compiled code alone: "
            "call it from a function of your own that numba compiles."
        )


class _Lazy(_Locked):
    """A function that is compiled, or loaded, when it is first needed.

    Attributes
    ----------
    signature
        The only one that it gets.
    prepared
        Its class from then on.
    """

    signature: Any
    prepared: type[_Locked]

    def prepare(self) -> None:
        """Compile or load it, unless another thread has done so."""
        with checked_caches():
            if not self.overloads:
                self.compile(self.signature)
                self.disable_compile()
            self.__class__ = self.prepared

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        self.prepare()
        return self(*arguments, **named)

    def get_call_template(self, arguments: Any, named: Any) -> Any:
        """The function as what compiled code calls, which is compiled now."""
        self.prepare()
        return self.get_call_template(arguments, named)


_lazy_functions: "WeakSet[_Lazy]" = WeakSet()


def compile_functions(module: str) -> None:
    """Compile or load the functions of a module that wait to be needed."""
    for function in [*_lazy_functions]:
        if function.__module__ == module:
            prepare(function)


def prepare(function: Any) -> None:
    """Compile or load a function that waits to be needed."""
    if isinstance(function, _Lazy):
        function.prepare()


def is_kept(function: Any) -> bool:
    """Whether a function is loaded, or its machine code lies in the cache, or there is no cache."""
    files = _cache_files(function)
    return not isinstance(function, _Lazy) or files is None or bool(files._load_index())


def inner(function: F) -> F:
    """Compile with the compiled functions that call it: it is neither loaded nor called alone."""
    return cast(F, _cached(function, **_BARE, **_INSIDE))


def inner_allocating(function: F) -> F:
    """As `inner`, for what makes arrays of its own: `allocating` functions alone call it."""
    return cast(F, _cached(function, **_COUNTED, **_INSIDE))


def closure(function: F) -> F:
    """As `inner`, for what closes over compiled functions, which is no part of a cache's key."""
    return cast(F, njit(**{**_BARE, "cache": False}, **_INSIDE)(function))


def inlined(function: F) -> F:
    """As `inner`, copied into every place of its use: for what is small and called in stages."""
    return cast(F, _cached(function, **_BARE, **_INSIDE, forceinline=True))


def fetched(function: F) -> F:
    """As `inlined`, for what answers with an array, which lies in a workspace."""
    return cast(F, _cached(function, **_COUNTED, **_INSIDE, forceinline=True))


def addresses(functions: Iterable[Any]) -> npt.NDArray[np.int64]:
    """Addresses of compiled functions, each of which has one signature."""
    return np.array([_address(function) for function in functions], dtype=np.int64)


def at(function_type: types.FunctionType, slot: int) -> Callable[[Any], Any]:
    """A function for compiled code that takes out of a table the function at an address.

    Nothing checks that it has the type; a table and its slots are defined side by side.
    """

    def fetch(typing_context: Any, table: Any) -> Any:
        signature = function_type(ADDRESSES)

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            array = context.make_array(signature.args[0])(context, builder, arguments[0])
            place = context.get_constant(types.intp, slot)
            number = builder.load(builder.gep(array.data, [place], inbounds=True))
            pointer = builder.inttoptr(number, _tools.voidptr_t)
            function = _tools.create_struct_proxy(function_type)(context, builder)
            function.jit_addr = pointer
            function.c_addr = pointer
            return function._getvalue()

        return signature, codegen

    return cast(Callable[[Any], Any], intrinsic(fetch))


def _address(function: Any) -> int:
    prepare(function)
    (result,) = function.overloads.values()
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


def _lazy(function: F, signature: Any, options: dict[str, Any], prepared: type[_Locked]) -> F:
    dispatcher: Any = _cached(function, **options)
    dispatcher.signature, dispatcher.prepared = signature, prepared
    dispatcher.__class__ = _Lazy
    _lazy_functions.add(dispatcher)
    return cast(F, dispatcher)


def _cached(function: Any, **options: Any) -> Any:
    """A dispatcher with a lock, whose cache depends on all compiled code of the runtime."""
    with checked_caches():
        dispatcher: Any = njit(**options)(function)
    if files := _cache_files(dispatcher):
        files._source_stamp = (files._source_stamp, _STAMP)
    dispatcher.__class__ = _Locked
    return dispatcher


def _cache_files(dispatcher: Any) -> Any:
    """Index and data of its cache; None where no folder can be written."""
    return getattr(dispatcher._cache, "_cache_file", None)


def _stamp() -> str:
    """Hash of what compiled code is made from: numerical rooms, methods, users of this module."""
    digest = hashlib.sha256()
    for path in sorted({*methods_folder().glob("*.py"), *LIBRARY.glob("runtime/**/*.py")}):
        text = path.read_bytes()
        if path.relative_to(LIBRARY).parts[1] in ROOMS or b"runtime.core.jit" in text:
            digest.update(text)
    return digest.hexdigest()


ROOMS = ("core", "linalg", "constraints", "singularity", "hybrid", "integrate")
_STAMP = _stamp()
