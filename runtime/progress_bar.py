"""A progress bar for a long analysis."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

Progress = Callable[[float], None]

PATIENCE = 1.0  # measured: seconds until a bar is shown


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
