"""A block of runs, the task of a sweep: the same function in every process and on every cluster.

A task notes in a journal which run it begins. A note that is left when the block is begun again
tells at which run a process ended; a run at which several have ended is not made again. The journal
is that of one session: a session that ends, by whatever, accuses no run.

A block of slow runs takes minutes. Its rows so far stand in a file of their own, its part, until
the block is written. Parts lie in the folder of an array, where no reader of Zarr looks for members
of the group.
"""

import json
import shutil
import threading
import time
import uuid
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from codegen.errors import LinkwrightError, SupersededError
from codegen.files.generated_modules import (
    companion_path,
    import_generated,
    read_generated,
    text_hash,
)
from codegen.files.whole_files import flush_folder, whole_file
from runtime.core.kernel_abi import gather
from runtime.machine_facade import Machine
from runtime.mechanism.companion_modules import Origin
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import describe
from runtime.sweeps.member_run import KILLED, REPEATED, Row, evaluate_member, without_run
from runtime.sweeps.request import Request, require_programs
from runtime.sweeps.store import DONE, Store, reopen

TRIES = 3  # safety: processes that may end at one run
SAVE_SECONDS = 30.0  # safety: s of work in a block after which its rows so far are saved
_LOADING, _WRITING = -1, -2  # notes of a journal, beside the numbers of runs
_WIDTH = 8  # layout: bytes of a note
_DAMAGE = (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error)
_loaded: dict[str, Machine] = {}  # of this process, by the identity of the store
_alone = threading.Lock()  # of this process, which a cluster may give several threads


class Job(NamedTuple):
    """All that a process needs to make blocks of a sweep."""

    store: str  # folder of the Zarr store, which all processes see
    identity: str  # of the store
    programs: Mapping[str, str]  # with which the sweep began
    request: Request
    module: str  # file of the generated module
    model: str  # file of the model; empty for one of a running program
    trials: Mapping[int, Row]  # run → row of the members that were run beforehand


class BlockReport(NamedTuple):
    """A block that is done."""

    block: int
    runs: int  # that were made for it
    simulation: float  # s of the processor in runs
    overhead: float  # s of the processor in loading, journals and writing


def run_block(job: Job, block: int) -> BlockReport:
    """Make the runs of a block and write their rows, its mark last.

    Runs at which other processes have ended several times are left out, with the outcome KILLED.
    """
    with _alone:
        return _run_block(job, block)


def _run_block(job: Job, block: int) -> BlockReport:
    began, simulation, path, request = time.process_time(), 0.0, Path(job.store), job.request
    losses = _losses(path, block)
    with _journal(path, block) as note:
        store = reopen(path, job.identity)  # it may be another one by now
        runs = store.runs_of(block)
        earlier = _to_keep(store.rows(block) | read_part(store, block))
        rows = {run: row for run, row in _to_keep(job.trials).items() if run in runs} | earlier
        machine, saved, count = load_machine(job), time.monotonic(), len(rows)
        for run, point in zip(runs, store.points(runs), strict=True):
            if run in rows:
                continue
            if losses[run] >= TRIES:
                rows[run] = without_run(request, KILLED, _killed(losses[run]))
                continue
            if len(rows) > count and time.monotonic() - saved > SAVE_SECONDS:
                note(_WRITING)
                write_part(store, block, rows)
                saved, count = time.monotonic(), len(rows)
            note(run)
            start = time.thread_time()  # of this task alone: Dask's other threads are no simulation
            rows[run] = evaluate_member(machine, request, point)
            simulation += time.thread_time() - start
        note(_WRITING)
        finish_block(store, block, rows)
    overhead = time.process_time() - began - simulation
    return BlockReport(block, len(runs) - len(earlier), simulation, overhead)


def finish_block(store: Store, block: int, rows: Mapping[int, Row]) -> None:
    """Write a block, all rows of which are there; while an older one is replaced, they stand by."""
    if store.mark(block):
        write_part(store, block, rows)
    store.write_block(block, [rows[run] for run in store.runs_of(block)])
    file = part_file(store.path, block)
    if file.exists():
        for place in store.chunks(block):
            flush_folder(place)
        file.unlink(missing_ok=True)


def _to_keep(rows: Mapping[int, Row]) -> dict[int, Row]:
    """The rows whose runs would end the same way if they were repeated."""
    return {run: row for run, row in rows.items() if row.outcome not in REPEATED}


def _killed(times: int) -> str:
    return (
        f"{times} processes ended at this run: killed, out of memory, or by a fault of compiled "
        "code. The sweep goes on without it; --resume (resume=True) tries it again."
    )


