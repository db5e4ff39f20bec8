"""A second process that compiles the loop beside the first run, on another core.

From nothing, one core compiles the loop for half a minute. While the first run compiles its parts
from the first to the last, this process compiles them from the last to the first; each takes what
the other has compiled from the cache, and what the other is compiling is waited for. The result is
the same with one process and with two.
"""

import atexit
import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from runtime.core.jit import prepare

PROGRAM = """
import json, sys
sys.path[:], functions = json.loads(sys.argv[1])
from runtime.integrate.second_compiler import main
main(functions)
"""
"""Its argument holds the path of modules, and (module, name) of each function."""

_running: list[Any] = []  # processes that this one has started


def compile_beside(functions: Sequence[Any]) -> None:
    """Start the process, unless this one may use one core alone."""
    if available_cores() < 2 or not sys.executable:
        return
    names = [(function.__module__, function.__name__) for function in reversed(functions)]
    command = [sys.executable, "-P", "-c", PROGRAM, json.dumps([sys.path, names])]
    kinds: dict[str, Any] = {"process_group": 0} if os.name == "posix" else {}
    quiet = subprocess.DEVNULL
    with contextlib.suppress(OSError):  # no process can be started: one compiles alone
        _running.append(
            subprocess.Popen(command, stdin=subprocess.PIPE, stdout=quiet, stderr=quiet, **kinds)
        )


def available_cores() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def main(functions: Sequence[tuple[str, str]]) -> None:
    """Compile functions by (module, name), until the process that started this one has ended."""
    for name in ("SIGINT", "SIGHUP"):  # those of the terminal are for the starting process
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    for module, name in functions:
        prepare(getattr(import_module(module), name))


def _end_with_parent() -> None:
    sys.stdin.buffer.read()  # until the pipe is closed, however its other end has ended
    os._exit(0)


@atexit.register
def _end() -> None:
    for process in _running:
        process.stdin.close()
        process.wait()
