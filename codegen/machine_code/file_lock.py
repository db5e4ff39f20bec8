"""A lock by a file, which one process at a time can hold."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """One process at a time; without a lock where the file `path` cannot be made or locked."""
    from filelock import FileLock  # which takes a tenth of a start of the program

    try:
        held = FileLock(path).acquire()
    except (OSError, NotImplementedError):  # read-only, or a disk without locks
        yield
        return
    with held:
        yield
