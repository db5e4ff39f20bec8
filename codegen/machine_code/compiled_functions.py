"""Functions that numba compiles for one signature when they are first needed, and keeps on disk.

Numba compiles or loads a function with an explicit signature when its module is imported. Here that
waits until somebody calls the function, asks for its address or compiles what calls it: a run loads
two thirds of what it imports.

Each function has a lock, under which one process compiles it while the others wait; different
functions compile in different processes at the same time.
"""

import os
import secrets
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from itertools import count
from pathlib import Path
from typing import Any

import numba
from numba import types

from codegen.garbage_collection import collection_paused
from codegen.machine_code.code_folders import (
    code_folders,
    name_of_state,
    note_unkept,
    numba_keeps_in,
    remove_older,
)
from codegen.machine_code.file_lock import locked
from codegen.machine_code.separate_compilation import (
    StaleCodeError,
    give_interface,
    separate_compilation,
    symbols_kept,
)
from codegen.machine_code.undocumented_names import (
    PLAIN,
    Dispatcher,
    FunctionCache,
    FunctionIdentity,
    event,
    global_compiler_lock,
    rtsys,
)
from codegen.termination_signals import SignalDeferral

_numba: Any = numba  # numba leaves its names untyped
_types: Any = types

if not PLAIN:

    def _number_functions() -> None:
        """Let this process number functions as no other does.

        Numba tells functions of one name apart, closures above all, by a number that counts what a
        process has compiled. Two functions of two processes can have one number, and where both
        come from the disk, the linker takes the first for both.
        """
        FunctionIdentity._unique_ids = count(secrets.randbits(64) << 32)

    _number_functions()
    if hasattr(os, "register_at_fork"):  # a system that forks
        os.register_at_fork(after_in_child=_number_functions)

functions: "list[CompiledFunction]" = []  # all that are declared, each behind those that it calls


class CompiledFunction(Dispatcher):  # type: ignore[misc]
    """A function that is compiled, or loaded, for its signature when it is first needed.

    Attributes
    ----------
    signature
        The only one that it gets; None for what compiles with its callers, as they call it.
    can_be_kept
        Whether there is a folder for its machine code, where one is wanted.
    """

    signature: Any = None
    can_be_kept = True

    def prepare(self) -> None:
        """Compile or load it, unless it is."""
        with global_compiler_lock:
            if self.signature is not None and not self.overloads:
                self.compile(self.signature)
                self.disable_compile()

    def compile(self, signature: Any) -> Any:
        """Numba's lock comes first: two threads that hold one each would wait for each other.

        The keyboard's interrupt waits: within LLVM it would abort the process.
        """
        file = getattr(self._cache, "_cache_file", None)
        alone = locked(Path(f"{file._index_path}.lock")) if file else nullcontext()
        waits = SignalDeferral(in_commands=False)
        if not self.can_be_kept:
            note_unkept()
        with global_compiler_lock, waits, alone, collection_paused(), separate_compilation():
            entry = super().compile(signature)
            give_interface(self)
            return entry

    def result_for(self, kinds: tuple[Any, ...]) -> Any:
        """The result of its compilation for arguments of these types."""
        self.prepare()
        if kinds not in self.overloads:
            self.compile(kinds)
        return self.overloads[kinds]

    def get_call_template(self, arguments: Any, named: Any) -> Any:
        """Compile once for all integers: numba would once more for each constant argument."""
        self.prepare()
        positional = [_types.unliteral(kind) for kind in arguments]
        keywords = {name: _types.unliteral(kind) for name, kind in dict(named).items()}
        return super().get_call_template(positional, keywords)

    def _compile_for_args(self, *arguments: Any, **named: Any) -> Any:
        if self.signature is None or self.overloads:
            return super()._compile_for_args(*arguments, **named)
        self.prepare()
        return self  # which numba then calls


class AddressedFunction(CompiledFunction):
    """A function that has no way in from Python: numba would jump to nowhere."""

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Refuse: TypeError."""
        raise TypeError(
            f"{self.py_func.__module__}.{self.__name__} is called by compiled code alone: "
            "call it from a function of your own that numba compiles."
        )


class _Cache(FunctionCache):  # type: ignore[misc]
    """Numba's files of one function, in a folder that is named by all that they are made from."""

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Machine code from the disk; None where there is none that can be read.

        Numba's own method first reads its types of all of NumPy, and SciPy with them. A compilation
        alone needs these, and reads them itself; other processes started a quarter later.
        """
        try:
            rtsys.initialize(target)  # symbols that machine code refers to
            return self._load_overload(signature, target)
        except StaleCodeError:
            return None
        except Exception:  # whatever a damaged file leads to
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep machine code; a folder that is full keeps none."""
        with symbols_kept():
            try:
                super().save_overload(signature, result)
            except OSError:
                note_unkept()


def compiled_function(
    function: Any, signature: Any, options: dict[str, Any],
    folders: Sequence[Path] | None = None, from_python: bool = True,
) -> Any:  # fmt: skip
    """A function that numba compiles with these options, and keeps in the last of these folders.

    From the others it is loaded if it is there. Without a signature it compiles with its callers,
    without folders it is not kept.
    """
    if PLAIN:
        documented = {key: x for key, x in options.items() if key in _DOCUMENTED}
        with numba_keeps_in(folders[-1] if folders else None):
            given = [] if signature is None else [signature]
            return _numba.njit(*given, **documented, cache=bool(folders))(function)
    kind = CompiledFunction if from_python else AddressedFunction
    made = kind(function, targetoptions={"nopython": True, **options})
    made.signature = signature
    made.can_be_kept = folders is None or bool(folders)
    for folder in folders or ():
        with numba_keeps_in(folder), suppress(RuntimeError):  # its file is nowhere, or no folder
            made._cache = _Cache(function)
            if Path(made._cache._cache_file._index_path).exists():
                break
    functions.append(made)
    return made


_DOCUMENTED = ("error_model", "fastmath", "nogil")


def own_folders(beside: Path, sources: list[bytes], first: str = "lw-") -> list[Path]:
    """The folders for functions that are made from these sources, for `compiled_function`.

    Their names begin with `first`.
    """
    name = f"{first}{name_of_state(sources)}"
    folders = code_folders(beside, name)
    for folder in folders:
        if (folder / name).exists():
            with suppress(OSError):
                os.utime(folder / name)  # it is used
        else:
            remove_older(folder, first + "[0-9a-f]" * (len(name) - len(first)))
    return [folder / name for folder in folders]


def prepare(function: Any) -> None:
    """Compile or load a function that waits to be needed."""
    if isinstance(function, CompiledFunction):
        function.prepare()


def is_kept(function: Any) -> bool:
    """Whether a function is loaded, or its machine code lies on the disk, or nothing is kept."""
    file = getattr(getattr(function, "_cache", None), "_cache_file", None)
    return not isinstance(function, CompiledFunction) or file is None or bool(
        function.overloads or Path(file._index_path).exists()
    )  # fmt: skip


def address_of(function: Any) -> int:
    """The address of a compiled function that has one signature."""
    prepare(function)
    (result,) = function.overloads.values()
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


@contextmanager
def watched_compilation(
    begun: Callable[[Any], object], ended: Callable[[], object]
) -> Iterator[None]:
    """Within the block, say which Python function numba begins to compile, and that it ended."""
    if PLAIN:
        yield
        return
    listener = type("Listener", (event.Listener,), {
        "on_start": lambda _, about: begun(about.data["dispatcher"].py_func),
        "on_end": lambda _, about: ended(),
    })()  # fmt: skip
    with event.install_listener("numba:compile", listener):
        yield
