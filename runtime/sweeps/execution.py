"""The runs of a sweep are handed to a pool in tasks until all are made, or the user stops it.

A pool takes the points of a task and returns the future of their rows: it is this process, others
on this computer, or a Dask cluster.

A process that is killed breaks a `ProcessPoolExecutor` with all that waits in it; it and a local
cluster of Dask import the user's script again, which therefore needs a guard. The workers of a Dask
cluster need Linkwright, and see the folder of the generated modules by the same path.
"""

import json
import math
import os
import pickle
import platform
import queue
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from functools import lru_cache
from importlib import import_module, util
from itertools import chain
from typing import Any, BinaryIO

import numpy as np

from codegen.errors import InputError, LinkwrightError, SupersededError, module_of_extra
from codegen.object_display import counted
from codegen.termination_signals import SignalDeferral
from runtime.core.arrays import Integers, Matrix
from runtime.machine_facade import Machine
from runtime.progress_bar import bar
from runtime.sweeps.request import (
    KILLED,
    PROCESSOR,
    Request,
    Rows,
    changed_programs,
    companion_texts,
    evaluate_members,
    program_facts,
    rows_without_runs,
)
from runtime.sweeps.store import Store

START = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from runtime.sweeps.execution import serve
serve()
"""
"""Program of a worker process; its argument is the path of modules of its parent."""
_TRIES = 3  # safety: processes that may end at one run, or before they begin
_MOST_KILLED = 50  # safety: runs that may end their workers without another row between them
_SIGNALS = 0.2  # layout: s between looks for a signal to stop
_MOST_TASKS = 2048  # safety: tasks that are handed out at a time, more than any cluster's cores
_PATIENCE = 10.0  # safety: s in which a scheduler must answer
_WORKER_PATIENCE = 30.0  # measured: s without a report, after which workers are asked for
_alone = threading.Lock()  # of this process, which a cluster may give several threads


class LostWorkerError(LinkwrightError):
    """The worker that made a task has ended."""


class Pool:
    """Tasks made one after the other in this process, as they are submitted."""

    room = 1  # tasks that it takes at a time
    lost: Any = LostWorkerError  # of which the future of a task raises one whose worker has ended

    def __init__(self, machine: Machine, request: Request) -> None:
        self.machine, self.request = machine, request

    def submit(self, points: Matrix) -> "Future[Rows]":
        """Have the runs of some points made, (runs, factors)."""
        future = Future[Rows]()
        try:
            future.set_result(evaluate_members(self.machine, self.request, points))
        except BaseException as error:
            future.set_exception(error)
        return future

    def check(self) -> None:
        """Raise LinkwrightError where nothing will come any more; called while nothing does."""

    def close(self) -> None:
        """End what belongs to the sweep; tasks that are being made are not finished."""


def pickled_job(machine: Machine, request: Request) -> bytes:
    """What another process needs to make runs; InputError where a function cannot go there."""
    library = "cloudpickle" if util.find_spec("cloudpickle") else "pickle"
    try:
        return bytes(import_module(library).dumps((request, machine, program_facts())))
    except Exception as error:
        raise InputError(
            f"The functions of this sweep cannot be sent to another process ({error}). Define them "
            "at the top level of a module, or run with workers=0, in this process."
        ) from error


@lru_cache(maxsize=1)
def _load_job(job: bytes) -> tuple[Machine, Request]:
    """The machine and the request of a job, by the sweep's own programs, on any processor."""
    request, machine, programs = pickle.loads(job)
    changes = [x for x in changed_programs(programs) if not x.startswith(PROCESSOR)]
    if changes:
        raise LinkwrightError(
            f"A worker on {platform.node() or 'another computer'} has other programs than the "
            f"sweep: {'; '.join(changes)}. Install the same ones there, and start it again."
        )
    _ = machine.kernels  # which are loaded now
    if companion_texts(machine, [*request.companions]) != request.companions:
        raise SupersededError(
            f"The companions of {machine.path} ({', '.join(request.companions)}) have another text "
            "than when the sweep began. Repeat the call of the sweep."
        )
    return machine, request


