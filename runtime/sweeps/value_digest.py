"""Digest of a value by its content: of functions with all that they refer to.

A function of the user's own is known by its code, defaults, captured values, and the globals that
it reads, each by its content, however deep. Of an installed library the file of the module stands
for all that is in it. Nothing depends on addresses, on the order of a set, or on the process.
"""

import builtins
import dis
import functools
import hashlib
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from types import (
    BuiltinFunctionType,
    CellType,
    CodeType,
    FunctionType,
    MappingProxyType,
    MethodType,
    ModuleType,
)
from typing import Any

import numpy as np

from codegen.files.library_folders import installed_folders

_OWN = ("runtime", "codegen")  # packages whose sources a sweep compares as a whole
_PLAIN = (type(None), bool, int, complex, str, bytes, range, slice, type(Ellipsis))
_CODE = (
    "co_argcount", "co_posonlyargcount", "co_kwonlyargcount", "co_flags", "co_code", "co_names",
    "co_varnames", "co_freevars", "co_cellvars", "co_exceptiontable",
)  # fmt: skip
_CLASS_FIELDS = {
    *("__dict__", "__weakref__", "__doc__", "__module__", "__qualname__"),
    *("__firstlineno__", "__static_attributes__", "_abc_impl"),
}


class ContentError(TypeError):
    """A value whose content cannot be told; its text names what."""


def value_digest(value: Any) -> str:
    """SHA-256 of a value's content, in hexadecimal.

    Raises
    ------
    ContentError
        If it refers to what has no content, such as an open file.
    """
    try:
        return _Content({}, {}).of(value)
    except RecursionError:
        raise ContentError("values that lie too deep in one another") from None


