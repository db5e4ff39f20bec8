"""Compilation of the runtime into numba's cache: `python -m runtime.precompile [METHOD ...]`.

The first run after an installation would otherwise wait for one processor. Here several processes
import the modules with compiled code, each the next one that none has begun; the lock of a function
(`runtime.core.jit`) keeps two of them from compiling it both.
"""

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path

from runtime.core.jit import ROOMS
from runtime.integrate.method import METHODS, find_method

_PROCESSES = 4  # safety: each takes half a GB
_OUTSIDE = ("dynamics", "continuation", "statics", "mechanism")
"""Rooms with some compiled code beside those that consist of it."""


def precompile(*methods: str) -> None:
    """Compile what runs with these methods need; without names, with any."""
    context = get_context("spawn")
    processes = min(_PROCESSES, os.cpu_count() or 1)
    with ProcessPoolExecutor(processes, mp_context=context) as pool:
        # The methods first: what compiles longest should not begin last.
        list(pool.map(_import, [*(methods or METHODS)[::-1], *_modules()]))


def _import(name: str) -> None:
    """Import a module, or load a method."""
    if name in METHODS:
        find_method(name)
    else:
        import_module(name)


def _modules() -> list[str]:
    """Names of modules with compiled code but those of methods, the lower rooms first."""
    package = Path(__file__).parent
    files = [
        path.relative_to(package.parent)
        for room in (*ROOMS, *_OUTSIDE)
        for path in sorted((package / room).rglob("*.py"))
        if b"runtime.core.jit" in path.read_bytes()
    ]
    return [
        ".".join(path.with_suffix("").parts)
        for path in files
        if not {"explicit", "implicit"}.intersection(path.parts)
    ]


if __name__ == "__main__":
    if unknown := set(sys.argv[1:]).difference(METHODS):
        sys.exit(f"no such method: {', '.join(sorted(unknown))}; there are {', '.join(METHODS)}")
    precompile(*sys.argv[1:])
