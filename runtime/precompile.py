"""Compilation of the runtime into numba's cache: `python -m runtime.precompile [METHOD ...]`.

The first run after an installation would otherwise wait for one processor. Here several processes
go through all functions, each from another one on, and take from the cache what is compiled.
"""

import sys
from collections import Counter
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from codegen.errors import InputError
from codegen.files.library_folders import LIBRARY
from codegen.machine_code.compiled_functions import functions
from codegen.termination_signals import take_over
from runtime.core.jit import prepare, sources
from runtime.core.kernel_abi import KERNELS, find_stand_in
from runtime.integrate.method import GENERATED, METHODS, REGISTER, find_method
from runtime.integrate.second_compiler import call_beside
from runtime.processors import available_cores

_PROCESSES = 4  # safety: each takes half a GB


def precompile(*methods: str, told: Callable[[str], None] | None = None) -> None:
    """Compile what runs with these methods need; without names, with any.

    `told` receives a line for each room of the runtime that is done. Raises InputError if there is
    no such method.
    """
    if unknown := set(methods).difference(METHODS):
        names = ", ".join(sorted(unknown))
        raise InputError(f"no such method: {names}; there are {', '.join(METHODS)}")
    count = min(_PROCESSES, available_cores())
    for place in range(1, count):
        call_beside("runtime.precompile", "compile_part", [place, count, *methods])
    waiting = declared_functions(methods)
    left = Counter(map(_room, waiting))  # room → functions that are not compiled yet
    for function in waiting:
        prepare(function)
        left[_room(function)] -= 1
        if told and not left[_room(function)]:
            told(f"compiled {_room(function)}")


def compile_part(place: int, count: int, *methods: str) -> None:
    """Compile the functions from one part of them on, of as many as there are processes."""
    waiting = declared_functions(methods)
    first = place * len(waiting) // count
    for function in waiting[first:]:
        prepare(function)


def declared_functions(methods: tuple[str, ...]) -> list[Any]:
    """What runs with these methods call, each function behind those that it calls."""
    for path in sources():
        name = ".".join(path.relative_to(LIBRARY).with_suffix("").parts)
        if name.startswith("runtime.") and ".implicit." not in name:
            import_module(name)
    for name in methods or METHODS:
        for one in filter(None, (REGISTER[name].begins_with, name)):
            find_method(one)
    for name in KERNELS:
        find_stand_in(name)
    return [function for function in functions if function.signature is not None]


def _room(function: Any) -> str:
    path = Path(function.py_func.__code__.co_filename)
    rooms = LIBRARY / "runtime"
    return (
        f"runtime.{path.relative_to(rooms).parts[0]}" if path.is_relative_to(rooms) else GENERATED
    )


if __name__ == "__main__":
    take_over()
    try:
        precompile(*sys.argv[1:])
    except InputError as error:
        sys.exit(str(error))