class _Content:
    """A hash that grows by the content of values."""

    def __init__(self, known: dict[int, tuple[Any, str]], above: dict[int, int]) -> None:
        self.digest = hashlib.sha256()
        self.known = known  # address → object, which keeps it alive, and its digest
        self.above = above  # address → depth, of the objects that are being described

    def of(self, value: Any) -> str:
        """The digest of one value."""
        self.add(value)
        return self.digest.hexdigest()

    def tag(self, *words: object) -> None:
        """Add words with their lengths, so that no two sequences are one."""
        for word in words:
            text = word if isinstance(word, bytes) else str(word).encode("utf-8", "surrogatepass")
            self.digest.update(f"{len(text)}:".encode() + text)

    def add(self, value: Any) -> None:
        """Add a value: a plain one as it is, another one by its own digest."""
        if isinstance(value, float):
            self.tag(type(value).__qualname__, float(value).hex())
        elif type(value) in _PLAIN:
            self.tag(type(value).__qualname__, value if isinstance(value, bytes) else repr(value))
        elif isinstance(value, np.generic | np.ndarray) and value.dtype.kind in "biufcSU":
            self.tag("array", value.dtype.str, value.shape, value.tobytes())
        elif id(value) in self.above:
            self.tag("above", len(self.above) - self.above[id(value)])
        else:
            if id(value) not in self.known:
                inner = _Content(self.known, {**self.above, id(value): len(self.above)})
                inner._add_new(value)
                self.known[id(value)] = value, inner.digest.hexdigest()
            self.tag(self.known[id(value)][1])

    def _add_new(self, value: Any) -> None:
        if type(value) in (tuple, list):
            self._sequence(type(value).__qualname__, value)
        elif type(value) in (set, frozenset):
            self._sequence("set", sorted(_Content(self.known, self.above).of(x) for x in value))
        elif type(value) in (dict, MappingProxyType):
            self._sequence("dict", [part for pair in value.items() for part in pair])
        elif isinstance(value, CodeType):
            self._sequence("code", [getattr(value, name) for name in _CODE])
            self._sequence("constants", value.co_consts)
        elif isinstance(value, ModuleType):
            self.tag("module", value.__name__, _file_hash(value.__name__))
        elif isinstance(value, FunctionType | BuiltinFunctionType | type | np.ufunc):
            self._named(value)
        elif isinstance(value, MethodType):
            self._sequence("method", (value.__func__, value.__self__))
        elif isinstance(value, functools.partial):
            self._sequence("partial", (value.func, value.args, value.keywords))
        elif callable(getattr(value, "py_func", None)):  # compiled by numba
            self._sequence("compiled", (value.py_func,))
        else:
            self._object(value)

    def _sequence(self, word: str, values: Iterable[Any]) -> None:
        values = list(values)
        self.tag(word, len(values))
        for value in values:
            self.add(value)

    def _named(self, value: Any) -> None:
        """A function or a class: by its file where it is installed, else by all that it has."""
        module = getattr(value, "__module__", None) or "builtins"
        self.tag(type(value).__qualname__, value.__name__)
        owner = getattr(value, "__self__", None)
        if isinstance(value, BuiltinFunctionType) and not isinstance(owner, ModuleType | None):
            self.add(owner)  # the method of an object
        elif not isinstance(value, FunctionType | type) or _is_installed(module):
            self.tag(module, getattr(value, "__qualname__", ""), _file_hash(module))
            for cell in getattr(value, "__closure__", None) or ():
                self._cell(cell)
        elif isinstance(value, FunctionType):
            self._function(value)
        else:
            fields = {k: x for k, x in vars(value).items() if k not in _CLASS_FIELDS}
            self._sequence("bases", value.__bases__)
            self._sequence("fields", [_plain_field(x) for x in fields.items()])

    def _cell(self, cell: CellType) -> None:
        try:
            content = cell.cell_contents
        except ValueError:  # not set yet
            self.tag("empty")
        else:
            self.add(content)

    def _function(self, function: FunctionType) -> None:
        self.add(function.__code__)
        self.add(function.__defaults__)
        self.add(function.__kwdefaults__)
        for cell in function.__closure__ or ():
            self._cell(cell)
        for name in sorted(_globals_of(function.__code__)):
            if name in function.__globals__:
                self.tag("global", name)
                self.add(function.__globals__[name])
            elif not hasattr(builtins, name):
                self.tag("undefined", name)

    def _object(self, value: Any) -> None:
        """An object of any class: what copies it would be made from."""
        try:
            made = value.__reduce_ex__(4)
        except ContentError:
            raise
        except Exception as error:
            raise ContentError(
                f"a {type(value).__qualname__} of {type(value).__module__}, whose content cannot "
                f"be told ({error})"
            ) from error
        self.add(type(value))
        if isinstance(made, str):  # the name of a global
            self.tag("name", made)
            return
        maker, arguments, state, entries, pairs = (*made, None, None, None)[:5]
        self._sequence("object", (maker, arguments, state))
        for more in (entries, pairs):
            self._sequence("entries", more or ())


def _plain_field(field: tuple[str, Any]) -> tuple[str, Any]:
    """A field of a class without the object that makes it one."""
    name, value = field
    if isinstance(value, staticmethod | classmethod):
        return name, value.__func__
    if isinstance(value, property):
        return name, (value.fget, value.fset, value.fdel)
    if type(value).__name__ in {"member_descriptor", "getset_descriptor"}:
        return name, type(value).__name__
    return name, value


def _globals_of(code: CodeType) -> set[str]:
    """Names of the globals that a code and those within it read."""
    names = {
        str(step.argval)
        for step in dis.get_instructions(code)
        if step.opname in {"LOAD_GLOBAL", "LOAD_NAME"}
    }
    return names.union(*(_globals_of(x) for x in code.co_consts if isinstance(x, CodeType)))


def _file_of(module: str) -> Path | None:
    file = getattr(sys.modules.get(module), "__file__", None)
    return None if file is None else Path(file).resolve()


@cache
def _is_installed(module: str) -> bool:
    """Whether a module comes with Python, is installed, or is one of Linkwright."""
    if module.partition(".")[0] in _OWN:
        return True
    if module == "__main__" or module not in sys.modules:
        return False
    file = _file_of(module)
    return file is None or any(file.is_relative_to(folder) for folder in installed_folders())


def _file_hash(module: str) -> str:
    """SHA-256 of a module's file; its name alone where it has none, or is one of Linkwright."""
    file = _file_of(module)
    if file is None or module.partition(".")[0] in _OWN or not file.is_file():
        return module
    return hashlib.sha256(file.read_bytes()).hexdigest()
