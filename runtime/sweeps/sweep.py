"""A sweep: its design is checked, its machine built, a few runs measured, its blocks are made."""

import math
import os
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, nullcontext, suppress
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from filelock import FileLock, Timeout

from codegen.errors import InputError
from codegen.readers import arguments as readers
from codegen.readers.values import KindError
from runtime.machine_facade import Machine
from runtime.machine_loading import load
from runtime.processors import available_cores
from runtime.studies.harness import READERS, takes_simulation_arguments
from runtime.studies.quantity import Function
from runtime.sweeps.block import Job, clear_journals
from runtime.sweeps.design import NOTHING, Design, design_of, given_design, in_declared_units
from runtime.sweeps.execution import execute
from runtime.sweeps.factors import read_factors
from runtime.sweeps.member_run import REPEATED, Row
from runtime.sweeps.planning import attempt, estimate_of, factor_unit, plan_of, units_of
from runtime.sweeps.request import Request, differences, program_facts
from runtime.sweeps.store import Store, create_store, open_store, require_zarr
from runtime.sweeps.study import Study
from runtime.sweeps.workers import ClusterWorkers, LocalWorkers, Pool, ThisProcess

if TYPE_CHECKING:
    import xarray as xr

    from codegen import Model, Scene
    from runtime.integrate.problem import Formulation

Over = Mapping[str, Any] | Sequence[str]
_NAMES = readers.texts('("max:B.fx",)')


def _over(value: Any) -> Any:
    """A mapping, texts, or a dataset of points."""
    if isinstance(value, str):
        return (value,)
    if isinstance(value, Mapping) and all(isinstance(name, str) for name in value):
        return value
    if isinstance(value, list | tuple) and all(isinstance(text, str) for text in value):
        return tuple(value)
    raise KindError(
        'it must be factors by name, such as {"J1": "200:1000:81"}, or an xarray.Dataset of points.'
    )


def _quantities(value: Any) -> dict[str, str | Function]:
    """Texts, or texts and functions by the names of their columns.

    A series at the end, ``bob.phi``, has the column ``end:bob.phi``, as one that is kept has its
    own name.
    """
    if isinstance(value, str):
        value = (value,)
    if isinstance(value, list | tuple) and value and all(isinstance(text, str) for text in value):
        return {text if ":" in text else f"end:{text}": text for text in value}
    fits = isinstance(value, Mapping) and value
    if fits and all(
        isinstance(k, str) and (isinstance(x, str) or callable(x)) for k, x in value.items()
    ):
        return dict(value)
    raise KindError('it must be quantities, such as ["max:B.fx"] or {"peak": function}.')


BLOCK_SECONDS = 3.0  # measured: of runs in a block, beside which starting and writing is little
BLOCK_BYTES = 64 << 20  # safety: of rows in a block, which a worker has in memory twice
MOST_BLOCKS = 10_000  # safety: blocks of a sweep, of which each has a file in each array
BLOCKS_A_WORKER = 8  # measured: at least, so that the last ones end together
LEAST_SECONDS = 1.5  # measured: of runs, below which processes would take longer to start


