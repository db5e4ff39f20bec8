"""Numba's cache on disk, made safe: nothing damaged or of another source is ever run.

Numba trusts what lies in its cache: a file that is cut short ends a program; where a process ends
between the writing of an index and of its data, old machine code is taken for new. Here each data
file ends with the hash of its content and of its source's date. What does not agree is thrown away
and compiled anew, with a note; a folder that cannot be written costs a note, too, and no more.
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
        self._cache_file.__class__ = _CheckedFiles

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
            return super()._load_index()
        except Exception as error:  # a pickle that is cut short raises nearly anything
            _note_damage(self._index_path, error)
            return {}

    def _load_data(self, name: str) -> Any:
        path = Path(self._data_path(name))
        content = path.read_bytes()
        data = content[:-_SEAL]
        if content[-_SEAL:] == self._seal(data):
            return pickle.loads(data)
        _note_damage(path, "its content is not what was written for this source")
        return None

    def _save_data(self, name: str, data: Any) -> None:
        content = self._dump(data)
        with self._open_for_write(self._data_path(name)) as file:
            file.write(content + self._seal(content))

    def _seal(self, data: bytes) -> bytes:
        return hashlib.sha256(data + repr(self._source_stamp).encode()).digest()


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
