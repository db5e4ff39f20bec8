"""Digest of a value by its content: of functions with all that they refer to.

A function of the user's own is known by its code, defaults, captured values, and the globals that
it reads, each by its content, however deep; a class by its text and its functions. What is
installed is known by its name. Nothing depends on addresses, on the order of a set, or on the
process.
"""

import dis
import hashlib
import inspect
import sys
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType, MappingProxyType, ModuleType
from typing import Any

from codegen.files.library_folders import installed_folders

_PLAIN = (type(None), bool, int, float, complex, str, bytes, range, slice, type(Ellipsis))
_CODE = ("co_argcount", "co_kwonlyargcount", "co_code", "co_names", "co_varnames", "co_freevars")


class ContentError(TypeError):
    """A value whose content cannot be told; its text names what."""


def value_digest(value: Any) -> str:
    """SHA-256 of a value's content, in hexadecimal.

    Raises
    ------
    ContentError
        If it refers to what has no content, such as an open file.
    """
    known: dict[int, tuple[Any, str]] = {}  # address → object, kept alive, and its digest
    above: list[int] = []  # addresses of the objects that are being described

    def digest(value: Any) -> str:
        key = id(value)
        if key in above:
            return f"{len(above) - above.index(key)} above"
        if key not in known:
            above.append(key)
            words, parts = _content(value)
            digests = [digest(part) for part in parts]
            if isinstance(value, set | frozenset):
                digests.sort()
            above.pop()
            content = repr((words, digests)).encode("utf-8", "surrogatepass")
            known[key] = value, hashlib.sha256(content).hexdigest()
        return known[key][1]

    try:
        return digest(value)
    except RecursionError:
        raise ContentError("values that lie too deep in one another") from None


def _content(value: Any) -> tuple[tuple[Any, ...], Iterable[Any]]:
    """Words that say what a value is itself, and the values that it consists of."""
    kind = type(value).__qualname__
    if type(value) in _PLAIN:
        return (kind, repr(value)), ()
    if type(value) in (tuple, list, set, frozenset):
        return (kind,), value
    if type(value) in (dict, MappingProxyType):
        return ("dict",), [part for pair in value.items() for part in pair]
    if isinstance(value, CodeType):
        return ("code", *(getattr(value, name) for name in _CODE)), value.co_consts
    if isinstance(value, ModuleType):
        text = Path(value.__file__ or "").read_bytes() if _is_own(value.__name__) else b""
        return ("module", value.__name__, hashlib.sha256(text).hexdigest()), ()
    if callable(getattr(value, "py_func", None)):  # compiled by numba
        return ("compiled",), (value.py_func,)
    if isinstance(value, FunctionType | type):
        return _function(value) if isinstance(value, FunctionType) else _class(value)
    try:
        made = value.__reduce_ex__(4)  # what copies it would be made from
    except Exception as error:
        raise ContentError(
            f"a {kind} of {type(value).__module__}, whose content cannot be told ({error})"
        ) from error
    if isinstance(made, str):  # the name of a global, such as a function of NumPy
        return ("global", made, getattr(value, "__module__", None)), (type(value),)
    maker, arguments, state, entries, pairs = (*made, None, None, None)[:5]
    return ("object",), (type(value), maker, arguments, state, [*(entries or ())], [*(pairs or ())])


def _function(value: FunctionType) -> tuple[tuple[Any, ...], Iterable[Any]]:
    cells = []
    for cell in value.__closure__ or ():
        with suppress(ValueError):  # of a variable that is not set yet
            cells.append(cell.cell_contents)
    if not _is_own(value.__module__):
        return ("library", value.__module__, value.__qualname__), cells
    known = value.__globals__
    read = [(name, known[name]) for name in sorted(_globals_of(value.__code__)) if name in known]
    parts = value.__code__, value.__defaults__, value.__kwdefaults__, cells, read
    return ("function", value.__name__), parts


def _class(value: type) -> tuple[tuple[Any, ...], Iterable[Any]]:
    if not _is_own(value.__module__):
        return ("library", value.__module__, value.__qualname__), ()
    text = ""
    with suppress(OSError, TypeError):  # of one that stands in no file
        text = inspect.getsource(value)
    functions = [one for one in vars(value).values() if isinstance(one, FunctionType)]
    return ("class", value.__name__, text), (value.__bases__, functions)


def _globals_of(code: CodeType) -> set[str]:
    """Names of the globals that a code and those within it read."""
    names = {
        str(step.argval)
        for step in dis.get_instructions(code)
        if step.opname in {"LOAD_GLOBAL", "LOAD_NAME"}
    }
    return names.union(*(_globals_of(x) for x in code.co_consts if isinstance(x, CodeType)))


@cache
def _is_own(module: str | None) -> bool:
    """Whether a module is the user's: neither installed, nor of Python, nor of Linkwright."""
    if module == "__main__" or (module and module not in sys.modules):
        return True
    file = getattr(sys.modules.get(module or "builtins"), "__file__", None)
    if file is None or (module or "").partition(".")[0] in {"runtime", "codegen", "linkwright"}:
        return False
    return not any(Path(file).resolve().is_relative_to(folder) for folder in installed_folders())
