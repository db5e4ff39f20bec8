"""Compilation of the runtime into numba's cache: `python -m runtime.precompile [METHOD ...]`.

The first run after an installation would otherwise wait for one processor. Here several processes
import the modules with compiled code, each module after those that it imports, so that none waits
for what another compiles.
"""

import ast
import os
import signal
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from graphlib import TopologicalSorter
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path

from codegen.errors import InputError
from codegen.files.library_folders import LIBRARY, methods_folder
from codegen.termination_signals import take_over
from runtime.core.jit import ROOMS, compile_functions, prepare
from runtime.integrate.method import GENERATED, METHODS, REGISTER, find_method

_PROCESSES = 4  # safety: each takes half a GB
_WATCHED = 0.2  # safety: s between two looks of a process at its parent
_OUTSIDE = (
    "dynamics",
    "explicit_time",
    "continuation",
    "statics",
    "mechanism",
    "assembly",
    "sweeps",
)
"""Rooms with some compiled code beside those that consist of it."""
_METHOD_OF = {registration.module: name for name, registration in REGISTER.items()}


def precompile(*methods: str, told: Callable[[str], None] | None = None) -> None:
    """Compile what runs with these methods need; without names, with any.

    `told` receives a line for each room of the runtime that is done. Raises InputError if there is
    no such method.
    """
    if unknown := set(methods).difference(METHODS):
        names = ", ".join(sorted(unknown))
        raise InputError(f"no such method: {names}; there are {', '.join(METHODS)}")
    graph = import_graph(methods or METHODS)
    left = Counter(map(_room, graph))  # room → modules that are not compiled yet
    order = TopologicalSorter(graph)
    order.prepare()
    processes = min(_PROCESSES, os.cpu_count() or 1)
    with ProcessPoolExecutor(
        processes, get_context("spawn"), initializer=_end_with_parent, initargs=(os.getpid(),)
    ) as pool:
        pending: dict[Future[None], str] = {}
        while order.is_active():
            pending |= {pool.submit(_compile, module): module for module in order.get_ready()}
            for future in wait(pending, return_when=FIRST_COMPLETED).done:
                future.result()
                order.done(module := pending.pop(future))
                left[_room(module)] -= 1
                if told and not left[_room(module)]:
                    told(f"compiled {_room(module)}")


def _room(module: str) -> str:
    return ".".join(module.split(".")[:2])


def import_graph(methods: tuple[str, ...]) -> dict[str, set[str]]:
    """Module → the modules that it imports, for all with compiled code that the methods need.

    Modules of the runtime that these import are in it, too, with compiled code or without.
    """
    rest = [REGISTER[name].module for name in methods]
    rest += [
        ".".join(path.relative_to(LIBRARY).with_suffix("").parts)
        for room in (*ROOMS, *_OUTSIDE)
        for path in sorted((LIBRARY / "runtime" / room).rglob("*.py"))
        if b"runtime.core.jit" in path.read_bytes() and "implicit" not in path.parts
    ]
    graph: dict[str, set[str]] = {}
    while rest:
        if (module := rest.pop()) not in graph:
            graph[module] = _imports(module)
            rest += graph[module]
    return graph


def _imports(module: str) -> set[str]:
    """Modules of the runtime that a module imports, and that of a method that it loads."""
    tree = ast.parse(_path(module).read_bytes())
    lines = [line for line in tree.body if isinstance(line, ast.ImportFrom) and line.module]
    names = {f"{line.module}.{alias.name}" for line in lines for alias in line.names}
    names |= {str(line.module) for line in lines}
    imported = {name for name in names if name.startswith("runtime.") and _path(name).is_file()}
    begins_with = REGISTER[_METHOD_OF[module]].begins_with if module in _METHOD_OF else ""
    return imported | ({REGISTER[begins_with].module} if begins_with else set())


def _path(module: str) -> Path:
    folder, _, stem = module.rpartition(".")
    place = methods_folder() if folder == GENERATED else LIBRARY.joinpath(*folder.split("."))
    return place / f"{stem}.py"


def _end_with_parent(parent: int) -> None:
    """Have this process end when its parent does, and leave the keyboard's interrupt to that."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(_WATCHED)
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=watch, daemon=True).start()


def _compile(module: str) -> None:
    """Compile the functions of a module; a method is loaded as runs load it."""
    if module in _METHOD_OF:
        method = find_method(_METHOD_OF[module])
        for part in vars(method).values():
            prepare(part)
    else:
        import_module(module)
    compile_functions(module)


if __name__ == "__main__":
    take_over()
    try:
        precompile(*sys.argv[1:])
    except InputError as error:
        sys.exit(str(error))
