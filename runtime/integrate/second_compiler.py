"""A second process that compiles the loop beside the first run, on another core.

From nothing, one core compiles the loop for a quarter of a minute. While the first run compiles its
parts from the first to the last, this process compiles what the run needs at its end, then the
parts from the last to the first; each takes what the other has compiled from the cache, and what
the other is compiling is waited for. The result is the same with one process and with two.
"""

import atexit
import contextlib
import gc
import json
import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from codegen.other_processes import can_start, interpreter, module_path
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
    """Have the process compile functions, from the last to the first, after those that it has.

    It ends when it has compiled all, and is started where it does not run, unless this process may
    use one core alone.
    """
    if not can_start():
        return
    names = [(function.__module__, function.__name__) for function in reversed(functions)]
    if _running and _send(_running[-1], names):
        return
    command = [*interpreter(), "-c", PROGRAM, json.dumps([module_path(), names])]
    kinds: dict[str, Any] = {"process_group": 0} if os.name == "posix" else {}
    quiet = subprocess.DEVNULL
    with contextlib.suppress(OSError):  # no process can be started: one compiles alone
        _running.append(
            subprocess.Popen(command, stdin=subprocess.PIPE, stdout=quiet, stderr=quiet, **kinds)
        )


def _send(process: Any, names: Sequence[tuple[str, str]]) -> bool:
    """Send a process the names of more functions; whether it still runs."""
    if process.poll() is not None:
        return False
    try:
        process.stdin.write(json.dumps(names).encode() + b"\n")
        process.stdin.flush()
    except OSError:  # it has just ended
        return False
    return True


def main(functions: Sequence[tuple[str, str]]) -> None:
    """Compile functions by (module, name), until the process that started this one has ended.

    Nothing looks for garbage meanwhile: that took a tenth of the time, and the end frees all.
    """
    gc.disable()
    for name in ("SIGINT", "SIGHUP"):  # those of the terminal are for the starting process
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    lists: queue.SimpleQueue[Sequence[tuple[str, str]]] = queue.SimpleQueue()
    lists.put(functions)
    threading.Thread(target=_receive, args=(lists,), daemon=True).start()
    try:
        while True:
            for module, name in lists.get_nowait():
                prepare(getattr(import_module(module), name))
    except queue.Empty:
        os._exit(0)  # nobody waits until Python has freed every object


def _receive(lists: "queue.SimpleQueue[Sequence[tuple[str, str]]]") -> None:
    """Receive more functions; end with the process that started this one."""
    for line in sys.stdin.buffer:  # until the pipe is closed, however its other end has ended
        lists.put(json.loads(line))
    os._exit(0)


@atexit.register
def _end() -> None:
    for process in _running:
        with contextlib.suppress(OSError):  # it has ended before it read all
            process.stdin.close()
        process.wait()
