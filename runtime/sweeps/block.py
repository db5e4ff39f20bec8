"""A block of runs, the task of a sweep: the same function in every process and on every cluster."""

import threading
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from codegen.errors import SupersededError
from codegen.files.generated_modules import (
    companion_path,
    import_generated,
    read_generated,
    text_hash,
)
from runtime.core.kernel_abi import gather
from runtime.machine_facade import Machine
from runtime.mechanism.companion_modules import Origin
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.mechanism.module_tables import describe
from runtime.sweeps import block_parts, store
from runtime.sweeps.journal import TRIES, WRITING, Journal
from runtime.sweeps.member_run import KILLED, REPEATED, Row, evaluate_member, without_run
from runtime.sweeps.programs import require_programs
from runtime.sweeps.request import Request


class Job(NamedTuple):
    """All that a process needs to make blocks of a sweep."""

    store: str  # folder of the Zarr store, which all processes see
    identity: str  # of the store
    digest: str  # of the request's facts
    programs: Mapping[str, str]  # with which the sweep began
    request: Request
    module: str  # file of the generated module
    model: str  # file of the model; empty for one of a running program
    scene: str
    trials: Mapping[int, Row]  # run → row of the members that were run beforehand


class BlockReport(NamedTuple):
    """A block that is done."""

    block: int
    runs: int  # that were made for it
    simulation: float  # s of the processor in runs
    overhead: float  # s of the processor in loading, journals and writing


SAVE_SECONDS = 30.0  # safety: s of work in a block after which its rows so far are saved
_loaded: dict[str, Machine] = {}  # of this process, by the identity of the store
_alone = threading.Lock()  # of this process, which a cluster may give several threads


def load_machine(job: Job) -> Machine:
    """The machine of a job, from its generated modules.

    Raises
    ------
    SupersededError
        If one of them has changed.
    """
    path, wanted = Path(job.module), job.request.companions
    module = import_generated(path, job.request.module)
    origin = Origin(Path(job.model) if job.model else path, job.scene, path, job.request.module)
    machine = Machine(Mechanism(describe(module), gather(module), path, origin))
    found = companions_of(machine, wanted)
    changed = [kind for kind in wanted if found[kind] != wanted[kind]]
    if changed:
        raise SupersededError(
            f"{companion_path(path, changed[0])} has another text than when the sweep began. "
            "Repeat the call of the sweep."
        )
    return machine


def companions_of(machine: Machine, kinds: Iterable[str]) -> dict[str, str]:
    """SHA-256 of the companion modules of a machine, by kind; built where they are missing."""
    origin, found = machine.mechanism.origin, dict[str, str]()
    assert origin is not None
    for kind in kinds:
        getattr(machine.mechanism, kind)
        found[kind] = text_hash(read_generated(companion_path(origin.path, kind)))
    return found


def load_job(job: Job) -> Machine:
    """The machine of a job, loaded once in a process."""
    if job.identity not in _loaded:
        require_programs(job.programs)
        machine = load_machine(job)
        _loaded.clear()
        _loaded[job.identity] = machine
    return _loaded[job.identity]


def _points(group: store.Group, request: Request, runs: range) -> Any:
    """The points of these runs, (runs, factors)."""
    import numpy as np

    return np.stack([group[name][runs.start : runs.stop] for name in request.names], axis=1)


def run_block(job: Job, block: int) -> BlockReport:
    """Make the runs of a block and write their rows, its mark last.

    Runs at which other processes have ended several times are left out, with the outcome KILLED.
    """
    with _alone:
        return _run_block(job, block)


def _run_block(job: Job, block: int) -> BlockReport:
    began = time.process_time()
    journal = Journal(Path(job.store), block)
    losses = journal.losses()
    with journal:
        group = store.reopen(Path(job.store), job.identity)  # it may be another one by now
        request, runs = job.request, store.layout_of(group).runs_of(block)
        about = store.about_of(group)
        there = store.rows_made(group, request, runs)
        there |= block_parts.read_part(Path(job.store), about, request, block)
        earlier = _to_keep({run: row for run, row in there.items() if run in runs})
        trials = {run: row for run, row in job.trials.items() if run in runs}
        part = _Part(job, group, block, runs, _to_keep(trials) | earlier)
        machine, simulation = load_job(job), 0.0
        for run, point in zip(runs, _points(group, request, runs), strict=True):
            if run in part.rows:
                continue
            if losses[run] >= TRIES:
                part.rows[run] = without_run(request, KILLED, _killed(losses[run]))
                continue
            if part.is_due:
                journal.note(WRITING)
                part.save()
            journal.note(run)
            start = time.thread_time()  # of this task alone: Dask's other threads are no simulation
            part.rows[run], _ = evaluate_member(machine, request, point)
            simulation += time.thread_time() - start
        journal.note(WRITING)
        part.finish()
    overhead = time.process_time() - began - simulation
    return BlockReport(block, len(runs) - len(earlier), simulation, overhead)


def _to_keep(rows: Mapping[int, Row]) -> dict[int, Row]:
    """The rows whose runs would end the same way if they were repeated."""
    return {run: row for run, row in rows.items() if row.outcome not in REPEATED}


class _Part:
    """The rows of a block that are there, written beside it now and then where runs are slow."""

    def __init__(
        self, job: Job, group: store.Group, block: int, runs: range, rows: dict[int, Row]
    ) -> None:
        self.job, self.group, self.block, self.runs, self.rows = job, group, block, runs, rows
        self.mark, self.written = store.mark_there(group, block), time.monotonic()
        self.count = len(rows)  # of the rows that are written, or need not be

    @property
    def is_due(self) -> bool:
        """Whether rows have waited long enough to be written."""
        waiting = len(self.rows) > self.count
        return waiting and time.monotonic() - self.written > SAVE_SECONDS

    def save(self) -> None:
        """Write the rows so far beside the block, unless another process has written it."""
        self.written, self.count = time.monotonic(), len(self.rows)
        if store.mark_there(self.group, self.block) == self.mark:
            self._write_part()

    def finish(self) -> None:
        """Write the block, now that all its rows are there.

        While a block that was written before is replaced, its rows stand beside it.
        """
        path, request = Path(self.job.store), self.job.request
        if store.mark_there(self.group, self.block):
            self._write_part()
        rows = [self.rows[run] for run in self.runs]
        store.write_block(path, self.job.identity, request, self.runs, rows)
        block_parts.remove_part(path, request, self.block)

    def _write_part(self) -> None:
        """Write the rows, and those that another process has written beside the block."""
        path, request = Path(self.job.store), self.job.request
        about = store.about_of(store.reopen(path, self.job.identity))
        others = block_parts.read_part(path, about, request, self.block)
        block_parts.write_part(path, about, request, self.block, others | self.rows)


def _killed(times: int) -> str:
    return (
        f"{times} processes ended at this run: killed, out of memory, or by a fault of compiled "
        "code. The sweep goes on without it; --resume (resume=True) tries it again."
    )
