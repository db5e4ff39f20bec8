"""Numba's cache on disk, made safe: nothing damaged or of another source is ever run.

Numba trusts what lies in its cache: a file that is cut short ends a program; between the writing of
an index and of its data, old machine code is taken for new; both are pickles, which run whatever
they hold. Here each file ends with a hash of its content, its name and, for machine code, its
source, which is checked before anything is unpickled. A source is known by its date and by its
module, whose name has the hash of a generated text. What does not agree is thrown away and compiled
anew, with a note; a folder that cannot be written costs a note, too, and no more. Files of an older
format are no damage, and are replaced without a note.

The names of these files are none of numba's own. So a generated file can also be imported by plain
Python, in which numba keeps its own files in the same folder: neither reads or removes the other's.

Processes may write and read one cache at once. The name of a file of machine code follows from its
content, and it is written before the index that names it, so that no index names machine code of
another source; a reader whose file has been replaced meanwhile reads the index again. Writers of an
index, which add to what it has, take turns; one that waits for long writes nonetheless, which costs
another process a compilation at most.

Machine code that calls machine code of other functions is loaded after it, and is compiled anew
where one of them was (`codegen.separate_compilation`).

Numba tells functions of one name apart, closures above all, by a number that counts what a process
has compiled. Two functions of two processes can have one number, and where both come from the
cache, the linker takes the first for both. So the numbers of each process begin at a random one.
"""

import hashlib
import os
import pickle
import secrets
import threading
import warnings
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Any

from filelock import FileLock
from numba.core import dispatcher, event
from numba.core.bytecode import FunctionIdentity
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache
from numba.core.compiler_lock import global_compiler_lock
from numba.core.cpu import CPUContext
from numba.core.runtime import rtsys  # type: ignore[attr-defined]

from codegen.damaged_byte_code import CacheWarning
from codegen.garbage_collection import collection_paused
from codegen.llvm_lock_events import no_lock_events
from codegen.numba_operation_types import remembered_operation_types
from codegen.separate_compilation import StaleCodeError, separate_compilation, symbols_kept
from codegen.termination_signals import SignalDeferral

_Function: Any = FunctionCache  # numba leaves these untyped
_IndexData: Any = IndexDataCacheFile
_events: Any = event
_numba: Any = dispatcher
_Identity: Any = FunctionIdentity
_Target: Any = CPUContext

_TRANSLATOR = sorted(Path(__file__).with_name("kernel_compiler").glob("*.py"))
# Every file begins with it: what a text means depends on what translates it.
_FORMAT = b"sealed machine code %s\n" % (
    hashlib.sha256(b"".join(path.read_bytes() for path in _TRANSLATOR)).hexdigest().encode()
)
_OURS = "lw"  # code: in a file's name, pendulum.masses-12.py311.lw.nbi; the longest has 253 letters
_SEAL = hashlib.sha256().digest_size
_WAIT = 0.5  # safety: s, for other writers of a folder, who need some milliseconds each
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
        no_lock_events(),
        remembered_operation_types(),
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
        source = (self._impl.locator.get_source_stamp(), function.__module__)
        self._cache_file: Any = _CheckedFiles(self._cache_path, name, source)

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Machine code from the disk; None where there is none that can be trusted.

        Numba's own method first reads its types of all of NumPy, and SciPy with them. A compilation
        alone needs these, and reads them itself; other processes started a quarter later.
        """
        with SignalDeferral(in_commands=False), separate_compilation():
            try:
                rtsys.initialize(target)  # symbols that machine code refers to
                with self._guard_against_spurious_io_errors():
                    return self._load_overload(signature, target)
            except StaleCodeError:  # no damage: what it calls has been compiled anew
                return None
            except Exception as error:  # whatever a wrong pickle or object file leads to
                _note_damage(self._cache_file._index_path, error)
                return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep machine code; a folder that is full or cannot be written keeps none."""
        with SignalDeferral(in_commands=False), symbols_kept():
            try:
                super().save_overload(signature, result)
            except OSError as error:
                why = f"not kept ({error.strerror or error}); each process compiles it again"
                _note(Path(self._cache_file._index_path), why)


