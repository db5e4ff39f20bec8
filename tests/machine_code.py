"""How the tests compile generated files: in a forked process, and equal kernels once.

LLVM never frees what it compiled, 10 to 20 MB a machine, of which the tests load hundreds. So a
copy of the process compiles a file, and the tests load the machine code from numba's cache. Scenes
and variants of one machine have kernels in common: a kernel whose code, and code that it calls, has
been compiled for another file takes the machine code of that one.
"""

import gc
import hashlib
import os
import pickle
import shutil
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from numba.core import dispatcher
from numba.core.caching import CompileResultCacheImpl
from numba.core.compiler_lock import global_compiler_lock
from numba.core.environment import Environment

from codegen import numba_cache
from codegen.files import generated_modules

_Cache: Any = numba_cache.CheckedCache
_Reduction: Any = CompileResultCacheImpl  # numba leaves these untyped
_Dispatcher: Any = dispatcher.Dispatcher

_execute = generated_modules._execute


def compile_apart(name: str, path: Path, text: str, kept: Path) -> None:
    """Fill numba's cache of a file, unless it is fresh, with the help of the kernels in `kept`."""
    if not _has_fresh_cache(path):
        kept.mkdir(parents=True, exist_ok=True)
        _in_fork(lambda: _execute_and_share(name, path, text, kept))


def _has_fresh_cache(path: Path) -> bool:
    written = path.stat().st_mtime
    indices = (path.parent / "__pycache__").glob(f"{path.stem}.*.lw.nbi")
    return any(index.stat().st_mtime >= written for index in indices)


def _in_fork(work: Callable[[], object]) -> None:
    """Do `work` in a copy of this process. Its failure is left to the caller, who does it again."""
    # The thread that forks holds the lock, so its copy does; no other thread compiles meanwhile.
    with global_compiler_lock, warnings.catch_warnings():
        # Python 3.12 and later warn of threads: xdist's, which hold no lock that compiling takes.
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        gc.freeze()  # what the collector leaves alone stays shared with the parent
        gc.disable()  # the process is short
        try:
            work()
        finally:
            os._exit(0)
    os.waitpid(child, 0)


def _execute_and_share(name: str, path: Path, text: str, kept: Path) -> None:
    if "\nOPTIONS = " in text:  # kernels; a method has none
        _SharingCache.kept = kept
        numba_cache._checked = _SharingCache
    _execute(name, path, text)


class _NamelessReduction(_Reduction):  # type: ignore[misc]
    """What numba stores of a kernel, without the name of the module that it was compiled for."""

    def reduce(self, result: Any) -> Any:
        """As numba does it; a kernel takes nothing from its module at run time."""
        library, description, environment, *others, environments = super().reduce(result)
        description.modname = "math"
        nameless = tuple(_nameless(one) for one in environments)
        return library, description, _nameless(environment), *others, nameless


def _nameless(environment: Any) -> Any:
    copy: Any = Environment({"__name__": "math"})
    copy.consts[:] = environment.consts
    copy.env_name = environment.env_name
    return copy


class _SharingCache(_Cache):  # type: ignore[misc]
    """Numba's cache of a kernel, which looks among the kernels of all files as well."""

    _impl_class = _NamelessReduction
    kept: Path

    def _load_overload(self, signature: Any, target: Any) -> Any:
        place = self._place(signature)
        if place.exists():
            key = self._index_key(signature, target.codegen())
            self._cache_file.save(key, pickle.loads(place.read_bytes()))
        return super()._load_overload(signature, target)

    def _save_overload(self, signature: Any, result: Any) -> None:
        super()._save_overload(signature, result)
        key = self._index_key(signature, result.codegen)
        stored = self._cache_file._data_path(self._cache_file._load_index()[key])
        partial = Path(tempfile.mkdtemp(dir=self.kept)) / "kernel"
        shutil.copy(stored, partial)
        partial.replace(self._place(signature))
        partial.parent.rmdir()

    def _place(self, signature: Any) -> Path:
        digest = hashlib.sha256(f"{signature} {_content(self._py_func)}".encode())
        return self.kept / digest.hexdigest()


def _content(function: FunctionType) -> str:
    """What decides a kernel's machine code: its code, the values it reads, what it calls."""
    code = function.__code__
    constants = [value for value in code.co_consts if value != function.__doc__]
    # The byte code holds the indices of names, and nothing else says which builtin or attribute.
    names = code.co_names
    read = {name: function.__globals__.get(name) for name in ("OPTIONS", *names)}
    values = {name: _value(value, names) for name, value in read.items() if value is not None}
    arguments = (code.co_varnames, function.__defaults__)
    return repr((function.__name__, code.co_code, constants, names, arguments, values))


def _value(value: object, attributes: tuple[str, ...] = ()) -> object:
    """What a name means; a module, the attributes that the kernel may read of it."""
    if isinstance(value, _Dispatcher):
        return _content(value.py_func)
    if not isinstance(value, ModuleType):
        return pickle.dumps(value)
    read = {name: getattr(value, name) for name in attributes if hasattr(value, name)}
    return value.__name__, {name: _value(attribute) for name, attribute in read.items()}
