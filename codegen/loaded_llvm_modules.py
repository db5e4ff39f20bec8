"""The modules of LLVM's engine by their addresses.

The engine asks for the module at an address whenever it loads or compiles one, and LLVM's bindings
look for it among all modules of the process. So thousands of kernels, as a process has that loads
many machines, would take a time that grows with their square.
"""

from ctypes import c_void_p, cast
from typing import Any


class ModulesByAddress(set[Any]):
    """The modules of an engine; `at` gives the one at an address, if there is one."""

    def __init__(self, modules: set[Any]) -> None:
        super().__init__(modules)
        self._found = {_address(module._ptr): module for module in modules}

    def at(self, pointer: Any) -> Any:
        """The module that a pointer points to, or None."""
        return self._found.get(_address(pointer))

    def add(self, module: Any) -> None:
        """Add a module."""
        super().add(module)
        self._found[_address(module._ptr)] = module

    def remove(self, module: Any) -> None:
        """Remove a module."""
        super().remove(module)
        del self._found[_address(module._ptr)]

    def clear(self) -> None:
        """Remove all modules."""
        super().clear()
        self._found.clear()


def find_modules_by_address(engine: Any) -> None:
    """Let an engine of LLVM's bindings find its modules at once."""
    modules = getattr(engine, "_modules", None)
    if type(modules) is not set or not hasattr(engine, "_find_module_ptr"):
        return  # it does already, or these are other bindings
    engine._modules = indexed = ModulesByAddress(modules)
    engine._find_module_ptr = indexed.at


def _address(pointer: Any) -> int | None:
    return cast(pointer, c_void_p).value
