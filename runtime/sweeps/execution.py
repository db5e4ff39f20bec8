"""The blocks of a sweep are handed to processes until all are done, or the user stops it."""

import math
import shutil
import threading
import time
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Protocol

from filelock import FileLock, Timeout

from codegen.errors import InputError, LinkwrightError
from codegen.object_display import counted
from codegen.termination_signals import SignalDeferral
from runtime.machine_facade import Machine
from runtime.processors import available_cores
from runtime.progress_bar import Progress, bar
from runtime.sweeps import store
from runtime.sweeps.block import BlockReport, Job
from runtime.sweeps.block_parts import remove_parts
from runtime.sweeps.design import Design
from runtime.sweeps.journal import clear_journals, working_folder
from runtime.sweeps.local_workers import LocalWorkers, ThisProcess
from runtime.sweeps.member_run import Row
from runtime.sweeps.planning import Estimate
from runtime.sweeps.programs import program_facts
from runtime.sweeps.request import Request, differences, digest_of
from runtime.sweeps.store_attributes import Layout
from runtime.sweeps.store_template import create_store

if TYPE_CHECKING:
    from runtime.sweeps.dask_cluster import ClusterWorkers

BLOCK_SECONDS = 3.0  # measured: of runs in a block, beside which starting and writing is little
BLOCK_BYTES = 64 << 20  # safety: of rows in a block, which a worker has in memory twice
MOST_BLOCKS = 10_000  # safety: blocks of a sweep, of which each has a file in each array
BLOCKS_A_WORKER = 8  # measured: at least, so that the last ones end together
LEAST_SECONDS = 1.5  # measured: of runs, below which processes would take longer to start
_SIGNALS = 0.2  # layout: s between looks for a signal to stop


class Executor(Protocol):
    """A way to have blocks made."""

    replaced: int  # processes that were lost and replaced

    @property
    def room(self) -> int:
        """Number of blocks that it takes now."""

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
    simulation: float  # s of the processors in runs
    overhead: float  # s of the processors of workers in all else
    blocks: int
    replaced: int  # workers that were lost
    stopped: bool  # by the user


@contextmanager
def store_lock(path: Path) -> Iterator[None]:
    """Keep other sweeps off a store; the folder of the journals goes when all is done.

    The file of the lock stays: were it removed, two sweeps could lock two files of its name.
    """
    place = path.with_name(f".{path.name}.lock")
    lock = FileLock(place, timeout=0)
    try:
        lock.acquire()
    except Timeout:
        raise InputError(f"Another sweep is writing {path}. Wait until it has ended.") from None
    except OSError as error:
        raise InputError(f"{place} cannot be written: {error.strerror or error}.") from error
    try:
        clear_journals(path)
        yield
    finally:
        shutil.rmtree(working_folder(path), ignore_errors=True)
        lock.release()


def require_same(path: Path, request: Request, design: Design) -> None:
    """Refuse a store of another request; the message names what differs."""
    group, facts = store.open_group(path), request.facts(design.digest)
    changes = [*differences(store.about_of(group)["facts"], facts)]
    if changes:
        raise InputError(
            f"{path} has runs of another sweep, so it cannot go on: {'; '.join(changes)}. "
            "Repeat the request as it was, or begin a store of another name."
        )


def begin_store(
    path: Path, request: Request, design: Design, estimate: Estimate, workers: int | None
) -> None:
    """Create the store of a sweep, its blocks by the time of a run."""
    count = available_cores() if workers is None else workers
    numbers = len(request.quantities) + len(request.keep) * request.points + 2
    block = block_size(len(design.points), estimate.seconds, count, 8 * numbers)
    create_store(path, request, design, estimate.columns, block, estimate.seconds)


def job_of(
    path: Path, machine: Machine, request: Request, design: Design, trials: Mapping[int, Row]
) -> Job:
    """The job of a store; `trials` are rows of members that were run beforehand."""
    identity = store.about_of(store.open_group(path))["identity"]
    origin = machine.mechanism.origin
    assert origin is not None
    model = str(origin.model) if isinstance(origin.model, Path) else ""
    digest = digest_of(request.facts(design.digest))
    return Job(
        str(path), identity, digest, program_facts(), request, str(origin.path), model,
        request.scene, trials,
    )  # fmt: skip


