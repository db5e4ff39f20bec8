"""Progress of a long analysis: a bar, and the functions that numba compiles meanwhile.

A terminal shows a bar. A notebook shows lines, since its output is kept, and of compilation alone.
"""

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from codegen.files.library_folders import LIBRARY, methods_folder

Progress = Callable[[float], None]
Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")

PATIENCE = 1.0  # measured: seconds until a bar is shown
_RUNTIME = "compiling the runtime, once after an installation: up to a minute"


def silent(fraction: float) -> None:
    """Show nothing."""


@contextmanager
def bar(title: str, wanted: bool = True) -> Iterator[Progress]:
    """A bar on stderr where that is a terminal, once the analysis has taken a second."""
    if not wanted or not sys.stderr.isatty():
        yield silent
        return
    from rich.console import Console
    from rich.progress import Progress as Bar

    shown = Bar(console=Console(stderr=True), transient=True)
    task = shown.add_task(title, total=1.0)
    began = time.monotonic()
    started = False

    def report(fraction: float) -> None:
        nonlocal started
        if not started and time.monotonic() - began > PATIENCE:
            _Compilation.hide()
            shown.start()
            started = True
        if started:
            shown.update(task, completed=fraction)

    try:
        yield report
    finally:
        if started:
            with suppress(OSError):  # of a terminal that was closed
                shown.stop()


def shows_compilation(function: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
    """The function; what numba compiles in it is shown, unless its `progress` is false."""

    @wraps(function)
    def shown(*arguments: Arguments.args, **words: Arguments.kwargs) -> Answer:
        if words.get("progress") is False:
            return function(*arguments, **words)
        with compilation_shown():
            return function(*arguments, **words)

    return shown


@contextmanager
def compilation_shown() -> Iterator[None]:
    """Show what numba compiles in the block, once that has taken a second.

    The runtime is compiled once after an installation, which takes 10 s to a minute.
    """
    terminal, notebook = sys.stderr.isatty(), "ipykernel" in type(sys.stderr).__module__
    in_main = threading.current_thread() is threading.main_thread()
    if not (in_main and (terminal or notebook)) or _Compilation.current is not None:
        yield
        return
    from codegen.machine_code.compiled_functions import watched_compilation

    compilation = _Compilation.current = _Compilation(terminal)
    try:
        with watched_compilation(compilation.begin, compilation.end):
            yield
    finally:
        compilation.close()
        _Compilation.current = None


class _Compilation:
    """What numba compiles, how long it took, and the line that tells it."""

    current: "_Compilation | None" = None

    def __init__(self, terminal: bool) -> None:
        self.terminal = terminal
        self.began, self.took, self.depth = 0.0, 0.0, 0
        self.line: Any = None  # of a terminal
        self.said = ""

    def begin(self, function: Any) -> None:
        """A function is compiled from now on, perhaps for one that is being compiled."""
        self.depth += 1
        if self.depth > 1:
            return
        self.began = time.monotonic()
        if self.took > PATIENCE:
            path = Path(function.__code__.co_filename)
            ours = any(path.is_relative_to(at) for at in (LIBRARY / "runtime", methods_folder()))
            text = f"compiling {path.stem.replace('__', ', scene ')}"
            with suppress(OSError):  # of a terminal that was closed
                self.show(_RUNTIME if ours else text)

    def end(self) -> None:
        """It is compiled."""
        self.depth -= 1
        if self.depth == 0:
            self.took += time.monotonic() - self.began

    def show(self, text: str) -> None:
        """Tell it: in a notebook as a line of its own, of the runtime or of the first scene."""
        if self.terminal and self.line is None:
            from rich.console import Console

            self.line = Console(stderr=True).status(text)
            self.line.start()
        elif self.terminal:
            self.line.update(text)
        elif text != self.said and (text == _RUNTIME or not self.said):
            sys.stderr.write(f"Linkwright: {text}.\n")
        self.said = text

    def close(self) -> None:
        """Show no more, but for how long it took."""
        with suppress(OSError):
            if self.line is not None:
                self.line.stop()
            if self.said == _RUNTIME:
                sys.stderr.write(
                    f"Linkwright: compiled in {self.took:.0f} s; later runs start at once.\n"
                )
        self.line, self.said = None, ""

    @classmethod
    def hide(cls) -> None:
        """Leave the terminal to a bar."""
        if cls.current is not None:
            cls.current.close()
