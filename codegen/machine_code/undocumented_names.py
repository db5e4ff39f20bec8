"""The imports of numba that its documentation lacks.

Only this package imports `numba.core`, `numba.np` or `llvmlite`, and only this module what the
documentation of either lacks. docs/development/undocumented-names.md has a table of all names that
are used, what for, and what each gains. `LINKWRIGHT_NUMBA=plain` uses none of it but the last three
rows, with the same numbers: a way to go on with a numba that no longer has the others, until that
table is brought up to date.
"""

import os
from typing import Any

__all__ = ["PLAIN", "AttributeTemplate", "CodeLibrary", "CpuCodegen", "Dispatcher"]
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