def block_size(runs: int, seconds: float, workers: int, row: int) -> int:
    """Runs in a block: a task takes seconds, each worker gets several, and its rows fit in memory.

    `seconds` is the time of a run, `row` the bytes of its row. Of many slow runs a block has more,
    and takes longer: so many files would burden a file system.
    """
    by_time = BLOCK_SECONDS / max(seconds, 1e-6)
    by_share = runs / (BLOCKS_A_WORKER * max(workers, 1))
    by_bytes = BLOCK_BYTES // max(row, 1)
    wanted = max(min(by_time, by_share), runs / MOST_BLOCKS)
    return max(1, min(runs, by_bytes, math.ceil(wanted)))


def execute(
    job: Job, blocks: list[int], *, workers: int | None, cluster: "ClusterWorkers | None",
    progress: bool, title: str,
) -> Execution:  # fmt: skip
    """Make these blocks of a store.

    Raises
    ------
    LinkwrightError
        If the processes cannot go on, or rows do not arrive in the store; what is done stays.
    """
    path = Path(job.store)
    about = store.about_of(group := store.open_group(path))
    layout = store.layout_of(group)
    began = time.perf_counter()
    with SignalDeferral(computing=True) as signals:
        expected = about["seconds"] * min(len(blocks) * layout.block, layout.runs)
        executor = _executor(job, expected, len(blocks), workers, cluster)
        if not isinstance(executor, ThisProcess):  # while others work: a study needs it at the end
            threading.Thread(target=_import_ahead, args=("xarray",), daemon=True).start()
        with _advice(path, layout):
            try:
                with bar(title, progress) as report:
                    reports = _make(executor, blocks, layout, signals, report)
            finally:
                with suppress(OSError):
                    executor.close()
            _require_rows(path, [one.block for one in reports])
        stopped = len(reports) < len(blocks)
        if not stopped:
            remove_parts(path)
        signals.answered = stopped
    return Execution(
        sum(one.runs for one in reports), time.perf_counter() - began,
        sum(one.simulation for one in reports), sum(one.overhead for one in reports), len(reports),
        executor.replaced, stopped,
    )  # fmt: skip


def _import_ahead(name: str) -> None:
    """Import a library in a thread; who needs it later says why that fails."""
    with suppress(Exception):
        import_module(name)


@contextmanager
def _advice(path: Path, layout: Layout) -> Iterator[None]:
    """Add to an error what is done, and how to go on."""
    try:
        yield
    except (LinkwrightError, OSError) as error:
        problems = (
            error.problems if isinstance(error, LinkwrightError)
            else (f"{path} cannot be written: {error.strerror or error}.",)
        )  # fmt: skip
        try:
            done = layout.blocks - len(store.unfinished(store.open_group(path)))
        except InputError as damage:  # the store is no more
            raise LinkwrightError((*problems, *damage.problems)) from error
        kept = (
            f"{done} of {counted(layout.blocks, 'block')} are done and kept in {path}. Go on with "
            "the same command and --resume (resume=True)."
        )
        raise LinkwrightError((*problems, kept)) from error


def _require_rows(path: Path, blocks: list[int]) -> None:
    """Refuse to end where rows that were made are not in the store."""
    missing = store.unfinished(store.open_group(path), blocks)
    if missing:
        raise LinkwrightError(
            f"{counted(len(missing), 'block')} of {path} are not whole though they were made, "
            f"the first is {missing[0]}: another program has changed the store, or the disk fails."
        )


def _executor(
    job: Job, expected: float, blocks: int, workers: int | None, cluster: "ClusterWorkers | None"
) -> Executor:
    """Who makes the blocks, of which all runs are expected to take so many seconds."""
    if cluster is not None:
        cluster.take(job)
        return cluster
    if workers == 0 or (workers is None and expected < LEAST_SECONDS):
        return ThisProcess(job)
    return LocalWorkers(job, min(workers or available_cores(), blocks))


def _make(
    executor: Executor, blocks: list[int], layout: Layout, signals: SignalDeferral,
    report: Progress,
) -> list[BlockReport]:  # fmt: skip
    """The reports of the blocks, until all are there or a signal arrives."""
    reports, waiting = dict[int, BlockReport](), deque(blocks)
    before = layout.blocks - len(blocks)
    while len(reports) < len(blocks):
        while waiting and executor.room > 0 and not signals.arrived:
            executor.submit(waiting.popleft())
        if signals.arrived:
            break
        answer = executor.next(_SIGNALS)
        if answer is not None:
            reports[answer.block] = answer
            report((before + len(reports)) / layout.blocks)
    return list(reports.values())
