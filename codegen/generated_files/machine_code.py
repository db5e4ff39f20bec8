"""Generated files → machine code in numba's cache, several files at a time."""

import os
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from time import perf_counter

from codegen.errors import GeneratedFileError
from codegen.generated_module_signature_and_import import import_generated


def compile_modules(paths: Sequence[Path]) -> list[float]:
    """Compile the kernels of each file; returns the seconds that each took.

    Files without a trace in the checked cache are compiled in processes of their own, as many at a
    time as there are processors; the others are only imported.
    """
    caches = {path: (path.parent / "__pycache__").glob(f"{path.stem}.*.lw.nbi") for path in paths}
    cold = [path for path, cache in caches.items() if not any(cache)]
    seconds: dict[Path, float] = {}
    if len(cold) > 1:
        with ThreadPoolExecutor(max_workers=os.cpu_count() or 1) as pool:
            seconds.update(zip(cold, pool.map(_compile_apart, cold), strict=True))
    for path in paths:
        if path not in seconds:
            started = perf_counter()
            import_generated(path)
            seconds[path] = perf_counter() - started
    return [seconds[path] for path in paths]


def _compile_apart(path: Path) -> float:
    started = perf_counter()
    code = (
        "import sys, pathlib; "
        "from codegen.generated_module_signature_and_import import import_generated; "
        "import_generated(pathlib.Path(sys.argv[1]))"
    )
    folder = Path(__file__).resolve().parents[2]
    path_list = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
    process = subprocess.run(
        [sys.executable, "-P", "-c", code, str(path)],
        env={**os.environ, "PYTHONPATH": path_list},
        capture_output=True,
        text=True,
        check=False,
    )
    if process.returncode:
        raise GeneratedFileError(
            f"{path} does not compile; numba says: {process.stderr.strip().splitlines()[-1:]}"
        )
    return perf_counter() - started
