"""The keyboard's interrupt during a run."""

import signal
import threading
from types import FrameType
from typing import Any


class Interrupts:
    """Notes the keyboard's interrupt once it watches, until it is left, so that no chunk is lost.

    Taking over the signal and handing it back takes as long as a hundred evaluations of a small
    machine, which a short run does without.
    """

    def __enter__(self) -> "Interrupts":
        self.seen = self.watching = False
        return self

    def watch(self) -> None:
        """Take over the signal, unless that is done or another thread's."""
        if not self.watching and threading.current_thread() is threading.main_thread():
            self.previous: Any = signal.signal(signal.SIGINT, self._note)
            self.watching = True

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.seen = True

    def __exit__(self, *error: object) -> None:
        if self.watching:
            signal.signal(signal.SIGINT, self.previous)
