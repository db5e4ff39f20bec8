"""The blocks of a sweep are handed to processes until all are done, or somebody wants to stop."""

import math
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple, Protocol

from filelock import FileLock, Timeout

from codegen.errors import InputError, LinkwrightError
from codegen.object_display import counted
from codegen.termination_signals import SignalDeferral
from runtime.machine_facade import Machine
from runtime.progress_bar import Progress, bar
from runtime.sweeps import store
from runtime.sweeps.block import BlockReport, Job
from runtime.sweeps.design import Design
from runtime.sweeps.journal import clear_journals, working_folder
from runtime.sweeps.local_workers import LocalWorkers, ThisProcess, available_cores
from runtime.sweeps.planning import Measured
from runtime.sweeps.request import Request, differences, digest_of

BLOCK_SECONDS = 3.0  # measured: of runs in a block, beside which starting and writing is little
BLOCKS_A_WORKER = 8  # measured: at least, so that the last ones end together
LEAST_SECONDS = 1.5  # measured: of runs, below which processes would take longer to start
_SIGNALS = 0.2  # layout: s between looks for the wish to stop


class Executor(Protocol):
    """A way to have blocks made."""

    replaced: int  # processes that were lost and replaced

    def submit(self, block: int) -> None:
        """Have a block made."""

    def next(self, timeout: float) -> BlockReport | None:
        """The next report; None where there is none within so many seconds."""

    def close(self) -> None:
        """End what belongs to the sweep."""


class Execution(NamedTuple):
    """How the making of the blocks went."""

    runs: int  # made in this session
    seconds: float  # of the wall clock
    busy: float  # s of the processors in runs
    beside: float  # s of the processors of workers in all else
    blocks: int
    replaced: int  # workers that were lost
    stopped: bool  # by the user


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Keep other sweeps off a store; the folder of the work goes when all is done."""
    folder = working_folder(path)
    try:
        folder.mkdir(exist_ok=True)
        taken = FileLock(folder / "lock", timeout=0)
        taken.acquire()
    except Timeout:
        raise InputError(f"Another sweep is writing {path}. Wait until it has ended.") from None
    except OSError as error:
        raise InputError(f"{folder} cannot be written: {error.strerror}.") from error
    try:
        clear_journals(path)
        yield
    finally:
        taken.release()
        shutil.rmtree(folder, ignore_errors=True)


def require_same(path: Path, request: Request, design: Design) -> None:
    """Refuse a store of another request; the message names what differs."""
    group, facts = store.open_group(path), request.facts(design.digest)
    changes = [*differences(store.about_of(group)["facts"], facts)]
    if changes:
        raise InputError(
            f"{path} has runs of another sweep, so it cannot go on: {'; '.join(changes)}. "
            "Repeat the request as it was, or begin a store of another name."
        )


def job_of(
    path: Path, machine: Machine, request: Request, design: Design, measured: Measured,
    workers: int | None,
) -> Job:  # fmt: skip
    """The job of a store, which is created where it does not exist."""
    if not path.exists():
        count = available_cores() if workers is None else workers
        block = block_size(len(design.points), measured.seconds, count)
        store.create_store(path, request, design, measured.columns, block)
    origin = machine.mechanism.origin
    assert origin is not None
    model = str(origin.model) if isinstance(origin.model, Path) else ""
    digest = digest_of(request.facts(design.digest))
    return Job(str(path), digest, request, str(origin.path), model, request.scene)


def block_size(runs: int, seconds: float, workers: int) -> int:
    """Runs in a block: a task takes seconds, and each worker gets several."""
    by_time = BLOCK_SECONDS / max(seconds, 1e-6)
    by_share = runs / (BLOCKS_A_WORKER * max(workers, 1))
    return max(1, min(runs, math.ceil(min(by_time, by_share))))


def execute(
    job: Job, measured: Measured, *, workers: int | None, scheduler: str | None, progress: bool,
    title: str,
) -> Execution:  # fmt: skip
    """Make all blocks that are not done yet.

    Raises
    ------
    LinkwrightError
        If the processes cannot go on; what is done stays.
    """
    group = store.open_group(Path(job.store), writable=True)
    blocks, layout = store.unfinished(group), store.layout_of(group)
    began = time.perf_counter()
    if not blocks:
        return Execution(0, 0.0, 0.0, 0.0, 0, 0, stopped=False)
    with SignalDeferral(computing=True) as signals:
        executor = _executor(job, measured, len(blocks), layout, workers, scheduler)
        try:
            with bar(title, progress) as report:
                reports = _make(executor, blocks, layout, signals, report)
        except LinkwrightError as error:
            done = layout.blocks - len(store.unfinished(group))
            kept = (
                f"{done} of {counted(layout.blocks, 'block')} are done and kept in {job.store}. Go "
                "on with the same command and --resume (resume=True)."
            )
            raise LinkwrightError((*error.problems, kept)) from error
        finally:
            with suppress(OSError):
                executor.close()
        stopped = len(reports) < len(blocks)
        signals.answered = stopped
    return Execution(
        sum(one.runs for one in reports), time.perf_counter() - began,
        sum(one.busy for one in reports), sum(one.beside for one in reports), len(reports),
        executor.replaced, stopped,
    )  # fmt: skip


def _executor(
    job: Job, measured: Measured, blocks: int, layout: store.Layout, workers: int | None,
    scheduler: str | None,
) -> Executor:  # fmt: skip
    if scheduler is not None:
        from runtime.sweeps.dask_cluster import ClusterWorkers

        return ClusterWorkers(job, scheduler)
    expected = measured.seconds * min(blocks * layout.block, layout.runs)
    if workers == 0 or (workers is None and expected < LEAST_SECONDS):
        return ThisProcess(job)
    return LocalWorkers(job, min(workers or available_cores(), blocks))


def _make(
    executor: Executor, blocks: list[int], layout: store.Layout, signals: SignalDeferral,
    report: Progress,
) -> list[BlockReport]:  # fmt: skip
    """The reports of the blocks, until all are there or a signal arrives."""
    reports = dict[int, BlockReport]()
    before = layout.blocks - len(blocks)
    for block in blocks:
        executor.submit(block)
    while len(reports) < len(blocks) and not signals.arrived:
        answer = executor.next(_SIGNALS)
        if answer is not None:
            reports[answer.block] = answer
            report((before + len(reports)) / layout.blocks)
    return list(reports.values())
