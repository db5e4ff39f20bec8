"""A block of runs, the task of a sweep: the same function in every process and on every cluster."""

import threading
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from codegen.errors import SupersededError
from codegen.generated_module_signature_and_import import (
    companion_path,
    import_generated,
    read_generated,
    text_hash,
)
from runtime.core.kernel_abi import gather
from runtime.machine_facade import Machine
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.mechanism.module_tables import describe
from runtime.mechanism.tangents_and_reduced_modules import Origin
from runtime.sweeps import store
from runtime.sweeps.journal import TRIES, WRITING, Journal
from runtime.sweeps.member_run import KILLED, Row, evaluate_member, without_run
from runtime.sweeps.programs import require_programs
from runtime.sweeps.request import Request
from runtime.sweeps.store_attributes import Layout


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


class BlockReport(NamedTuple):
    """A block that is done."""

    block: int
    runs: int
    simulation: float  # s of the processor in runs
    overhead: float  # s of the processor in loading, journals and writing


class Member(NamedTuple):
    """A machine that is loaded for a job, the job's points, and its blocks."""

    machine: Machine
    points: Any  # (runs, factors)
    layout: Layout


_loaded: dict[str, Member] = {}  # of this process, by the identity of the store
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


def load_job(job: Job) -> Member:
    """The machine and the points of a job, loaded once in a process."""
    group = store.reopen(Path(job.store), job.identity)  # each time: it may be another one by now
    if job.identity not in _loaded:
        require_programs(job.programs)
        machine = load_machine(job)
        _loaded.clear()
        _loaded[job.identity] = Member(machine, _points(group, job.request), store.layout_of(group))
    return _loaded[job.identity]


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
    losses = journal.losses()
    with journal:
        machine, points, layout = load_job(job)
        runs, rows, request, simulation = layout.runs_of(block), list[Row](), job.request, 0.0
        for run in runs:
            if losses[run] >= TRIES:
                rows.append(without_run(request, KILLED, _killed(losses[run])))
                continue
            journal.note(run)
            start = time.thread_time()  # of this task alone: Dask's other threads are no simulation
            rows.append(evaluate_member(machine, request, points[run]))
            simulation += time.thread_time() - start
        journal.note(WRITING)
        store.write_block(Path(job.store), job.identity, request, runs, rows)
    return BlockReport(block, len(runs), simulation, time.process_time() - began - simulation)


def _killed(times: int) -> str:
    return (
        f"{times} processes ended at this run: killed, out of memory, or by a fault of compiled "
        "code. The sweep goes on without it; --resume (resume=True) tries it again."
    )