@readers.reads(
    **{name: read for name, read in READERS.items() if name != "progress"},
    over=_over, quantities=_quantities, out=readers.path,
    sample=readers.optional(readers.text("a name")), count=readers.optional(readers.count(1)),
    seed=readers.count(0), keep=_NAMES, points=readers.count(2, 10**7),
    analysis=readers.optional(readers.text("a name")),
    workers=readers.optional(readers.count(0, 4096)),
    scheduler=readers.optional(readers.text("the address of a Dask scheduler")),
    resume=readers.flag, progress=readers.flag,
)  # fmt: skip
@takes_simulation_arguments()
def sweep(
    model: "str | os.PathLike[str] | Model", scene: "str | Scene | None" = None, *,
    over: "Over | xr.Dataset", quantities: "Sequence[str] | Mapping[str, str | Function]",
    out: str | os.PathLike[str], t_end: float | None = None, t_start: float = 0.0,
    sample: str | None = None, count: int | None = None, seed: int = 0,
    keep: Sequence[str] = (), points: int = 501, analysis: str | None = None,
    parameters: Mapping[str, float] | None = None, guess: Mapping[str, float] | None = None,
    start: Mapping[str, float] | None = None, accuracy: float | None = None,
    method: str | None = None, formulation: "Formulation | None" = None,
    rtol: float | None = None, workers: int | None = None, scheduler: str | None = None,
    resume: bool = False, folder: str | os.PathLike[str] | None = None,
    generated: str | os.PathLike[str] | None = None, progress: bool = True, **run: Any,
) -> Study:  # fmt: skip
    """Run a machine many times, with other values each time, and keep a row of each run.

    Parameters
    ----------
    model, scene, folder, generated
        As in `load`.
    over
        What varies: parameters, in the declared units, and start values, in SI units, by name →
        numbers, a text (``"200:1000:81"``, ``"225,450,900"``), an interval ``"200:1000"`` or a
        distribution ``"normal:450:20"`` or ``("normal", 450.0, 20.0)``. Or an `xarray.Dataset`
        with the points.
    quantities
        The numbers that are kept of each run: texts as in `matters`, such as ``"max:B.fx"``,
        ``"bob.phi"`` (at the end; its column is ``end:bob.phi``), ``"event:latch"``; or texts and
        functions of a result by name.
    out
        The folder of the Zarr store, ``study.zarr``, which must not exist unless `resume`.
    t_end, t_start, points
        Of each run, s; output instants, from which the quantities are taken.
    sample, count, seed
        Unless given, all combinations of the values. "lhs" (Latin hypercube), "sobol", "halton" or
        "random" draw `count` points from intervals and distributions; "saltelli", the design of
        Sobol' indices, `count` times two more than there are factors. The seed makes it the same.
    keep
        Series that are kept whole of each run, at the output instants.
    analysis
        "simulate", "kinematics", "inverse_dynamics" or "equilibrium"; unless given, it follows from
        the scene.
    parameters, guess, start
        As in the analyses, the same for all runs.
    accuracy, method, formulation, rtol
        Of a simulation, as in `simulate`, and so are atol, controllers, until, correction,
        time_scale, first_step, max_step, max_steps and max_bytes.
    workers
        Processes on this computer: unless given as many as it has cores, none for a sweep that is
        shorter than their start; 0 is this process.
    scheduler
        The address of a Dask scheduler, whose cluster makes the runs in their place.
    resume
        Whether to go on with a store of the same sweep: what is done stays.
    progress
        Whether a terminal shows a bar with the remaining time.

    Returns
    -------
    Study
        All runs. Those that fail have an outcome and a message; interrupted, a sweep returns what
        is done.

    Raises
    ------
    InputError
        If arguments make no sense, `out` exists, or `resume` finds another sweep there.
    LinkwrightError
        If the processes cannot work: a scheduler that is lost, a disk that is full. What is done
        stays, and `resume` goes on.

    Examples
    --------
    >>> study = lw.sweep(
    ...     "slider_crank", "compressor", over={"J1": "200:1000:81"}, quantities=["max:B.fx"],
    ...     t_end=1.0, out="study.zarr",
    ... )
    >>> study["max:B.fx"].max()  # N, an xarray.DataArray
    >>> study.member(3).plot("crank.omega")
    """
    require_zarr()
    path = Path(folder or ".", out).resolve()
    problems = list[str]()
    design = attempt(problems, lambda: _design(over, sample, count, seed))
    attempt(problems, lambda: _require_place(path, resume=resume))
    if path.exists() and not resume:  # nothing is loaded or compiled for a store that stays
        raise InputError(problems)
    machine = attempt(problems, lambda: load(model, scene, folder=folder, generated=generated))
    if machine is None:
        raise InputError(problems)
    settings = {
        "accuracy": accuracy, "method": method, "formulation": formulation, "rtol": rtol, **run
    }  # fmt: skip
    checked = design or NOTHING  # whatever is wrong with the points, the rest is checked as well
    given = attempt(problems, partial(in_declared_units, checked, partial(factor_unit, machine)))
    request = attempt(problems, lambda: plan_of(
        machine, given or checked, quantities=dict(quantities), keep=tuple(keep), analysis=analysis,  # type: ignore[arg-type]
        span=(t_start, t_end), points=points, values=(parameters, guess, start), settings=settings,
    ))  # fmt: skip
    if problems or given is None or request is None:
        raise InputError(problems)
    with store_lock(path):
        _require_place(path, resume=resume)  # another sweep may have begun meanwhile
        return _study(path, machine, request, given, workers, scheduler, progress=progress)


