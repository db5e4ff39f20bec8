"""Generated files → machine code in numba's cache, several files, or kernels, at a time."""

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from time import perf_counter

from codegen.errors import GeneratedFileError
from codegen.generated_module_signature_and_import import (
    import_generated,
    kernel_lines,
    read_generated,
)

_LONG = 1000  # measured: lines of kernels that compile longer than another process takes to start


def compile_modules(paths: Sequence[Path]) -> list[float]:
    """Compile the kernels of each file; returns the seconds that each took.

    Files without a trace in the checked cache are compiled in processes of their own, as many at a
    time as there are processors; the others are only imported. The kernels of a long file that is
    alone are shared among processes.
    """
    caches = {path: (path.parent / "__pycache__").glob(f"{path.stem}.*.lw.nbi") for path in paths}
    cold = [path for path, cache in caches.items() if not any(cache)]
    seconds: dict[Path, float] = {}
    if len(cold) > 1:
        with ThreadPoolExecutor(max_workers=os.cpu_count() or 1) as pool:
            seconds.update(zip(cold, pool.map(_compile_file, cold), strict=True))
    for path in paths:
        if path not in seconds:
            started = perf_counter()
            if path in cold:
                _compile_parts(path)
            import_generated(path)
            seconds[path] = perf_counter() - started
    return [seconds[path] for path in paths]


def _compile_file(path: Path) -> float:
    started = perf_counter()
    process = _call("import_generated", path)
    if process.returncode:
        raise GeneratedFileError(
            f"{path} does not compile; numba says: {process.stderr.strip().splitlines()[-1:]}"
        )
    return perf_counter() - started


def _compile_parts(path: Path) -> None:
    """Compile the kernels of a long file in as many processes as there are processors.

    What fails here is compiled by the import that follows, which says why.
    """
    lines = kernel_lines(read_generated(path))
    count = min(os.cpu_count() or 1, len(lines))
    if count < 2 or sum(lines.values()) < _LONG:
        return
    parts: list[list[str]] = [[] for _ in range(count)]
    for name in sorted(lines, key=lines.__getitem__, reverse=True):
        min(parts, key=lambda part: sum(lines[other] for other in part)).append(name)
    with ThreadPoolExecutor(max_workers=count) as pool:
        list(pool.map(lambda part: _call("compile_kernels", path, part), parts))


def _call(function: str, path: Path, *arguments: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Call a function that imports a generated file in a process of its own."""
    code = (
        "import json, sys, pathlib; "
        f"from codegen.generated_module_signature_and_import import {function}; "
        f"{function}(pathlib.Path(sys.argv[1]), *json.loads(sys.argv[2]))"
    )
    folder = Path(__file__).resolve().parents[2]
    path_list = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
    return subprocess.run(
        [sys.executable, "-P", "-c", code, str(path), json.dumps(arguments)],
        env={**os.environ, "PYTHONPATH": path_list},
        capture_output=True,
        text=True,
        check=False,
    )
