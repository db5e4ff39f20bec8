"""The runs of a sweep are handed to a pool in tasks until all are made, or the user stops it."""

import math
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from itertools import chain
from typing import NamedTuple

import numpy as np

from codegen.errors import LinkwrightError
from codegen.object_display import counted
from codegen.termination_signals import SignalDeferral
from runtime.progress_bar import bar
from runtime.sweeps.design import FloatArray
from runtime.sweeps.request import KILLED, Request, Rows, rows_without_runs
from runtime.sweeps.store import Integers, Store
from runtime.sweeps.workers import TRIES, Pool

TASK_SECONDS = 3.0  # measured: of runs in a task, beside which handing out and writing is little
CHUNK_BYTES = 64 << 20  # safety: of rows in a file, which a process has in memory twice
MOST_CHUNKS = 10_000  # safety: files of a column
TASKS_A_WORKER = 8  # measured: at least, so that the last ones end together
_MOST_KILLED = 50  # safety: runs that may end their workers without another row between them
_SIGNALS = 0.2  # layout: s between looks for a signal to stop


class Execution(NamedTuple):
    """How the making of the runs went."""

    runs: int  # made in this session
    seconds: float  # of the wall clock
    lost: int  # workers that were replaced


def file_sizes(runs: int, seconds: float, workers: int, row: int) -> tuple[int, int]:
    """Runs of a task, and of a file, which has one task or more.

    A task takes seconds, each worker gets several, and its rows fit in memory; `seconds` is the
    time of a run, `row` the bytes of its row. Of many slow runs a file has several tasks.
    """
    by_time = TASK_SECONDS / max(seconds, 1e-6)
    by_share = runs / (TASKS_A_WORKER * max(workers, 1))
    most = max(1, min(runs, CHUNK_BYTES // max(row, 1)))
    size = max(1, min(most, math.ceil(min(by_time, by_share))))
    return size, min(most, max(size, math.ceil(runs / MOST_CHUNKS)))


def tasks_of(runs: Integers, chunk: int, size: int) -> list[range]:
    """Runs as ranges of at most `size`, each of one file of `chunk` runs."""
    places = runs // chunk * chunk + runs % chunk // size
    cuts = np.flatnonzero((np.diff(runs) != 1) | (np.diff(places) != 0)) + 1
    parts = np.split(runs, cuts) if len(runs) else []
    return [range(int(part[0]), int(part[-1]) + 1) for part in parts]


def execute(
    pool: Pool, store: Store, points: FloatArray, tried: Sequence[tuple[Integers, Rows]],
    tasks: Sequence[range], title: str, progress: bool,
) -> tuple[int, int]:  # fmt: skip
    """Have a pool make the runs of tasks, and write rows as they come, those beforehand first.

    Returns the number of runs that were made, and of workers that were lost.

    Raises
    ------
    LinkwrightError
        If the workers cannot go on, or the store cannot be written; what is done stays.
    """
    made, runs, lost = 0, store.about.runs, Counter[range]()
    total = sum(map(len, tasks)) + sum(len(runs) for runs, _ in tried)
    try:
        with SignalDeferral(computing=True) as signals, bar(title, progress) as report:
            others = _made_rows(pool, store.request, points, tasks, signals, lost)
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
    pool: Pool, request: Request, points: FloatArray, tasks: Sequence[range],
    signals: SignalDeferral, lost: Counter[range],
) -> Iterator[tuple[range, Rows]]:  # fmt: skip
    """Runs and their rows, as they are made, until all are there or a signal arrives.

    A task whose worker has ended is made again in halves, so that a run at which processes end is
    soon alone; where it has ended several, it is not made again.
    """
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
                if len(runs) > 1:
                    half = len(runs) // 2
                    waiting.extendleft((runs[half:], runs[:half]))
                    continue
                if lost[runs] < TRIES:
                    waiting.appendleft(runs)
                    continue
                killed += 1
                if killed > _MOST_KILLED:
                    raise LinkwrightError(
                        f"{killed} runs in a row have ended their workers ({error}): they were "
                        "killed, or lack memory or rights."
                    ) from error
                rows = rows_without_runs(
                    request, 1, KILLED,
                    f"{TRIES} processes ended at this run: killed, out of memory, or by a fault of "
                    "compiled code. The sweep goes on without it; --resume (resume=True) tries it "
                    "again.",
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
