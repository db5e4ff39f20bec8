"""SIGINT, SIGTERM and SIGHUP: requests to stop, which are obeyed at places where nothing is lost.

Python raises KeyboardInterrupt wherever the program is at that instant: within LLVM, whose memory
is then freed twice, or in a callback that swallows it. A `SignalDeferral` notes the interrupt
instead, and raises it at the end of a block. A command line takes the signals over for the rest of
its process: it ends at once, with the status 128 + number, until there is something to keep; from
then on signals are noted, and what has been computed is saved first.
"""

import contextlib
import os
import signal
import sys
import threading
from types import FrameType
from typing import Any

_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")  # Windows has no SIGHUP
_SIGNALS = tuple(getattr(signal, name) for name in _NAMES if hasattr(signal, name))


class _State:
    """What the process knows of its signals."""

    command_line = False  # whether they are taken over for good
    keeping = False  # whether what is computed is kept before the process ends
    depth = 0  # of nested deferrals
    number = 0  # of the first signal that was noted
    answered = False  # whether the block that noted it has ended because of it
    finished = False  # whether a command has nothing more to do
    ending = threading.Lock()


class SignalDeferral:
    """A block in which a signal is noted: `arrived`. Unless `answered`, its end obeys it.

    Outside of a command line that is the keyboard's interrupt alone, in the main thread alone.

    Parameters
    ----------
    computing
        Whether the block makes a result that a command line should keep.
    at_once
        Whether it begins with the block, or where `begin` is called: to take over a signal and to
        hand it back takes as long as a hundred evaluations of a small machine.
    in_commands
        Whether a command line, which ends without any exception, waits for the end of the block.
    """

    def __init__(
        self, *, computing: bool = False, at_once: bool = True, in_commands: bool = True
    ) -> None:
        self.computing, self.at_once, self.in_commands = computing, at_once, in_commands
        self.begun = self.answered = False

    def __enter__(self) -> "SignalDeferral":
        if self.at_once or _State.command_line:
            self.begin()
        return self

    def begin(self) -> None:
        """Note signals from now on."""
        unwanted = self.begun or (_State.command_line and not self.in_commands)
        if unwanted or threading.current_thread() is not threading.main_thread():
            return
        self.begun = True
        if not (_State.depth or _State.command_line):
            _State.number, _State.answered = 0, False
            self.previous: Any = signal.signal(signal.SIGINT, _note)
        _State.depth += 1

    @property
    def arrived(self) -> bool:
        """Whether a signal was noted."""
        return self.begun and _State.number > 0

    def __exit__(self, *_: object) -> None:
        if not self.begun or (_State.command_line and _State.keeping and self.computing):
            return  # what was computed is not saved yet: the process ends by itself
        _State.answered |= self.answered
        _State.depth -= 1
        if _State.depth:
            return
        if _State.command_line:
            if _State.number:
                _end()
            return
        signal.signal(signal.SIGINT, self.previous or signal.SIG_DFL)
        if _State.number and not _State.answered:
            signal.raise_signal(signal.SIGINT)


def take_over() -> None:
    """Take the signals over for the rest of the process: the first thing that a command does.

    A thread hears them as well: LLVM compiles for seconds before Python looks at a signal.
    """
    _State.command_line = True
    for number in _SIGNALS:
        # nohup has a program go on when its terminal is closed.
        if number == signal.SIGINT or signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _note)
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    threading.Thread(target=_listen, args=(reader,), daemon=True).start()


def keep_results() -> None:
    """From the next block that computes on, signals are noted until `finish`."""
    _State.keeping = True


def finish() -> None:
    """Obey signals at once, those noted and those to come: everything is saved and said."""
    if not _State.command_line:
        return
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):  # a terminal or pipe that is closed
            stream.flush()
    _State.keeping, _State.depth, _State.finished = False, 0, True
    if _State.number:
        _end()


def _note(number: int, frame: FrameType | None = None) -> None:
    _State.number = _State.number or number
    if _State.command_line and not _State.depth:
        _end()


def _listen(reader: int) -> None:
    while byte := os.read(reader, 1):
        if byte[0] in _SIGNALS:
            _note(byte[0])


def _end() -> None:
    """End the process now: no handler or finalizer runs in what a signal has interrupted."""
    if not _State.ending.acquire(blocking=False):
        return  # the other thread is at it
    with contextlib.suppress(OSError):
        cursor = "\x1b[?25h" if os.isatty(2) else ""  # that a progress bar has hidden
        text = f"Stopped by {signal.Signals(_State.number).name}"
        text += "." if _State.finished else ": nothing had been computed that could be kept."
        os.write(2, f"{cursor}{text}\n".encode())
    os._exit(128 + _State.number)
