"""What a person who waits sees: a bar for a long analysis, and what numba compiles meanwhile.

A terminal shows a bar. A notebook shows lines, since its output is kept, and of compilation alone.
"""

import re
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
_DECORATED = re.compile(rb"^ *@(?:compiled|unlocked|addressed|allocating)\(", re.MULTILINE)


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
        with compilation_shown(words.get("progress") is not False):
            return function(*arguments, **words)

    return shown


@contextmanager
def compilation_shown(wanted: bool = True) -> Iterator[None]:
    """Show what numba compiles in the block, once that has taken a second.

    The runtime is compiled once after an installation, which takes the better part of a minute.
    """
    terminal, notebook = sys.stderr.isatty(), "ipykernel" in type(sys.stderr).__module__
    in_main = threading.current_thread() is threading.main_thread()
    if not (wanted and in_main and (terminal or notebook)) or _Compilation.current is not None:
        yield
        return
    from numba.core import event

    numba_events: Any = event  # numba leaves these untyped
    compilation = _Compilation.current = _Compilation(terminal)
    listener = type("Listener", (numba_events.Listener,), {
        "on_start": lambda _, about: compilation.begin(about.data["dispatcher"].py_func),
        "on_end": lambda _, about: compilation.end(),
    })()  # fmt: skip
    try:
        with numba_events.install_listener("numba:compile", listener):
            yield
    finally:
        compilation.close()
        _Compilation.current = None


class _Compilation:
    """The functions that numba compiles, counted, and what shows them."""

    current: "_Compilation | None" = None

    def __init__(self, terminal: bool) -> None:
        self.terminal = terminal
        self.began, self.took, self.depth, self.count, self.total = 0.0, 0.0, 0, 0, 0
        self.bar: Any = None  # of a terminal
        self.said = ""

    def begin(self, function: Any) -> None:
        """A function is compiled from now on, perhaps for one that is being compiled."""
        self.depth += 1
        if self.depth > 1:
            return
        self.began = time.monotonic()
        path = Path(function.__code__.co_filename)
        ours = any(path.is_relative_to(at) for at in (LIBRARY / "runtime", methods_folder()))
        self.count += ours
        if self.took > PATIENCE:
            with suppress(OSError):  # of a terminal that was closed
                self._show(ours, path.stem)

    def end(self) -> None:
        """It is compiled."""
        self.depth -= 1
        if self.depth == 0:
            self.took += time.monotonic() - self.began

    def _show(self, ours: bool, stem: str) -> None:
        text = f"compiling {stem.replace('__', ', scene ')}"
        if ours:
            text = "compiling the runtime, once after an installation: about a minute"
        if not self.terminal:
            if text != self.said and (ours or not self.said):
                sys.stderr.write(f"Linkwright: {text}.\n")
                self.said = text
            return
        if self.bar is None:
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

            columns = TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn()
            self.bar = Progress(*columns, console=Console(stderr=True), transient=True)
            self.task = self.bar.add_task(text, total=None)
            self.bar.start()
        self.total = self.total or functions_of_the_runtime()
        total = self.total if ours else None
        self.bar.update(
            self.task, description=text, total=total, completed=min(self.count, total or 0)
        )
        self.said = text

    def close(self) -> None:
        """Show no more, but for how long it took."""
        if self.bar is not None:
            with suppress(OSError):
                self.bar.stop()
            self.bar = None
        if "the runtime" in self.said and self.count:
            with suppress(OSError):
                sys.stderr.write(
                    f"Linkwright: compiled in {self.took:.0f} s; later runs start at once.\n"
                )
        self.said = ""

    @classmethod
    def hide(cls) -> None:
        """Leave the terminal to another bar."""
        if cls.current is not None:
            cls.current.close()


def functions_of_the_runtime() -> int:
    """How many functions a first run compiles, about: those that all explicit methods need."""
    modules = [p for p in (LIBRARY / "runtime").rglob("*.py") if "implicit" not in p.parts]
    return sum(len(_DECORATED.findall(path.read_bytes())) for path in modules)
