"""Numba's cache on disk, made safe: nothing of another source is ever run.

Numba trusts what lies in its cache: between the writing of an index and of its data, old machine
code is taken for new. Here the name of a file of machine code follows from its content, and it is
written before the index that names it. A source is known by its text and by its module, whose name
has the hash of a generated text. What cannot be read is compiled anew; a folder that cannot be
written costs a note.

The names of these files are none of numba's own. So a generated file can also be imported by plain
Python, in which numba keeps its own files in the same folder: neither reads or removes the other's.

Machine code that calls machine code of other functions is loaded after it, and is compiled anew
where one of them was (`codegen.separate_compilation`).

Numba tells functions of one name apart, closures above all, by a number that counts what a process
has compiled. Two functions of two processes can have one number, and where both come from the
cache, the linker takes the first for both. So the numbers of each process begin at a random one.
"""

import hashlib
import os
import secrets
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Any

from numba.core import dispatcher, event
from numba.core.bytecode import FunctionIdentity
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache
from numba.core.compiler_lock import global_compiler_lock
from numba.core.cpu import CPUContext
from numba.core.runtime import rtsys  # type: ignore[attr-defined]

from codegen.garbage_collection import collection_paused
from codegen.separate_compilation import separate_compilation, symbols_kept
from codegen.termination_signals import SignalDeferral


class CacheWarning(UserWarning):
    """Compiled code cannot be kept on the disk, and is compiled again by each process."""


_Function: Any = FunctionCache  # numba leaves these untyped
_IndexData: Any = IndexDataCacheFile
_events: Any = event
_numba: Any = dispatcher
_Identity: Any = FunctionIdentity
_Target: Any = CPUContext

_TRANSLATOR = sorted(Path(__file__).with_name("kernel_compiler").glob("*.py"))
# What a text means depends on what translates it.
_TRANSLATION = hashlib.sha256(b"".join(path.read_bytes() for path in _TRANSLATOR)).hexdigest()
_OURS = "lw"  # code: in a file's name, pendulum.masses-12.py311.lw.nbi; the longest has 253 letters
_noted: set[str] = set()  # folders with a note


def _number_functions() -> None:
    """Let this process number functions as no other process does."""
    _Identity._unique_ids = count(secrets.randbits(64) << 32)


_number_functions()
if hasattr(os, "register_at_fork"):  # a system that forks
    os.register_at_fork(after_in_child=_number_functions)


@contextmanager
def checked_caches() -> Iterator[None]:
    """Within the block, functions that numba compiles get checked caches, and compile faster.

    The keyboard's interrupt waits until a function is compiled or loaded: within LLVM it would
    abort the process. Searches for cyclic garbage, which took a tenth of a compilation, wait until
    the end of the block. Tables of any size become part of the machine code: numba would take those
    of more than 1 MB by their address, and keep no such function.
    """
    listening = _events.install_listener("numba:compile", _LISTENER)
    with (
        global_compiler_lock,
        collection_paused(),
        listening,
        separate_compilation(),
    ):
        usual, _numba.FunctionCache = _numba.FunctionCache, _checked
        usual_array, _Target.make_constant_array = _Target.make_constant_array, _array_in_code
        try:
            yield
        finally:
            _numba.FunctionCache = usual
            _Target.make_constant_array = usual_array


_usual_array: Any = _Target.make_constant_array


def _array_in_code(context: Any, *arguments: Any) -> Any:
    """A constant array as part of the machine code, whatever its size."""
    context.allow_dynamic_globals = False  # of this context; that of its class stays
    try:
        return _usual_array(context, *arguments)
    finally:
        del context.allow_dynamic_globals


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
        name = f"{self._impl.filename_base}.{_OURS}"
        source = (self._impl.locator.get_source_stamp(), function.__module__, _TRANSLATION)
        self._cache_file: Any = _IndexLast(self._cache_path, name, source)

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Machine code from the disk; None where there is none that can be read.

        Numba's own method first reads its types of all of NumPy, and SciPy with them. A compilation
        alone needs these, and reads them itself; other processes started a quarter later.
        """
        with SignalDeferral(in_commands=False), separate_compilation():
            try:
                rtsys.initialize(target)  # symbols that machine code refers to
                return self._load_overload(signature, target)
            except Exception:  # whatever a damaged file, or one of an older kind, leads to
                return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep machine code; a folder that is full or cannot be written keeps none."""
        with SignalDeferral(in_commands=False), symbols_kept():
            try:
                super().save_overload(signature, result)
            except OSError as error:
                why = f"not kept ({error.strerror or error}); each process compiles it again"
                _note(Path(self._cache_file._index_path), why)


class _IndexLast(_IndexData):  # type: ignore[misc]
    """Index and data of one function's cache."""

    def save(self, key: Any, data: Any) -> None:
        """Write machine code, then the index that names it; remove what it does not name."""
        content = self._dump(data)
        stem = Path(self._index_name).stem
        name = f"{stem}.{hashlib.sha256(content).hexdigest()[:16]}.nbc"
        with self._open_for_write(self._data_path(name)) as file:
            file.write(content)
        overloads = {**self._load_index(), key: name}
        self._save_index(overloads)
        for path in Path(self._cache_path).glob(f"{stem}.*.nbc*"):
            if path.name not in overloads.values():
                with suppress(OSError):
                    path.unlink()

    def _load_index(self) -> dict[Any, str]:
        try:
            found: dict[Any, str] = super()._load_index()
        except Exception:  # it is cut short, or has a type that this numba does not know
            return {}
        return found


class _DeferInterrupts(_events.Listener):  # type: ignore[misc]
    """Defers the keyboard's interrupt from the beginning of a compilation to its end."""

    def __init__(self) -> None:
        self.open = threading.local()

    def on_start(self, event: Any) -> None:
        """Begin a deferral: a function may compile others that it calls."""
        self.open.deferrals = [
            *getattr(self.open, "deferrals", ()),
            SignalDeferral(in_commands=False).__enter__(),
        ]

    def on_end(self, event: Any) -> None:
        """End the last one."""
        *self.open.deferrals, last = self.open.deferrals
        last.__exit__()


_LISTENER = _DeferInterrupts()


def _note(path: Path, what: str) -> None:
    """Warn, once for each folder."""
    folder = str(path.parent)
    if folder not in _noted:
        _noted.add(folder)
        warnings.warn(f"{folder}: machine code is {what}.", CacheWarning, stacklevel=2)