class _CheckedFiles(_IndexData):  # type: ignore[misc]
    """Index and data of one function's cache."""

    def save(self, key: Any, data: Any) -> None:
        """Write machine code, then the index that names it; remove what it does not name."""
        content = self._dump(data)
        name = f"{Path(self._index_name).stem}.{hashlib.sha256(content).hexdigest()[:16]}.nbc"
        with self._turn() as alone:
            self._write(name, content, self._source_stamp)
            source, before = self._read_index()
            overloads = {**before, key: name} if source == self._source else {key: name}
            self._write(self._index_name, self._dump((*self._source, overloads)))
            if alone:  # nobody else has written machine code that no index names yet
                self._remove_all_but(overloads.values())

    @contextmanager
    def _turn(self) -> Iterator[bool]:
        """Whether no other process writes in the folder during the block."""
        lock = FileLock(self._data_path(".lock"), timeout=_WAIT, poll_interval=_WAIT / 100)
        try:
            lock.acquire()
        except (OSError, NotImplementedError):  # a writer that is stopped; a disk without locks
            yield False
            return
        try:
            yield True
        finally:
            lock.release()

    def _remove_all_but(self, named: Collection[str]) -> None:
        """Remove this function's machine code of older formats, sources and broken writers."""
        stem = f"{Path(self._index_name).stem}."
        with suppress(OSError), os.scandir(self._cache_path) as files:
            for file in files:
                mine = file.name.startswith(stem) and file.name not in named
                if mine and (file.name.endswith(".nbc") or ".tmp." in file.name):
                    Path(file.path).unlink()

    def load(self, key: Any) -> Any:
        """Machine code; None where there is none, or none that can be trusted."""
        before = None
        while (name := self._load_index().get(key)) not in (None, before):
            before = name
            with suppress(FileNotFoundError):  # a process that writes has removed it since
                return self._load_data(name)
        return None

    def _load_index(self) -> Any:
        source, overloads = self._read_index()
        return overloads if source == self._source else {}

    def _read_index(self) -> tuple[Any, dict[Any, str]]:
        """(source, the file of each signature); without files where there is no sound index."""
        try:
            content = Path(self._index_path).read_bytes()
        except FileNotFoundError:
            return None, {}
        if not _FORMAT.startswith(content[: len(_FORMAT)]):
            return None, {}
        if not _is_sealed(content, self._index_name):
            _note_damage(self._index_path, "its content is not what was written")
            return None, {}
        try:
            *source, overloads = pickle.loads(content[len(_FORMAT) : -_SEAL])
        except Exception:  # a type that this numba no longer has
            return None, {}
        return tuple(source), overloads

    @property
    def _source(self) -> tuple[Any, Any]:
        return self._version, self._source_stamp

    def _load_data(self, name: str) -> Any:
        path = Path(self._data_path(name))
        content = path.read_bytes()
        if _is_sealed(content, name, self._source_stamp):
            return pickle.loads(content[len(_FORMAT) : -_SEAL])
        _note_damage(path, "its content is not what was written for this source")
        return None

    def _write(self, name: str, content: bytes, *about: object) -> None:
        with self._open_for_write(self._data_path(name)) as file:
            file.write(_sealed(content, name, *about))


def _sealed(data: bytes, *about: object) -> bytes:
    content = _FORMAT + data
    return content + hashlib.sha256(content + repr(about).encode()).digest()


def _is_sealed(content: bytes, *about: object) -> bool:
    return content == _sealed(content[len(_FORMAT) : -_SEAL], *about)


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


def _note_damage(path: str | Path, error: object) -> None:
    reason = f"{type(error).__name__}: {error}" if isinstance(error, Exception) else error
    _note(Path(path), f"damaged ({Path(path).name}: {reason}); what does not load is compiled anew")


def _note(path: Path, what: str) -> None:
    """Warn, once for each folder."""
    folder = str(path.parent)
    if folder not in _noted:
        _noted.add(folder)
        warnings.warn(f"{folder}: machine code is {what}.", CacheWarning, stacklevel=2)
