"""Other processes of Python that do a part of a process's work."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

_subprocess: Any = subprocess  # its flags of the interpreter are for Python's own library


def available_cores() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def can_start() -> bool:
    """Whether another process can run beside this one, on another core.

    A frozen program, or one that Python is a part of, would start itself again.
    """
    is_python = Path(sys.executable or "").stem.lower().startswith(("python", "pypy"))
    return available_cores() > 1 and is_python and not getattr(sys, "frozen", False)


def interpreter() -> list[str]:
    """The command that starts Python as this process was started, without the script's folder."""
    return [sys.executable, *_subprocess._args_from_interpreter_flags(), "-P"]


def module_path() -> list[str]:
    """Where this process looks for modules: other entries than texts are none to Python."""
    entries: list[Any] = sys.path
    return [entry for entry in entries if isinstance(entry, str)]
