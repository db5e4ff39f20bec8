"""A second process that builds a first machine, while this one imports numba and the runtime.

The imports of SymPy and of the compiler and a small machine's translation take as long as the
imports of numba and of the runtime, and a run needs nothing of the former but the text. So a
process that has neither lets another one, on another core, write the text. What is wrong with a
model, what it prints and what it warns of are this process's own affair: it then builds anew.
"""

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

from codegen.available_cores import available_cores

PROGRAM = """
import json, sys
sys.path[:], arguments = json.loads(sys.argv[1])
from runtime.build_process import main
main(*arguments)
"""
"""Its argument holds the path of modules, and the arguments of `main`."""

_PAUSE = 0.2  # measured: s between two looks for the starting process, which cost nothing


def build_beside(model: Path, scene: str | None, folder: Path) -> tuple[Path, str] | None:
    """Path and hash of the module that another process has written; None if there is none.

    Nothing is tried where SymPy is imported already, or where there is one core alone.
    """
    if "sympy" in sys.modules or available_cores() < 2 or not sys.executable:
        return None
    arguments = json.dumps([sys.path, [str(model), scene, str(folder)]])
    warned = [f"-W{option}" for option in sys.warnoptions]
    kinds: dict[str, Any] = {"process_group": 0} if os.name == "posix" else {}
    try:
        process = subprocess.Popen(
            [sys.executable, *warned, "-P", "-c", PROGRAM, arguments], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **kinds,
        )  # fmt: skip
    except OSError:  # no process can be started
        return None
    with process:
        try:
            _prepare_for_a_run()
            assert process.stdout is not None
            answer = process.stdout.read()
        except BaseException:
            process.kill()
            raise
    try:
        path, digest = json.loads(answer)
    except ValueError:
        return None
    return Path(path), digest


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
        warnings.catch_warnings(record=True) as warned,
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