def run_job(job: bytes, points: Matrix) -> Rows:
    """The rows of some points, in any process; of none, the machine is loaded."""
    with _alone:
        machine, request = _load_job(job)
        return evaluate_members(machine, request, points)


class LocalWorkers(Pool):
    """So many processes on this computer; a thread waits for each, and replaces it if it ends."""

    def __init__(self, machine: Machine, request: Request, count: int) -> None:
        super().__init__(machine, request)
        self.job, self.closed, self.room = pickled_job(machine, request), False, 2 * count
        self.processes = set[subprocess.Popen[bytes]]()
        self.own = threading.local()  # the process of each thread
        self.threads = ThreadPoolExecutor(count, "sweep")

    def submit(self, points: Matrix) -> "Future[Rows]":
        """Have runs made, once a process is free."""
        return self.threads.submit(self._make, points)

    def _make(self, points: Matrix) -> Rows:
        self.own.process = getattr(self.own, "process", None) or self._start()
        rows = _ask(self.own.process, points)
        if rows is None:
            ended, self.own.process = self.own.process, None
            raise LostWorkerError(f"A worker has ended with status {self._end(ended)}.")
        return rows

    def _start(self) -> "subprocess.Popen[bytes]":
        """A process that has loaded the machine, and that no key of a terminal ends."""
        command, status = [sys.executable, "-P", "-c", START, json.dumps(sys.path)], 0
        for _ in range(_TRIES):
            process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
            )
            self.processes.add(process)
            if self.closed:
                process.kill()
            if _ask(process, self.job) is not None:
                return process
            status = self._end(process)
        raise LinkwrightError(
            f"{_TRIES} worker processes ended before they could begin, the last with status "
            f"{status}. Run with --workers 0, in this process, to see why."
        )

    def _end(self, process: "subprocess.Popen[bytes]") -> int:
        """End a process, whose exit status is returned."""
        self.processes.discard(process)
        with suppress(OSError), process:  # which closes its pipes, on which it ends by itself
            pass
        return process.returncode

    def close(self) -> None:
        """End all processes."""
        self.closed = True
        for process in [*self.processes]:
            process.kill()
        self.threads.shutdown(cancel_futures=True)
        for process in [*self.processes]:
            self._end(process)


def _ask(process: "subprocess.Popen[bytes]", order: Any) -> Rows | None:
    """The answer of a worker process to an order; None where it has ended."""
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        pickle.dump(order, process.stdin)
        process.stdin.flush()
        answer = pickle.load(process.stdout)
    except (OSError, EOFError, ValueError, pickle.UnpicklingError):  # perhaps within an answer
        return None
    if isinstance(answer, str):
        raise LinkwrightError(answer)
    return answer  # type: ignore[no-any-return]


