"""What is used of numba beyond its documentation: every name, what for, and what it gains.

Only this package imports `numba.core`, `numba.np` or `llvmlite`, and only this module what the
documentation of either lacks. `LINKWRIGHT_NUMBA=plain` uses none of it but the last three rows,
with the same numbers: a way to go on with a numba that no longer has the others, until this table
is brought up to date.
"""

import os
from typing import Any, NamedTuple

__all__ = ["PLAIN", "TABLE", "AttributeTemplate", "CodeLibrary", "CpuCodegen", "Dispatcher"]
__all__ += ["FunctionCache", "FunctionIdentity", "UserProvidedCacheLocator", "event"]
__all__ += ["global_compiler_lock", "rtsys"]

PLAIN = os.environ.get("LINKWRIGHT_NUMBA") == "plain"
"""Whether numba is used as its documentation says."""

if PLAIN:
    Dispatcher: Any = object
    FunctionCache: Any = object
    UserProvidedCacheLocator: Any = object
    CodeLibrary: Any = object
    AttributeTemplate: Any = object
    CpuCodegen: Any = None
    FunctionIdentity: Any = None
    event: Any = None
    global_compiler_lock: Any = None
    rtsys: Any = None
else:
    from numba.core import event
    from numba.core.bytecode import FunctionIdentity
    from numba.core.caching import FunctionCache, UserProvidedCacheLocator
    from numba.core.codegen import JITCodeLibrary as CodeLibrary
    from numba.core.codegen import JITCPUCodegen as CpuCodegen
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.registry import CPUDispatcher as Dispatcher
    from numba.core.runtime import rtsys  # type: ignore[attr-defined]
    from numba.core.typing.templates import AttributeTemplate


class Name(NamedTuple):
    """What is used beyond the documentation.

    Attributes
    ----------
    names
        The name of a module or class, with its attributes behind it.
    purpose
        What it is for.
    gain
        What it gains, measured on a four-bar's first result unless another thing is named.
    without
        What happens without it.
    """

    names: str
    purpose: str
    gain: str
    without: str


TABLE = (
    Name(
        "numba.core.registry.CPUDispatcher: __init__, _cache, _can_compile, _compile_for_args, "
        "compile, disable_compile, get_call_template, overloads",
        "functions that compile or load when they are needed, one process at a time",
        "a run loads two thirds of what it imports; five cold processes take 30 s, not 115 s",
        "what is imported compiles; processes compile the same thing at once",
    ),
    Name(
        "numba.core.caching.FunctionCache: _load_overload, save_overload, _cache_file, "
        "_index_path, cache_path",
        "loading without numba's types of NumPy; a damaged file or a full disk is no error",
        "a quarter of the start of a process that compiles nothing",
        "slower starts; a file that was cut short ends a run",
    ),
    Name(
        "numba.core.caching.UserProvidedCacheLocator: get_cache_path, ensure_cache_path",
        "machine code that an administrator has compiled, in a folder that is only read",
        "20 s of each process of a user who can write nowhere",
        "numba reads no folder into which it cannot write",
    ),
    Name(
        "numba.core.runtime.rtsys: initialize",
        "symbols that loaded machine code refers to",
        "as the row before",
        "as the row before",
    ),
    Name(
        "numba.core.codegen.JITCodeLibrary: finalize, serialize_using_object_code, _unserialize, "
        "_get_module_for_linking, _final_module, _finalize_final_module, _reload_init, "
        "_set_compiled_object, _shared_module, enable_object_caching, get_pointer_to_function",
        "separate compilation: callers link to the machine code of long functions",
        "two thirds of the instructions that LLVM would optimize; half of what a library takes to "
        "load",
        "LLVM optimizes each instruction of the loop three times",
    ),
    Name(
        "numba.core.codegen.JITCPUCodegen: _library_class, _engine, _defined_symbols, "
        "create_library; of a result: library, fndesc.llvm_func_name, reload_init, signature",
        "the same; _library_class is replaced while a function of ours compiles",
        "as the row before",
        "as the row before",
    ),
    Name(
        "numba.core.bytecode.FunctionIdentity: _unique_ids",
        "numbers of functions that no other process gives; replaced at the start and after a fork",
        "none",
        "the linker takes closures of one name that two processes compiled for each other",
    ),
    Name(
        "of llvmlite.ir: function.blocks, which is reordered; of values: constant, opname",
        "kernels in LLVM's language, with blocks in the order in which they begin",
        "a kernel is translated in a sixth of the time that numba takes",
        "numba compiles kernels, as in the plain way",
    ),
    Name(
        "numba.core.compiler_lock.global_compiler_lock",
        "the order of two locks: numba's first, then the file's",
        "none",
        "two threads may wait for each other",
    ),
    Name(
        "numba.core.event: Listener, install_listener",
        "the bar of functions that are compiled",
        "none",
        "a person who waits sees nothing",
    ),
    Name(
        "options of njit: _nrt, no_cpython_wrapper, no_cfunc_wrapper, forceinline",
        "arrays without counted references; no entries from Python or C that nobody calls",
        "a seventh of a run; a third of compiling what compiled code alone calls, and an eighth",
        "slower runs and compilation",
    ),
    Name(
        "numba.core.typing.templates.AttributeTemplate; numba.extending: infer_getattr, "
        "lower_getattr",
        "arrays of a table as its attributes",
        "each attribute would be a function of its own to compile",
        "`numba.extending.overload_attribute`, which plain has",
    ),
    Name(
        "of a compiled function: overloads, library.get_pointer_to_function, "
        "fndesc.llvm_func_name; also in plain",
        "the address of a compiled function",
        "none",
        "`numba.cfunc`, which compiles each function once more",
    ),
    Name(
        "of a target context: make_array, populate_array, get_data_type, get_abi_sizeof; also in "
        "plain",
        "arrays of a table and views of parts of an array, which count no references",
        "as the row of options",
        "`carray`, and slices of arrays, which count them",
    ),
    Name(
        "types.FunctionType: jit_addr, c_addr; of a target context: make_helper, make_array; also "
        "in plain",
        "a function value of an address: the function table",
        "0.1 ms of each call that is handed a function",
        "functions as arguments, of which numba looks the address up at each call",
    ),
)