def load_machine(job: Job) -> Machine:
    """The machine of a job from its generated modules, loaded once in a process.

    Raises
    ------
    LinkwrightError
        If the programs or the modules are others than when the sweep began.
    """
    if job.identity in _loaded:
        return _loaded[job.identity]
    require_programs(job.programs)
    path, request = Path(job.module), job.request
    module = import_generated(path, request.module)
    origin = Origin(Path(job.model) if job.model else path, request.scene, path, request.module)
    machine = Machine(Mechanism(describe(module), gather(module), path, origin))
    found = companions_of(machine, request.companions)
    for kind, digest in request.companions.items():
        if found[kind] != digest:
            raise SupersededError(
                f"{companion_path(path, kind)} has another text than when the sweep began. "
                "Repeat the call of the sweep."
            )
    _loaded.clear()
    _loaded[job.identity] = machine
    return machine


def companions_of(machine: Machine, kinds: Iterable[str]) -> dict[str, str]:
    """SHA-256 of the companion modules of a machine, by kind; built where they are missing."""
    origin, found = machine.mechanism.origin, dict[str, str]()
    assert origin is not None
    for kind in kinds:
        getattr(machine.mechanism, kind)
        found[kind] = text_hash(read_generated(companion_path(origin.path, kind)))
    return found


def working_folder(path: Path) -> Path:
    """The folder of the journals, next to a store."""
    return path.with_name(f"{path.name}.working")


def clear_journals(path: Path) -> None:
    """Forget what the tasks of a session have noted."""
    shutil.rmtree(working_folder(path), ignore_errors=True)


def _losses(path: Path, block: int) -> Counter[int]:
    """Run, or _LOADING or _WRITING → processes that ended there."""
    found: Counter[int] = Counter()
    for file in working_folder(path).glob(f"{block}-*"):
        content = file.read_bytes()
        found[int.from_bytes(content, "little", signed=True) if content else _LOADING] += 1
    for place, word in ((_LOADING, "loaded the machine"), (_WRITING, "wrote its rows")):
        if found[place] >= TRIES:
            raise LinkwrightError(
                f"{found[place]} processes ended while one {word} (block {block}): they "
                "were killed, or lack memory or rights. Nothing that is done is lost."
            )
    return found


@contextmanager
def _journal(path: Path, block: int) -> Iterator[Callable[[int], None]]:
    """A function that notes where this task is, in a file that outlives the process alone."""
    folder = working_folder(path)
    folder.mkdir(parents=True, exist_ok=True)
    place = folder / f"{block}-{uuid.uuid4().hex}"
    try:
        with place.open("wb", buffering=0) as file:

            def note(run: int) -> None:
                file.seek(0)
                file.write(run.to_bytes(_WIDTH, "little", signed=True))

            note(_LOADING)
            yield note
    finally:
        place.unlink(missing_ok=True)  # an exception accuses no run
    for other in folder.glob(f"{block}-*"):
        other.unlink(missing_ok=True)


def part_file(path: Path, block: int) -> Path:
    """The file of a block's part, in the folder of the parts of a store."""
    return path / DONE / "parts" / f"{block}.npz"


def write_part(store: Store, block: int, rows: Mapping[int, Row]) -> None:
    """Replace the part of a block by these rows, run → row; the older one stays where that fails.

    Raises
    ------
    InputError
        If it cannot be written, by a disk that is full, or another store lies there by now.
    """
    reopen(store.path, store.about["identity"])
    rows = read_part(store, block) | dict(rows)  # another process may make the same block
    numbers = np.array([(*r.quantities, r.t_last, *r.series.ravel()) for r in rows.values()])
    texts = json.dumps([(row.outcome, row.message) for row in rows.values()])
    path = part_file(store.path, block)
    path.parent.mkdir(exist_ok=True)
    with whole_file(path) as place, place.open("wb") as file:
        np.savez(file, seal=store.seal, runs=[*rows], numbers=numbers, texts=texts)


def read_part(store: Store, block: int) -> dict[int, Row]:
    """Run → row of the part of a block; nothing where there is none, or it is of another sweep."""
    try:
        with (
            part_file(store.path, block).open("rb") as file,
            np.load(file, allow_pickle=False) as part,
        ):
            seal, runs, numbers, texts = (part[n] for n in ("seal", "runs", "numbers", "texts"))
        if str(seal) != store.seal:
            return {}
        last = len(store.columns) - 1
        rows = zip(runs.tolist(), numbers, json.loads(str(texts)), strict=True)
        return {
            run: Row(row[:last], outcome, message, float(row[last]),
                     row[last + 1 :].reshape(-1, store.instants))
            for run, row, (outcome, message) in rows
        }  # fmt: skip
    except _DAMAGE:
        return {}


def remove_parts(path: Path) -> None:
    """Remove what is left of parts in a store whose blocks are all written."""
    shutil.rmtree(path / DONE / "parts", ignore_errors=True)