def serve() -> None:
    """Be a worker process: make runs until the pipe to the starting process is closed.

    The first order is a job, the others are points. It ends as soon as the starting process has
    ended, however that was.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    incoming, outgoing = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a function of the user's own prints is none of our answers
    orders: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(incoming, orders), daemon=True).start()
    job, points = orders.get(), np.zeros((0, 0))
    while True:
        answer: Rows | str
        try:
            answer = run_job(job, points)
        except LinkwrightError as error:
            answer = str(error)
        except Exception as error:
            answer = f"{type(error).__name__}: {error}"
        with suppress(OSError):  # nobody is there any more who would read it
            pickle.dump(answer, outgoing)
            outgoing.flush()
        points = orders.get()


def _listen(stream: BinaryIO, orders: "queue.SimpleQueue[Any]") -> None:
    try:
        while True:
            orders.put(pickle.load(stream))
    except BaseException:
        os._exit(1)  # nobody is there for whom to finish a task


class ClusterWorkers(Pool):
    """The workers of a Dask scheduler at an address."""

    room = _MOST_TASKS

    def __init__(self, machine: Machine, request: Request, address: str) -> None:
        super().__init__(machine, request)
        self.job, self.address = pickled_job(machine, request), address
        distributed = module_of_extra("distributed", "sweep", "A cluster needs Dask")
        self.lost = distributed.KilledWorker
        try:
            self.client = distributed.Client(address, timeout=_PATIENCE, set_as_default=False)
        except Exception as error:
            raise InputError(
                f"No Dask scheduler answers at {address} ({error}). Start one, dask scheduler, and "
                "give the address that it prints (--scheduler tcp://HOST:8786)."
            ) from error
        self.tasks = self.client.get_executor(pure=False, retries=0)
        self.last_worker = time.monotonic()  # when the cluster had a worker last; inf: said already

    def submit(self, points: Matrix) -> "Future[Rows]":
        """Have runs made by a worker of the cluster."""
        future: Future[Rows] = self.tasks.submit(run_job, self.job, points)
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
            self.tasks.shutdown(wait=False)
        if self.client.status != "closed":
            self.client.close(timeout=_PATIENCE)


def execute(
    pool: Pool, store: Store, points: Matrix, tried: Sequence[tuple[Integers, Rows]],
    tasks: Sequence[range], progress: bool,
) -> tuple[int, int]:  # fmt: skip
    """Have a pool make the runs of tasks, and write rows as they come, those beforehand first.

    Returns the number of runs that were made, and of workers that were lost.

    Raises LinkwrightError if the workers cannot go on, or the store cannot be written; what is done
    stays.
    """
    made, runs, lost = 0, store.about.runs, Counter[range]()
    title = f"sweep of {pool.request.model}"
    total = sum(map(len, tasks)) + sum(len(runs) for runs, _ in tried)
    try:
        with SignalDeferral(computing=True) as signals, bar(title, progress) as report:
            others = _made_rows(pool, points, tasks, signals, lost)
            found: Iterator[tuple[range | Integers, Rows]] = chain(tried, others)
            for task, rows in found:
                store.write(task, rows)
                made += len(task)
                report(1.0 - (total - made) / runs)
            signals.answered = made < total
    except Exception as error:
        what = f"{type(error).__name__}: {error}"
        if isinstance(error, OSError):
            what = f"{store.path} cannot be written: {error}."
        problems = error.problems if isinstance(error, LinkwrightError) else (what,)
        kept = (
            f"{runs - total + made} of {counted(runs, 'run')} are done and kept in {store.path}. "
            "Go on with the same command and --resume (resume=True)."
        )
        raise LinkwrightError((*problems, kept)) from error
    return made, lost.total()


def _made_rows(
    pool: Pool, points: Matrix, tasks: Sequence[range], signals: SignalDeferral,
    lost: Counter[range],
) -> Iterator[tuple[range, Rows]]:  # fmt: skip
    """Runs and their rows, as they are made, until all are there or a signal arrives."""
    waiting, running, killed = deque(tasks), dict[Future[Rows], range](), 0
    while (waiting or running) and not signals.arrived:
        while waiting and len(running) < pool.room and not signals.arrived:
            runs = waiting.popleft()
            running[pool.submit(points[runs.start : runs.stop])] = runs
        done, _ = wait(running, _SIGNALS, FIRST_COMPLETED)
        for future in done:
            runs = running.pop(future)
            try:
                rows = future.result()
                killed = 0
            except pool.lost as error:
                lost[runs] += 1
                if len(runs) > 1:  # so that a run at which processes end is soon alone
                    half = len(runs) // 2
                    waiting.extendleft((runs[half:], runs[:half]))
                    continue
                if lost[runs] < _TRIES:
                    waiting.appendleft(runs)
                    continue
                killed += 1
                if killed > _MOST_KILLED:
                    raise LinkwrightError(
                        f"{killed} runs in a row have ended their workers ({error}): they were "
                        "killed, or lack memory or rights."
                    ) from error
                rows = rows_without_runs(
                    pool.request, 1, KILLED,
                    f"{_TRIES} processes ended at this run: killed, out of memory, or by a fault "
                    "of compiled code. The sweep goes on without it; --resume (resume=True) tries "
                    "it again.",
                )  # fmt: skip
            except CancelledError:
                pool.check()
                raise
            except KeyboardInterrupt:  # of a run in this process: the signal itself is noted
                return
            made, rest = runs[: len(rows.outcomes)], runs[len(rows.outcomes) :]
            if rest:  # of slow runs
                waiting.appendleft(rest)
            yield made, rows
        if not done:
            pool.check()
