"""Other processes that compile beside this one, each on a core of its own.

From nothing, one core compiles the loop for a quarter of a minute. While the first run compiles its
parts from the first to the last, a second process compiles them from the last to the first; each
takes what the other has compiled from the cache, and waits for what the other is compiling. The
result is the same with one process and with several.
"""

import atexit
import contextlib
import gc
import json
import os
import subprocess
import sys
import threading
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from runtime.core.jit import prepare
from runtime.processors import available_cores

PROGRAM = """
import json, sys
sys.path[:], call = json.loads(sys.argv[1])
import linkwright
from runtime.integrate.second_compiler import call_until_parent_ends
call_until_parent_ends(*call)
"""
"""Its argument holds the path of modules, and a function's module, name and arguments.

`linkwright` finds our packages, also where the user's folder has a file `runtime.py`.
"""

_running: list["subprocess.Popen[bytes]"] = []  # processes that this one has started


def can_start() -> bool:
    """Whether another process can run beside this one, on another core.

    A frozen program, or one that Python is a part of, would start itself again.
    """
    is_python = Path(sys.executable or "").stem.lower().startswith(("python", "pypy"))
    return available_cores() > 1 and is_python and not getattr(sys, "frozen", False)


def compile_beside(functions: Sequence[Any]) -> None:
    """Have one other process compile functions, from the last to the first, if there is a core."""
    if not any(process.poll() is None for process in _running):
        names = [(function.__module__, function.__name__) for function in reversed(functions)]
        call_beside(__name__, "compile_named", names)


def compile_named(*names: tuple[str, str]) -> None:
    """Compile functions by (module, name)."""
    for module, name in names:
        prepare(getattr(import_module(module), name))


def call_beside(module: str, name: str, arguments: Sequence[Any]) -> None:
    """Call a function in another process, which ends with this one, if there is a core."""
    if not can_start():
        return
    entries: list[Any] = sys.path  # other entries than texts mean nothing to Python
    path = [entry for entry in entries if isinstance(entry, str)]
    group: dict[str, Any] = {"process_group": 0} if os.name == "posix" else {}
    quiet, argument = subprocess.DEVNULL, json.dumps([path, (module, name, arguments)])
    with contextlib.suppress(OSError):  # no process can be started: one compiles alone
        _running.append(
            subprocess.Popen(
                [sys.executable, "-P", "-c", PROGRAM, argument],
                stdin=subprocess.PIPE, stdout=quiet, stderr=quiet, **group,
            )
        )  # fmt: skip


def call_until_parent_ends(module: str, name: str, arguments: Sequence[Any]) -> None:
    """Call a function, until the process that started this one has ended.

    Nothing looks for garbage meanwhile: that took a tenth of the time, and the end frees all.
    """
    gc.disable()
    threading.Thread(target=_end_with_parent, daemon=True).start()
    getattr(import_module(module), name)(*arguments)
    os._exit(0)  # nobody waits until Python has freed every object


def _end_with_parent() -> None:
    sys.stdin.buffer.read()  # until the pipe is closed, however its other end has ended
    os._exit(0)


@atexit.register
def _end() -> None:
    for process in _running:
        process.communicate()