def _study(
    path: Path, machine: Machine, request: Request, design: Design, workers: int | None,
    scheduler: str | None, *, progress: bool,
) -> Study:  # fmt: skip
    """The study of a request: its store, which is created or goes on, and the runs it lacks."""
    began, is_new = time.perf_counter(), not path.exists()
    if not is_new:
        store = _same_store(path, request, design)
        blocks = store.unfinished(repeated=REPEATED)
        if not blocks:
            return Study(path, machine, request)
    with nullcontext() if scheduler is None else closing(ClusterWorkers(scheduler)) as cluster:
        estimate = None
        if is_new or any(row.reconnects for row in machine.mechanism.description.watched):
            estimate = estimate_of(machine, request, design)  # builds the scenes that are reached
        if is_new:
            assert estimate is not None
            numbers = len(request.quantities) + len(request.keep) * request.points + 2
            count = available_cores() if workers is None else workers
            size = block_size(len(design.points), estimate.seconds, count, 8 * numbers)
            units = units_of(machine, request)
            create_store(path, request, design, units, size, estimate.seconds)
            store = open_store(path)
            blocks = [*range(store.blocks)]
        job = _job_of(store, machine, request, estimate.rows if estimate else {})
        pool = cluster or _pool_of(job, store, len(blocks), workers)
        if cluster is not None:
            cluster.take(job)
        execution = execute(pool, store, blocks, f"sweep of {machine.mechanism.title}", progress)
    if estimate is not None:  # the members that were run beforehand are runs of the sweep
        execution = execution._replace(
            seconds=time.perf_counter() - began,
            simulation=execution.simulation + estimate.simulation,
            overhead=execution.overhead + estimate.overhead,
        )
    return Study(path, machine, request, execution)


def _same_store(path: Path, request: Request, design: Design) -> Store:
    """The store at a path; one of another request is refused, with what differs."""
    store = open_store(path)
    changes = [*differences(store.about["facts"], request.facts(design.digest))]
    if changes:
        raise InputError(
            f"{path} has runs of another sweep, so it cannot go on: {'; '.join(changes)}. "
            "Repeat the request as it was, or begin a store of another name."
        )
    return store


def _job_of(store: Store, machine: Machine, request: Request, trials: Mapping[int, Row]) -> Job:
    origin = machine.mechanism.origin
    assert origin is not None
    model = str(origin.model) if isinstance(origin.model, Path) else ""
    place, identity = str(store.path), store.about["identity"]
    return Job(place, identity, program_facts(), request, str(origin.path), model, trials)


def _pool_of(job: Job, store: Store, blocks: int, workers: int | None) -> Pool:
    """Who makes so many blocks: processes, unless their start would take longer than the runs."""
    expected = store.about["seconds"] * min(blocks * store.block, store.runs)
    if workers == 0 or (workers is None and expected < LEAST_SECONDS):
        return ThisProcess(job)
    # While others work: a study needs it at the end.
    threading.Thread(target=_import_ahead, args=("xarray",), daemon=True).start()
    return LocalWorkers(job, min(workers or available_cores(), blocks))


def _import_ahead(name: str) -> None:
    """Import a library in a thread; who needs it later says why that fails."""
    with suppress(Exception):
        import_module(name)


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
        clear_journals(path)
        lock.release()


def _design(over: Any, sample: str | None, count: int | None, seed: int) -> Design:
    if hasattr(over, "data_vars"):
        if sample is not None or count is not None:
            raise InputError("A dataset of points is the design: leave out sample and count.")
        return given_design(over)
    return design_of(read_factors(over), sample, count, seed)


def _require_place(path: Path, *, resume: bool) -> None:
    """Refuse a store that exists, or whose folder does not, before anything runs."""
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist.")
    if path.exists() and not resume:
        raise InputError(
            f"{path} exists, and a sweep overwrites nothing. Go on with it by --resume "
            "(resume=True), or choose another name."
        )
