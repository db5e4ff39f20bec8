"""What a build carries from stage to stage: the time that each took, the files on their way."""

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

Progress = Callable[[str], None]


@dataclass
class Clock:
    """Times the stages of one scene, and announces them."""

    seconds: dict[str, float]
    progress: Progress
    what: str

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Time what happens inside."""
        self.progress(f"{self.what}: {stage}")
        started = perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = perf_counter() - started


@dataclass
class File:
    """A generated file on its way from its text to the disk and numba's cache.

    Attributes
    ----------
    changed
        Whether its text is new on the disk, or in a check differs from it.
    operations
        Kernel → arithmetic operations, of a companion.
    companions
        Kind → the file that goes with it.
    """

    path: Path
    text: str
    clock: Clock
    changed: bool = False
    operations: dict[str, int] = field(default_factory=dict)
    companions: "dict[str, File]" = field(default_factory=dict)

    @property
    def digest(self) -> str:
        """SHA-256 of the text."""
        return hashlib.sha256(self.text.encode()).hexdigest()
