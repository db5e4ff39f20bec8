"""Linkwright's compiler: a declared mechanism in, a module of numba kernels out.

Public names: `Model` to declare, `build` to compile, and the errors. They load SymPy only when
they are first used, so that the runtime can ask for the errors alone.
"""

from typing import TYPE_CHECKING, Any

from codegen.errors import InputError, LinkwrightError, ModelError

if TYPE_CHECKING:
    from codegen.declare.symbols import alpha, t
    from codegen.driver import BuildReport, build
    from codegen.model import Model

__version__ = "0.1.0"

_HOMES = {
    "Model": "codegen.model",
    "alpha": "codegen.declare.symbols",
    "t": "codegen.declare.symbols",
    "build": "codegen.driver",
    "BuildReport": "codegen.driver",
}

__all__ = [
    "BuildReport",
    "InputError",
    "LinkwrightError",
    "Model",
    "ModelError",
    "__version__",
    "alpha",
    "build",
    "t",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'codegen' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value
