"""Worker processes on this computer, each replaced where it ends.

Why not a pool of the standard library, or a local cluster of Dask: a process that is killed breaks
a `ProcessPoolExecutor` with everything that waits in it; both start processes that import the
user's script again, which therefore needs a guard; and neither says at which task a process ended.
"""

import contextlib
import json
import os
import pickle
import queue
import subprocess
import sys
import threading
from collections import deque
from typing import Any

from codegen.errors import InputError, LinkwrightError
from runtime.sweeps.block import BlockReport, Job
from runtime.sweeps.journal import TRIES
from runtime.sweeps.worker_process import START

_LAST = 5.0  # safety: s that a process may take to end by itself


def pickled(job: Job) -> bytes:
    """A job for another process; InputError where a function of the user's own cannot go there."""
    from importlib import import_module, util

    library = "cloudpickle" if util.find_spec("cloudpickle") else "pickle"
    try:
        return bytes(import_module(library).dumps(job))
    except Exception as error:
        raise InputError(
            f"The functions of this sweep cannot be sent to another process ({error}). Define them "
            "at the top level of a module, or run with workers=0, in this process."
        ) from error


class _Worker:
    """One process, and the block that it makes."""

    def __init__(self, job: bytes, answers: "queue.SimpleQueue[tuple[_Worker, Any]]") -> None:
        command = [sys.executable, "-P", "-c", START, json.dumps(sys.path)]
        kinds: dict[str, Any] = {"process_group": 0} if os.name == "posix" else {}
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, **kinds
        )
        self.block: int | None = None
        self.ready = False
        self.send(job)
        threading.Thread(target=self._listen, args=(answers,), daemon=True).start()

    def _listen(self, answers: "queue.SimpleQueue[tuple[_Worker, Any]]") -> None:
        stream = self.process.stdout
        assert stream is not None
        with contextlib.suppress(Exception):  # the end of the process, within an answer perhaps
            while True:
                answers.put((self, pickle.load(stream)))
        stream.close()
        answers.put((self, None))

    def send(self, content: bytes) -> None:
        """Hand over what is pickled; a process that has ended is found by its answers."""
        assert self.process.stdin is not None
        with contextlib.suppress(OSError):
            self.process.stdin.write(content)
            self.process.stdin.flush()

    def assign(self, block: int) -> None:
        """Have a block made."""
        self.block = block
        self.send(pickle.dumps(block))


class LocalWorkers:
    """So many processes, which make the blocks that are submitted."""

    def __init__(self, job: Job, count: int) -> None:
        self.job = pickled(job)
        self.answers: queue.SimpleQueue[tuple[_Worker, Any]] = queue.SimpleQueue()
        self.waiting: deque[int] = deque()
        self.replaced = self.failed_starts = 0
        self.workers = [_Worker(self.job, self.answers) for _ in range(count)]

    @property
    def room(self) -> int:
        """Number of blocks that it takes now: each process has one, and another one waits."""
        busy = sum(worker.block is not None for worker in self.workers)
        return 2 * len(self.workers) - busy - len(self.waiting)

    def submit(self, block: int) -> None:
        """Have a block made, once a process is free."""
        self.waiting.append(block)
        self._assign()

    def next(self, timeout: float) -> BlockReport | None:
        """The next report; None where there is none within so many seconds.

        Raises
        ------
        LinkwrightError
            If a block cannot be made at all, or processes do not even start.
        """
        try:
            worker, message = self.answers.get(timeout=timeout)
        except queue.Empty:
            return None
        if message is None:
            self._replace(worker)
            return None
        word, content = message
        if word == "error":
            raise LinkwrightError(content)
        if word == "ready":
            worker.ready = True
            return None
        worker.block = None
        self._assign()
        assert isinstance(content, BlockReport)
        return content

    def _assign(self) -> None:
        for worker in self.workers:
            if worker.block is None and self.waiting:
                worker.assign(self.waiting.popleft())

    def _replace(self, worker: _Worker) -> None:
        """Start another process in place of one that has ended, with its block."""
        status = _end(worker)
        self.failed_starts = 0 if worker.ready else self.failed_starts + 1
        if self.failed_starts >= TRIES:
            raise LinkwrightError(
                f"{TRIES} worker processes ended before they could begin, the last with status "
                f"{status}. Run with --workers 0, in this process, to see why."
            )
        if worker.block is not None:
            self.waiting.appendleft(worker.block)
        self.workers.remove(worker)
        self.workers.append(_Worker(self.job, self.answers))
        self.replaced += 1
        self._assign()

    def close(self) -> None:
        """End all processes; blocks that they make are not finished."""
        for worker in self.workers:
            worker.process.kill()
        for worker in self.workers:
            _end(worker)
        self.workers = []


def _end(worker: _Worker) -> int:
    """Wait for a process that ends, and close its pipe; its exit status."""
    assert worker.process.stdin is not None
    with contextlib.suppress(OSError):
        worker.process.stdin.close()
    try:
        return worker.process.wait(_LAST)
    except subprocess.TimeoutExpired:
        worker.process.kill()
        return worker.process.wait()


class ThisProcess:
    """Blocks made one after the other in this process."""

    replaced = 0

    def __init__(self, job: Job) -> None:
        self.job, self.waiting = job, deque[int]()

    @property
    def room(self) -> int:
        """Number of blocks that it takes now."""
        return 1 - len(self.waiting)

    def submit(self, block: int) -> None:
        """Have a block made."""
        self.waiting.append(block)

    def next(self, timeout: float) -> BlockReport | None:
        """Make the next block."""
        from runtime.sweeps.block import run_block

        try:
            return run_block(self.job, self.waiting.popleft())
        except KeyboardInterrupt:
            return None  # of a run that was interrupted: the signal itself is noted

    def close(self) -> None:
        """Nothing."""
