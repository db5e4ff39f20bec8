"""Who makes the blocks of a sweep: this process, worker processes, or a Dask cluster.

Each is a pool, which takes blocks and returns futures of their reports.

Why not a pool of the standard library, or a local cluster of Dask: a process that is killed breaks
a `ProcessPoolExecutor` with everything that waits in it; both start processes that import the
user's script again, which therefore needs a guard; and neither says at which task a process ended.

The workers of a Dask cluster need Linkwright in their environment, and see the folders of the store
and of the generated modules by the same paths.
"""

import json
import math
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from importlib import import_module, util
from typing import Any, BinaryIO, Protocol

from codegen.errors import InputError, LinkwrightError
from runtime.sweeps.block import TRIES, BlockReport, Job, run_block

START = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from runtime.sweeps.workers import serve
serve()
"""
"""Program of a worker process; its argument is the path of modules of its parent."""
_MOST_TASKS = 2048  # safety: blocks that are handed out at a time, more than any cluster's cores
_PATIENCE = 10.0  # safety: s in which a scheduler must answer
_WORKER_PATIENCE = 30.0  # measured: s without a report, after which workers are asked for


class LostWorkerError(LinkwrightError):
    """The worker that made a block has ended."""


class Pool(Protocol):
    """A way to have blocks made."""

    room: int  # blocks that it takes at a time
    lost: Any  # the class of the error that the future of a block raises whose worker has ended

    def submit(self, block: int) -> "Future[BlockReport]":
        """Have a block made."""

    def check(self) -> None:
        """Raise LinkwrightError where nothing will come any more; called while nothing does."""

    def close(self) -> None:
        """End what belongs to the sweep; blocks that are being made are not finished."""


class ThisProcess:
    """Blocks made one after the other in this process, as they are submitted."""

    room, lost = 1, LostWorkerError

    def __init__(self, job: Job) -> None:
        self.job = job

    def submit(self, block: int) -> "Future[BlockReport]":
        """Make a block."""
        future = Future[BlockReport]()
        try:
            future.set_result(run_block(self.job, block))
        except Exception as error:
            future.set_exception(error)
        return future

    def check(self) -> None:
        """Nothing."""

    def close(self) -> None:
        """Nothing."""


def pickled(job: Job) -> bytes:
    """A job for another process; InputError where a function of the user's own cannot go there."""
    library = "cloudpickle" if util.find_spec("cloudpickle") else "pickle"
    try:
        return bytes(import_module(library).dumps(job))
    except Exception as error:
        raise InputError(
            f"The functions of this sweep cannot be sent to another process ({error}). Define them "
            "at the top level of a module, or run with workers=0, in this process."
        ) from error


class LocalWorkers:
    """So many processes on this computer; a thread waits for each, and replaces it if it ends."""

    room, lost = _MOST_TASKS, LostWorkerError

    def __init__(self, job: Job, count: int) -> None:
        self.job, self.closed = pickled(job), False
        self.processes = set[subprocess.Popen[bytes]]()
        self.own = threading.local()  # the process of each thread
        self.threads = ThreadPoolExecutor(count, "sweep")

    def submit(self, block: int) -> "Future[BlockReport]":
        """Have a block made, once a process is free."""
        return self.threads.submit(self._make, block)

    def _make(self, block: int) -> BlockReport:
        process = getattr(self.own, "process", None) or self._start()
        self.own.process = process
        word, content = _ask(process, pickle.dumps(block))
        if word == "ended":
            self.own.process = None
            raise LostWorkerError(f"The worker of block {block} has ended: {content}")
        if word == "error":
            raise LinkwrightError(content)
        assert isinstance(content, BlockReport)
        return content

    def _start(self) -> "subprocess.Popen[bytes]":
        """A process that has taken the job."""
        command = [sys.executable, "-P", "-c", START, json.dumps(sys.path)]
        kinds: dict[str, Any] = {"process_group": 0} if os.name == "posix" else {}
        content: Any = None
        for _ in range(TRIES):
            process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, **kinds
            )
            self.processes.add(process)
            if self.closed:
                process.kill()
            word, content = _ask(process, self.job)
            if word == "ready":
                return process
            self.processes.discard(process)
        raise LinkwrightError(
            f"{TRIES} worker processes ended before they could begin, the last with {content}. "
            "Run with --workers 0, in this process, to see why."
        )

    def check(self) -> None:
        """Nothing: a thread hears when its process ends."""

    def close(self) -> None:
        """End all processes."""
        self.closed = True
        for process in [*self.processes]:
            process.kill()
        self.threads.shutdown(cancel_futures=True)
        for process in self.processes:
            _end(process)


