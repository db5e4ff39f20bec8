"""Numba's cache on disk, made safe: nothing damaged or of another source is ever run.

Numba trusts what lies in its cache: a file that is cut short ends a program; where a process ends
between the writing of an index and of its data, old machine code is taken for new; both are
pickles, which run whatever they hold. Here each file ends with a hash of its content, its name and,
for machine code, its source, which is checked before anything is unpickled. A source is known by
its date and by its module, whose name has the hash of a generated text. What does not agree is
thrown away and compiled anew, with a note; a folder that cannot be written costs a note, too, and
no more.
"""

import hashlib
import pickle
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from numba.core import dispatcher, event
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache

from codegen.damaged_byte_code import CacheWarning
from codegen.termination_signals import Deferral

_Function: Any = FunctionCache  # numba leaves these untyped
_IndexData: Any = IndexDataCacheFile
_events: Any = event
_numba: Any = dispatcher

_SEAL = hashlib.sha256().digest_size
_one_at_a_time = threading.RLock()
_noted: set[str] = set()  # folders with a note


@contextmanager
def checked_caches() -> Iterator[None]:
    """Within the block, functions that numba compiles get checked caches.

    The keyboard's interrupt waits until a function is compiled or loaded: within LLVM it would
    abort the process.
    """
    with _one_at_a_time, _events.install_listener("numba:compile", _LISTENER):
        usual, _numba.FunctionCache = _numba.FunctionCache, _checked
        try:
            yield
        finally:
            _numba.FunctionCache = usual


def _checked(function: Any) -> Any:
    try:
        return CheckedCache(function)
    except RuntimeError as error:  # numba finds no folder that it can write
        _note(Path(function.__code__.co_filename), f"kept nowhere ({error})")
        return NullCache()


class CheckedCache(_Function):  # type: ignore[misc]
    """The cache of one function."""

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        files = self._cache_file
        files.__class__ = _CheckedFiles
        files._source_stamp = (files._source_stamp, function.__module__)

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Machine code from the disk; None where there is none that can be trusted."""
        with Deferral(in_commands=False):
            try:
                return super().load_overload(signature, target)
            except Exception as error:  # whatever a wrong pickle or object file leads to
                _note_damage(self._cache_file._index_path, error)
                return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep machine code; a folder that is full or cannot be written keeps none."""
        with Deferral(in_commands=False):
            try:
                super().save_overload(signature, result)
            except OSError as error:
                why = f"not kept ({error.strerror or error}); each process compiles it again"
                _note(Path(self._cache_file._index_path), why)


class _CheckedFiles(_IndexData):  # type: ignore[misc]
    """Index and data of one function's cache."""

    def _load_index(self) -> Any:
        try:
            content = Path(self._index_path).read_bytes()
        except FileNotFoundError:
            return {}
        if not _is_sealed(content, self._index_name):
            _note_damage(self._index_path, "its content is not what was written")
            return {}
        version, stamp, overloads = pickle.loads(content[:-_SEAL])
        return overloads if (version, stamp) == (self._version, self._source_stamp) else {}

    def _save_index(self, overloads: Any) -> None:
        content = self._dump((self._version, self._source_stamp, overloads))
        with self._open_for_write(self._index_path) as file:
            file.write(content + _seal(content, self._index_name))

    def _load_data(self, name: str) -> Any:
        path = Path(self._data_path(name))
        content = path.read_bytes()
        if _is_sealed(content, name, self._source_stamp):
            return pickle.loads(content[:-_SEAL])
        _note_damage(path, "its content is not what was written for this source")
        return None

    def _save_data(self, name: str, data: Any) -> None:
        content = self._dump(data)
        with self._open_for_write(self._data_path(name)) as file:
            file.write(content + _seal(content, name, self._source_stamp))


def _seal(data: bytes, *about: object) -> bytes:
    return hashlib.sha256(data + repr(about).encode()).digest()


def _is_sealed(content: bytes, *about: object) -> bool:
    return content[-_SEAL:] == _seal(content[:-_SEAL], *about)


class _DeferInterrupts(_events.Listener):  # type: ignore[misc]
    """Defers the keyboard's interrupt from the beginning of a compilation to its end."""

    def __init__(self) -> None:
        self.open = threading.local()

    def on_start(self, event: Any) -> None:
        """Begin a deferral: a function may compile others that it calls."""
        self.open.deferrals = [
            *getattr(self.open, "deferrals", ()),
            Deferral(in_commands=False).__enter__(),
        ]

    def on_end(self, event: Any) -> None:
        """End the last one."""
        *self.open.deferrals, last = self.open.deferrals
        last.__exit__()


_LISTENER = _DeferInterrupts()


def _note_damage(path: str | Path, error: object) -> None:
    reason = f"{type(error).__name__}: {error}" if isinstance(error, Exception) else error
    _note(Path(path), f"damaged ({Path(path).name}: {reason}); what does not load is compiled anew")


def _note(path: Path, what: str) -> None:
    """Warn, once for each folder."""
    folder = str(path.parent)
    if folder not in _noted:
        _noted.add(folder)
        warnings.warn(f"{folder}: machine code is {what}.", CacheWarning, stacklevel=2)
