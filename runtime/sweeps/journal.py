"""Journal of the runs that are being made: by it, a run that ends its process is found.

A task notes the run that it begins, in a file of its own. A file that is left when the block is
begun again tells at which run the process ended. A run at which `TRIES` processes have ended is not
made again. The journal is that of one session: a session that ends, by whatever, accuses no run.
"""

import os
import shutil
import uuid
from collections import Counter
from pathlib import Path
from types import TracebackType

from codegen.errors import LinkwrightError

TRIES = 3  # safety: processes that may end at one run
LOADING, WRITING = -1, -2
_WIDTH = 8  # layout: bytes of a note


def working_folder(store: Path) -> Path:
    """The folder of the journals, next to a store."""
    return store.with_name(f"{store.name}.working")


class Journal:
    """The notes of one task about one block."""

    def __init__(self, store: Path, block: int) -> None:
        self.folder, self.block = working_folder(store) / "journals", block

    def losses(self) -> Counter[int]:
        """Run, or LOADING or WRITING → processes that ended there."""
        found: Counter[int] = Counter()
        for file in self.folder.glob(f"{self.block}-*"):
            content = file.read_bytes()
            found[int.from_bytes(content, "little", signed=True) if content else LOADING] += 1
        for place, word in ((LOADING, "loaded the machine"), (WRITING, "wrote its rows")):
            if found[place] >= TRIES:
                raise LinkwrightError(
                    f"{found[place]} processes ended while one {word} (block {self.block}): they "
                    "were killed, or lack memory or rights. Nothing that is done is lost."
                )
        return found

    def __enter__(self) -> "Journal":
        self.folder.mkdir(parents=True, exist_ok=True)
        self.file = self.folder / f"{self.block}-{uuid.uuid4().hex}"
        self.descriptor = os.open(self.file, os.O_WRONLY | os.O_CREAT, 0o644)
        self.note(LOADING)
        return self

    def note(self, run: int) -> None:
        """Note the run that begins."""
        os.lseek(self.descriptor, 0, os.SEEK_SET)
        os.write(self.descriptor, run.to_bytes(_WIDTH, "little", signed=True))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:  # fmt: skip
        os.close(self.descriptor)
        self.file.unlink(missing_ok=True)  # an exception accuses no run
        if kind is None:
            for file in self.folder.glob(f"{self.block}-*"):
                file.unlink(missing_ok=True)


def clear_journals(store: Path) -> None:
    """Forget what earlier sessions have noted."""
    shutil.rmtree(working_folder(store) / "journals", ignore_errors=True)
