"""The keyboard's interrupt during a run."""

import signal
import threading
from types import FrameType
from typing import Any


class Interrupts:
    """Notes the keyboard's interrupt while it is entered, so that no chunk is lost by it."""

    def __enter__(self) -> "Interrupts":
        self.seen = False
        self.active = threading.current_thread() is threading.main_thread()
        if self.active:
            self.previous: Any = signal.signal(signal.SIGINT, self._note)
        return self

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.seen = True

    def __exit__(self, *error: object) -> None:
        if self.active:
            signal.signal(signal.SIGINT, self.previous)