def _ask(process: "subprocess.Popen[bytes]", content: bytes) -> tuple[str, Any]:
    """The answer of a worker process to what is pickled; "ended" and its status where it ends."""
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        process.stdin.write(content)
        process.stdin.flush()
        word, answer = pickle.load(process.stdout)
        return word, answer
    except (OSError, EOFError, ValueError, pickle.UnpicklingError):  # perhaps within an answer
        return "ended", f"status {_end(process)}"


def _end(process: "subprocess.Popen[bytes]") -> int:
    """End a process, and close its pipes; its exit status."""
    for stream in (process.stdin, process.stdout):
        assert stream is not None
        with suppress(OSError):
            stream.close()  # on which it ends by itself
    try:
        return process.wait(1.0)
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()


def serve() -> None:
    """Be a worker process: make blocks until the pipe to the starting process is closed.

    It ends as soon as that process has ended, however that was.
    """
    for name in ("SIGINT", "SIGHUP"):  # those of the terminal are for the starting process
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    incoming, outgoing = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a function of the user's own prints is none of our answers
    orders: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(incoming, orders), daemon=True).start()
    job = orders.get()
    _answer(outgoing, "ready", None)
    while True:
        try:
            _answer(outgoing, "done", run_block(job, orders.get()))
        except LinkwrightError as error:
            _answer(outgoing, "error", str(error))
        except Exception as error:
            _answer(outgoing, "error", f"{type(error).__name__}: {error}")


def _answer(stream: BinaryIO, word: str, content: Any) -> None:
    with suppress(OSError):  # nobody is there any more who would read it
        pickle.dump((word, content), stream)
        stream.flush()


def _listen(stream: BinaryIO, orders: "queue.SimpleQueue[Any]") -> None:
    try:
        while True:
            orders.put(pickle.load(stream))
    except BaseException:
        os._exit(1)  # nobody is there for whom to finish a block


class ClusterWorkers:
    """The workers of a Dask scheduler at an address."""

    room = _MOST_TASKS

    def __init__(self, address: str) -> None:
        try:
            import distributed
        except ImportError as error:
            raise InputError(
                "A cluster needs Dask, which is not installed. Run pip install "
                "'linkwright[sweep]', in the checkout pip install '.[sweep]'."
            ) from error
        self.address, self.lost = address, distributed.KilledWorker
        make: Any = distributed.Client  # which has no types
        self.client: Any = None
        try:
            self.client = make(address, timeout=_PATIENCE, set_as_default=False)
            self.first = [  # workers import their programs while the sweep is planned
                self.client.submit(import_programs, workers=[worker], pure=False)
                for worker in self.client.nthreads()
            ]
        except Exception as error:
            if self.client is not None:
                with suppress(Exception):
                    self.client.close(timeout=_PATIENCE)
            raise InputError(
                f"No Dask scheduler answers at {address} ({error}). Start one, dask scheduler, and "
                "give the address that it prints (--scheduler tcp://HOST:8786)."
            ) from error
        self.blocks = self.client.get_executor(pure=False, retries=0)
        self.last_worker = time.monotonic()  # when the cluster had a worker last; inf: said already

    def take(self, job: Job) -> None:
        """Make blocks of this job from now on."""
        self.job = pickled(job)

    def submit(self, block: int) -> "Future[BlockReport]":
        """Have a block made by a worker of the cluster."""
        future: Future[BlockReport] = self.blocks.submit(run_pickled, self.job, block)
        return future

    def check(self) -> None:
        """Raise LinkwrightError if the scheduler is lost; warn once where there are no workers."""
        if self.client.status != "running":
            raise LinkwrightError(f"The Dask scheduler at {self.address} does not answer any more.")
        if time.monotonic() - self.last_worker < _WORKER_PATIENCE:
            return
        if self.client.nthreads():
            self.last_worker = time.monotonic()
            return
        self.last_worker = math.inf
        warnings.warn(
            f"The cluster at {self.address} has no workers; the sweep waits for them. Start some: "
            f"dask worker {self.address} --nthreads 1.",
            stacklevel=2,
        )

    def close(self) -> None:
        """Cancel what is not done, and leave the cluster as it is."""
        if self.client.status == "running":
            self.blocks.shutdown(wait=False)
        if self.client.status != "closed":
            self.client.close(timeout=_PATIENCE)


def import_programs() -> None:
    """Import in a worker what its first block needs."""
    for name in ("runtime.dynamics.connected_simulation", "zarr"):
        import_module(name)


def run_pickled(job: bytes, block: int) -> BlockReport:
    """A block of a job that travels as it does to local processes."""
    return run_block(pickle.loads(job), block)
