"""A second process that builds a first machine, while this one imports numba and the runtime.

The imports of SymPy and of the compiler and a small machine's translation take as long as the
imports of numba and of the runtime, and a run needs nothing of the former but the text. So a
process that has neither lets another one, on another core, write the text, if the model is a
declaration alone: it imports what makes declarations, and asks nothing of the running program. What
is wrong with it, what it prints and what it warns of are this process's own affair: it then builds
the machine itself.
"""

import ast
import contextlib
import io
import json
import os
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path
from typing import Any

from codegen.garbage_collection import collection_paused
from codegen.other_processes import can_start, interpreter, module_path

PROGRAM = """
import json, sys
sys.path[:], arguments = json.loads(sys.argv[1])
from runtime.build_process import main
main(*arguments)
"""
"""Its argument holds the path of modules, and the arguments of `main`."""

_DECLARING = frozenset({"codegen", "linkwright", "sympy", "math", "numpy", "dataclasses", "typing"})
"""Modules that a declaration imports; a program's own may differ from process to process."""
_ASKING = frozenset(
    {
        *("open", "input", "load", "loadtxt", "genfromtxt", "fromfile", "memmap"),
        *("exec", "eval", "compile", "globals", "locals", "vars", "getattr", "setattr"),
        *("__import__", "__builtins__", "sys", "os", "modules", "builtins", "random", "hash"),
    }
)
"""Names of what asks, or changes, something outside of a declaration."""
_PAUSE = 0.2  # measured: s between two looks for the starting process, which cost nothing


def build_beside(model: Path, scene: str | None, folder: Path) -> tuple[Path, str] | None:
    """Path and hash of the module that another process has written; None if there is none.

    Nothing is tried where this process has imported SymPy, or what it would import meanwhile, or
    may use one core alone.
    """
    if not {"sympy", "runtime.machine_facade"}.isdisjoint(sys.modules) or not can_start():
        return None
    if not _declares_alone(model):
        return None
    arguments = json.dumps([module_path(), [str(model), scene, str(folder)]])
    kinds: dict[str, Any] = {"process_group": 0} if os.name == "posix" else {}
    try:
        process = subprocess.Popen(
            [*interpreter(), "-c", PROGRAM, arguments], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **kinds,
        )  # fmt: skip
    except OSError:  # no process can be started
        return None
    with process:
        try:
            with collection_paused():
                _prepare_for_a_run()
            assert process.stdout is not None
            answer = process.stdout.read()
        except BaseException:
            process.kill()
            raise
    with contextlib.suppress(ValueError):
        match json.loads(answer):
            case [str(path), str(digest)]:
                return Path(path), digest
    return None


def _declares_alone(model: Path) -> bool:
    """Whether a file does nothing but declare, as far as its text shows."""
    try:
        nodes = [*ast.walk(ast.parse(model.read_bytes()))]
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return False  # which the build explains
    plain = [name.name for n in nodes if isinstance(n, ast.Import) for name in n.names]
    origins = ["." * n.level + (n.module or "") for n in nodes if isinstance(n, ast.ImportFrom)]
    taken = [name.name for n in nodes if isinstance(n, ast.ImportFrom) for name in n.names]
    modules = [*plain, *origins]
    names = {part for name in [*modules, *taken] for part in name.split(".")}
    names |= {node.id for node in nodes if isinstance(node, ast.Name)}
    names |= {node.attr for node in nodes if isinstance(node, ast.Attribute)}
    return {name.partition(".")[0] for name in modules} <= _DECLARING and not names & _ASKING


def _prepare_for_a_run() -> None:
    """Import and load what nearly every run needs."""
    import runtime.dynamics.connected_simulation
    import runtime.machine_facade  # noqa: F401
    from runtime.assembly.regular_start import assemble_regular
    from runtime.core.jit import is_kept, prepare
    from runtime.integrate.wiring import load_usual_parts

    load_usual_parts()
    if is_kept(assemble_regular):
        prepare(assemble_regular)


def main(model: str, scene: str | None, folder: str) -> None:
    """Build a scene, and write path and hash of its module; nothing, if anything else was said."""
    threading.Thread(target=_end_with_parent, args=(os.getppid(),), daemon=True).start()
    from codegen import build

    said = io.StringIO()
    with (
        warnings.catch_warnings(record=True, action="always") as warned,
        contextlib.redirect_stdout(said),
        contextlib.redirect_stderr(said),
    ):
        report = build(Path(model), scene=scene, out=Path(folder), compile=False)
    if not warned and not said.getvalue():
        first = report.scenes[0]
        sys.stdout.write(json.dumps([str(first.path), first.digest]))
        sys.stdout.flush()
    os._exit(0)  # nobody waits until Python has freed every object


def _end_with_parent(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_PAUSE)
    os._exit(1)
