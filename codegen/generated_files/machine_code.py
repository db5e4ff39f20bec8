"""Generated files → machine code in numba's cache."""

from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

from codegen.files.generated_modules import import_generated


def compile_modules(paths: Sequence[Path]) -> list[float]:
    """Compile the kernels of each file; returns the seconds that each took."""
    seconds = []
    for path in paths:
        started = perf_counter()
        import_generated(path)
        seconds.append(perf_counter() - started)
    return seconds
