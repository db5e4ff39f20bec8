"""Numba's events of LLVM's lock, by which a timer of numba's knows how long LLVM took.

Each call of LLVM makes two of them, and a first run makes 160 000 calls: the events took a
thirtieth of compiling. Nothing here asks that timer.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite.binding import ffi  # type: ignore[import-untyped]

_library: Any = ffi.lib


@contextmanager
def no_lock_events() -> Iterator[None]:
    """Within the block, LLVM's lock is taken and given back without events."""
    lock: Any = getattr(_library, "_lock", None)
    if not hasattr(lock, "_cblist"):  # another version of LLVM's bindings
        yield
        return
    before, lock._cblist = lock._cblist, []
    try:
        yield
    finally:
        lock._cblist = before
