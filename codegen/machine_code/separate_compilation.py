"""Separate compilation: callers link to the machine code of long functions, and inline short ones.

Numba copies the code of all that a function calls, and of all that this calls in turn, into the
module of the caller, and optimizes and translates it again: the loop over steps came to LLVM three
times over. Here a caller receives the bodies of what is short, which LLVM inlines, and declarations
of the rest, which the linker finds in machine code that all callers share.

So the machine code of a caller is of no use alone. The cache keeps with it what it calls, by name,
types and symbol, and loads that first. A symbol has a number that no other compilation has, so the
callers of what is compiled anew are compiled anew, too.

The cache also keeps what symbols a library defines. Numba parses LLVM's code for that, which only a
caller that is compiled now needs: half of the time that a library took to load.
"""

import re
import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, NamedTuple

from llvmlite import binding  # type: ignore[import-untyped]

from codegen.machine_code.undocumented_names import CodeLibrary, CpuCodegen

_llvm: Any = binding  # which is untyped

_LONG = 150  # measured: lines of a function; LLVM inlines hardly any longer ones
_KIND = "object and symbols"  # code: of what is serialized; numba's are "object" and "bitcode"
_DEFINITION = re.compile(
    r"^define (?:linkonce_odr )?(?P<head>[^\n]*@(?P<name>[^\n(]+)\([^\n]*) \{\n(?P<body>.*?)^\}\n",
    re.MULTILINE | re.DOTALL,
)


class StaleCodeError(OSError):
    """Machine code calls what has been compiled anew since.

    Numba's own cache, which keeps what a user compiles, takes it for a file that is gone, and
    compiles anew.
    """


class Callee(NamedTuple):
    """A function that machine code calls by its symbol.

    To call it loads the function, and so does to unpickle it.
    """

    module: str
    name: str
    types: tuple[Any, ...]
    symbol: str

    def __call__(self) -> None:
        """Load the function; StaleCodeError if it has another symbol."""
        function = getattr(import_module(self.module), self.name)
        if _symbol(function.result_for(self.types)) != self.symbol:
            raise StaleCodeError(f"{self.module}.{self.name} was compiled anew.")

    def __reduce__(self) -> tuple[Any, ...]:
        """As what is loaded before machine code that calls it is unpacked."""
        return _loaded, tuple(self)


def _loaded(*fields: Any) -> Callee:
    callee = Callee(*fields)
    callee()
    return callee


class ObjectCode(CodeLibrary):  # type: ignore[misc]
    """Compiled code, which has an interface once its function can be found by its name.

    Attributes
    ----------
    keeps_symbols
        Whether it is serialized for our own cache; numba's knows no symbols.
    callee
        The function, for its callers.
    bitcode
        The code in LLVM's terms, where it was loaded.
    interface
        What callers link, once one has asked for it.
    """

    keeps_symbols = False
    callee: Callee | None = None
    bitcode: bytes | None = None
    interface: Any = None
    _reload_init: set[Any]

    def finalize(self) -> None:
        """Optimize and translate; keep those of the callees that are still called by symbols."""
        super().finalize()
        called = {f.name for f in self._final_module.functions if f.is_declaration}
        self._reload_init = {
            c for c in self._reload_init if not isinstance(c, Callee) or c.symbol in called
        }

    def serialize_using_object_code(self) -> tuple[str, str, tuple[Any, ...]]:
        """As numba's, with the symbols that the code defines."""
        name, kind, (code, bitcode) = super().serialize_using_object_code()
        if not ObjectCode.keeps_symbols:
            return name, kind, (code, bitcode)
        module = self._final_module
        symbols = [
            value.name
            for values in (module.functions, module.global_variables)
            for value in values
            if not value.is_declaration
        ]
        return name, _KIND, (code, bitcode, symbols)

    @classmethod
    def _unserialize(cls, codegen: Any, state: tuple[str, str, tuple[Any, ...]]) -> Any:
        """Make machine code ready to run."""
        name, kind, data = state
        if kind != _KIND:
            return super()._unserialize(codegen, state)
        code, bitcode, symbols = data
        library = codegen.create_library(name)
        library.enable_object_caching()
        library._set_compiled_object(code)
        library.bitcode = bitcode
        library._finalize_final_module()
        codegen._engine._defined_symbols.update(symbols)
        return library

    def _get_module_for_linking(self) -> Any:
        """What callers link: short functions, and declarations of long ones."""
        if self.bitcode is not None:
            self._shared_module, self.bitcode = _llvm.parse_bitcode(self.bitcode), None
        whole = super()._get_module_for_linking()
        if self.callee is None:
            return whole
        if self.interface is None:
            symbols = {c.symbol for c in self._reload_init if isinstance(c, Callee)}
            self.interface = interface_of(whole, symbols)
        return self.interface


@contextmanager
def separate_compilation() -> Iterator[None]:
    """Within the block, libraries that numba makes or loads are `ObjectCode`."""
    usual, CpuCodegen._library_class = CpuCodegen._library_class, ObjectCode
    try:
        yield
    finally:
        CpuCodegen._library_class = usual


@contextmanager
def symbols_kept() -> Iterator[None]:
    """Within the block, code is serialized with the symbols that it defines."""
    ObjectCode.keeps_symbols = True
    try:
        yield
    finally:
        ObjectCode.keeps_symbols = False


def give_interface(function: Any) -> None:
    """Let callers link to the machine code of a function, of each of its overloads.

    The module of the function must have it by its name, and it must have a method `result_for`.
    """
    module, name = function.__module__, function.__name__
    found = getattr(sys.modules.get(module), name, None) is function
    for types, result in function.overloads.items() if found else ():
        library = result.library
        if isinstance(library, ObjectCode) and library.callee is None:
            library.callee = Callee(module, name, types, _symbol(result))
            library._reload_init.update(result.reload_init, [library.callee])


def interface_of(module: Any, symbols: Collection[str]) -> Any:
    """A module with declarations in place of those of the functions `symbols` that are long."""
    kept = {f.name for f in module.functions if b"alwaysinline" in b" ".join(f.attributes)}
    long = set(symbols) - kept

    def shorten(definition: re.Match[str]) -> str:
        if definition["name"] in long and definition["body"].count("\n") >= _LONG:
            return f"declare {definition['head']}\n"
        return definition[0]

    return _llvm.parse_assembly(_DEFINITION.sub(shorten, str(module)))


def _symbol(result: Any) -> str:
    return str(result.fndesc.llvm_func_name)
