"""How the runtime's own loops are compiled: once, for explicit signatures, and kept on disk.

A cached function contains what it calls. So machine code lies in a folder that is named by the
hash of all files of the runtime that hold compiled code: after an edit anywhere it lies elsewhere.

A function that is handed to compiled code as an argument costs about 0.1 ms a call, in which numba
looks up its address. So addresses are looked up once and handed over as integers, and `at` turns
them back into functions inside.

A function is compiled apart from those that it calls, but for what is short
(`codegen.machine_code.separate_compilation`), and loads with them.
"""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt
from numba import types

from codegen.files.library_folders import LIBRARY, methods_folder
from codegen.machine_code.compiled_functions import (
    address_of,
    compiled_function,
    is_kept,
    own_folders,
    prepare,
)
from codegen.machine_code.table_values import ADDRESSES, function_at

__all__ = ["ADDRESSES", "at", "is_kept", "prepare"]

F = TypeVar("F", bound=Callable[..., Any])

# Counting references to arrays took a seventh of a run's time. A function without the
# flag takes that of its caller. No entry from C is compiled: it took an eighth of a compilation.
_COUNTED: dict[str, Any] = {
    "error_model": "numpy", "fastmath": {"contract"}, "_nrt": True, "no_cfunc_wrapper": True
}  # fmt: skip
_BARE: dict[str, Any] = {**_COUNTED, "_nrt": False}
_INSIDE: dict[str, Any] = {"no_cpython_wrapper": True}


def compiled(signature: Any) -> Callable[[F], F]:
    """Compile for one explicit signature, keep it on disk, divide as the hardware does.

    Nothing counts references: arrays belong to the caller, and what makes one does not compile.
    """
    return lambda function: _made(function, signature, _BARE)


def allocating(signature: Any) -> Callable[[F], F]:
    """As `compiled`, for what makes arrays of its own: no part of the loop over steps."""
    return lambda function: _made(function, signature, _COUNTED)


def unlocked(signature: Any) -> Callable[[F], F]:
    """As `compiled`; while it runs, other threads run Python: for what takes a good while."""
    return lambda function: _made(function, signature, {**_BARE, "nogil": True})


def addressed(signature: Any) -> Callable[[F], F]:
    """As `compiled`, for what compiled code alone calls, by its name or its address.

    Without a way in from Python it compiles in two thirds of the time, and loads in half.
    """
    return lambda function: _made(function, signature, {**_BARE, **_INSIDE}, from_python=False)


def inner(function: F) -> F:
    """Compile with the compiled functions that call it: it is neither loaded nor called alone."""
    return _made(function, None, {**_BARE, **_INSIDE})


def inner_allocating(function: F) -> F:
    """As `inner`, for what makes arrays of its own: `allocating` functions alone call it."""
    return _made(function, None, {**_COUNTED, **_INSIDE})


def closure(function: F) -> F:
    """As `inner`, for what closes over compiled functions, which no folder's name tells apart."""
    return _made(function, None, {**_BARE, **_INSIDE}, is_kept=False)


def inlined(function: F) -> F:
    """As `inner`, copied into every place of its use: for what is small and called in stages."""
    return _made(function, None, {**_BARE, **_INSIDE, "forceinline": True})


def fetched(function: F) -> F:
    """As `inlined`, for what answers with an array, which lies in a workspace."""
    return _made(function, None, {**_COUNTED, **_INSIDE, "forceinline": True})


def addresses(functions: Iterable[Any]) -> npt.NDArray[np.int64]:
    """Addresses of compiled functions, each of which has one signature, and of kernels."""
    found = [getattr(function, "address", None) or address_of(function) for function in functions]
    return np.array(found, dtype=np.int64)


def at(function_type: types.FunctionType, slot: int) -> Callable[[Any], Any]:
    """A function for compiled code that takes out of a table the function at an address.

    Nothing checks that it has the type; a table and its slots are defined side by side.
    """
    return cast(Callable[[Any], Any], function_at(function_type, slot))


def _made(
    function: F, signature: Any, options: dict[str, Any], from_python: bool = True,
    is_kept: bool = True,
) -> F:  # fmt: skip
    folders = _FOLDERS if is_kept else None
    return cast(F, compiled_function(function, signature, options, folders, from_python))


def sources() -> dict[Path, bytes]:
    """What compiled code is made from: numerical rooms, methods, users of this module, constants.

    Returns file → content.
    """
    files = sorted({*methods_folder().glob("*.py"), *LIBRARY.glob("runtime/**/*.py")})
    places = {path: path.relative_to(LIBRARY).parts for path in files}
    texts = {path: path.read_bytes() for path in files}
    return {
        path: text for path, text in texts.items()
        if places[path][1] in ROOMS or "/".join(places[path][1:]) in _OF_CONSTANTS
        or b"runtime.core.jit" in text
    }  # fmt: skip


ROOMS = ("core", "linalg", "constraints", "singularity", "hybrid", "integrate")
_OF_CONSTANTS = ("assembly/joint_closing.py", "results/samples.py", "sweeps/ensemble_arrays.py")
_FOLDERS = own_folders(LIBRARY / "runtime", [*sources().values()])
