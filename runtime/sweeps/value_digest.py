"""Digest of a value by its content: of functions with all that they refer to.

A function of the user's own is known by its code, defaults, captured values, and the globals that
it reads, each by its content, however deep. Of an installed library the file of the module stands
for all that is in it. Nothing depends on addresses, on the order of a set, or on the process.
"""

import builtins
import dis
import hashlib
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from types import CellType, CodeType, FunctionType, MappingProxyType, ModuleType
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
_EMPTY = "a variable that is not set yet"


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
        return _Digests().of(value)
    except RecursionError:
        raise ContentError("values that lie too deep in one another") from None


class _Digests:
    """Digests of the values of one call, each made once."""

    def __init__(self) -> None:
        self.known: dict[int, tuple[Any, str]] = {}  # address → object, kept alive, and its digest
        self.above: dict[int, int] = {}  # address → depth, of the objects that are being described

    def of(self, value: Any) -> str:
        """The digest of one value: a hash of its words, and of the digests of its parts."""
        depth, key = len(self.above), id(value)
        if key in self.above:
            return f"{depth - self.above[key]} above"
        if key not in self.known:
            self.above[key] = depth
            words, parts = _content(value)
            digests = [self.of(part) for part in parts]
            if isinstance(value, set | frozenset):
                digests.sort()
            del self.above[key]
            content = repr((words, digests)).encode("utf-8", "surrogatepass")
            self.known[key] = value, hashlib.sha256(content).hexdigest()
        return self.known[key][1]


def _content(value: Any) -> tuple[tuple[Any, ...], Iterable[Any]]:
    """Words that say what a value is itself, and the values that it consists of."""
    kind = type(value).__qualname__
    if isinstance(value, float):
        return (kind, float(value).hex()), ()
    if type(value) in _PLAIN:
        return (kind, repr(value)), ()
    if isinstance(value, np.generic | np.ndarray) and value.dtype.kind in "biufcSU":
        numbers = hashlib.sha256(value.tobytes()).hexdigest()
        return ("array", value.dtype.str, value.shape, numbers), ()
    if type(value) in (tuple, list, set, frozenset):
        return (kind,), value
    if type(value) in (dict, MappingProxyType):
        return ("dict",), [part for pair in value.items() for part in pair]
    if isinstance(value, CodeType):
        return ("code", *(getattr(value, name) for name in _CODE)), value.co_consts
    if isinstance(value, ModuleType):
        return ("module", value.__name__, _file_hash(value.__name__)), ()
    if isinstance(value, FunctionType | type):
        return _function_or_class(value)
    if callable(getattr(value, "py_func", None)):  # compiled by numba
        return ("compiled",), (value.py_func,)
    return _object(value)


def _function_or_class(value: Any) -> tuple[tuple[Any, ...], Iterable[Any]]:
    """By its file where it is installed, else by all that it has."""
    cells = [_cell(cell) for cell in getattr(value, "__closure__", None) or ()]
    module = value.__module__ or "builtins"
    if _is_installed(module):
        return ("library", value.__qualname__, _file_hash(module)), cells
    if isinstance(value, type):
        fields = [(k, _plain_field(x)) for k, x in vars(value).items() if k not in _CLASS_FIELDS]
        return ("class", value.__name__), (value.__bases__, fields)
    names, known = sorted(_globals_of(value.__code__)), value.__globals__
    unknown = [name for name in names if name not in known and not hasattr(builtins, name)]
    read = [(name, known[name]) for name in names if name in known]
    parts = value.__code__, value.__defaults__, value.__kwdefaults__, cells, read
    return ("function", value.__name__, *unknown), parts


def _object(value: Any) -> tuple[tuple[Any, ...], Iterable[Any]]:
    """An object of any class: what copies it would be made from."""
    try:
        made = value.__reduce_ex__(4)
    except Exception as error:
        raise ContentError(
            f"a {type(value).__qualname__} of {type(value).__module__}, whose content cannot "
            f"be told ({error})"
        ) from error
    if isinstance(made, str):  # the name of a global, such as a function of NumPy
        module = getattr(value, "__module__", None) or "builtins"
        return ("global", made, _file_hash(module)), (type(value),)
    maker, arguments, state, entries, pairs = (*made, None, None, None)[:5]
    return ("object",), (type(value), maker, arguments, state, [*(entries or ())], [*(pairs or ())])


def _cell(cell: CellType) -> Any:
    try:
        return cell.cell_contents
    except ValueError:
        return _EMPTY


def _plain_field(value: Any) -> Any:
    """The value of a class's field without the object that makes it one."""
    if isinstance(value, staticmethod | classmethod):
        return value.__func__
    if isinstance(value, property):
        return value.fget, value.fset, value.fdel
    if type(value).__name__ in {"member_descriptor", "getset_descriptor"}:
        return type(value).__name__
    return value


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
    """A module's name and SHA-256 of its file, where it has one and is none of Linkwright."""
    file = _file_of(module)
    if file is None or module.partition(".")[0] in _OWN or not file.is_file():
        return module
    return f"{module} {hashlib.sha256(file.read_bytes()).hexdigest()}"
