"""A block of runs, the task of a sweep: the same function in every process and on every cluster."""

import threading
import time
from pathlib import Path
from typing import Any, NamedTuple

from codegen.errors import InputError
from codegen.generated_module_signature_and_import import import_generated
from runtime.core.kernel_abi import gather
from runtime.machine_facade import Machine
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.mechanism.module_tables import describe
from runtime.mechanism.tangents_and_reduced_modules import Origin
from runtime.sweeps import store
from runtime.sweeps.journal import TRIES, WRITING, Journal
from runtime.sweeps.member_run import KILLED, OK, Row, evaluate_member, without_run
from runtime.sweeps.request import Request


class Job(NamedTuple):
    """All that a process needs to make blocks of a sweep."""

    store: str  # folder of the Zarr store, which all processes see
    digest: str  # of the request's facts
    request: Request
    module: str  # file of the generated module
    model: str  # file of the model; empty for one of a running program
    scene: str


class BlockReport(NamedTuple):
    """A block that is done."""

    block: int
    runs: int
    failures: int
    busy: float  # s of the processor in runs
    beside: float  # s of the processor in loading, journals and writing


class Member(NamedTuple):
    """A machine that is loaded for a job, its store and its points."""

    machine: Machine
    group: store.Group
    points: Any  # (runs, factors)


_loaded: dict[tuple[str, str], Member] = {}  # of this process
_alone = threading.Lock()  # of this process, which a cluster may give several threads


def load_machine(job: Job) -> Machine:
    """The machine of a job, from its generated module; SupersededError if that has changed."""
    path = Path(job.module)
    module = import_generated(path, job.request.module)
    origin = Origin(Path(job.model) if job.model else path, job.scene, path, job.request.module)
    return Machine(Mechanism(describe(module), gather(module), path, origin))


def load_job(job: Job) -> Member:
    """The machine and the store of a job, loaded once in a process."""
    key = job.store, job.digest
    if key not in _loaded:
        group = store.open_group(Path(job.store), writable=True)
        if store.about_of(group)["digest"] != job.digest:
            raise InputError(f"{job.store} is the store of another sweep by now.")
        _loaded.clear()
        _loaded[key] = Member(load_machine(job), group, _points(group, job.request))
    return _loaded[key]


def _points(group: store.Group, request: Request) -> Any:
    import numpy as np

    return np.stack([group[name][:] for name in request.names], axis=1)


def run_block(job: Job, block: int) -> BlockReport:
    """Make the runs of a block and write their rows, its mark last.

    Runs at which other processes have ended several times are left out, with the outcome KILLED.
    """
    with _alone:
        return _run_block(job, block)


def _run_block(job: Job, block: int) -> BlockReport:
    began = time.process_time()
    journal = Journal(Path(job.store), block)
    ends = journal.ends()
    with journal:
        machine, group, points = load_job(job)
        runs, request = store.layout_of(group).runs_of(block), job.request
        rows: list[Row] = []
        busy = 0.0
        for run in runs:
            if ends[run] >= TRIES:
                rows.append(without_run(request, KILLED, _killed(ends[run])))
                continue
            journal.note(run)
            start = time.thread_time()  # of this task alone: Dask's other threads are no simulation
            rows.append(evaluate_member(machine, request, points[run]))
            busy += time.thread_time() - start
        journal.note(WRITING)
        store.write_block(group, request, runs, rows)
    failures = sum(row.outcome != OK for row in rows)
    beside = time.process_time() - began - busy
    return BlockReport(block, len(runs), failures, busy, beside)


def _killed(times: int) -> str:
    return (
        f"{times} processes ended at this run: killed, out of memory, or by a fault of compiled "
        "code. The sweep goes on without it."
    )
