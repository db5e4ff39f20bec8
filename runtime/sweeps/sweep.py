"""A sweep: its request is checked, its machine built, a few runs measured, the others made."""

import math
import os
from collections.abc import Mapping, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import InputError
from codegen.readers import arguments as readers
from codegen.readers.values import KindError
from runtime.machine_facade import Machine
from runtime.machine_loading import load
from runtime.processors import available_cores
from runtime.studies.harness import READERS, takes_simulation_arguments
from runtime.studies.quantity import Function
from runtime.sweeps.design import Design, FloatArray, read_design
from runtime.sweeps.execution import execute, tasks_of
from runtime.sweeps.planning import attempt, factor_unit, plan_request, try_members, units_of
from runtime.sweeps.request import Request, differences
from runtime.sweeps.store import create_store, open_store, require_zarr, store_lock
from runtime.sweeps.study import Study
from runtime.sweeps.workers import ClusterWorkers, LocalWorkers, Pool, pickled_job

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


TASK_SECONDS = 3.0  # measured: of runs in a task, beside which handing out and writing is little
CHUNK_BYTES = 64 << 20  # safety: of rows in a file, which a process has in memory twice
MOST_CHUNKS = 10_000  # safety: files of a column
TASKS_A_WORKER = 8  # measured: at least, so that the last ones end together
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
    path, problems = Path(folder or ".", out).resolve(), list[str]()
    attempt(problems, lambda: _require_place(path, resume=resume))
    if problems and path.exists():  # nothing is loaded or compiled for a store that stays
        raise InputError(problems)
    machine = load(model, scene, folder=folder, generated=generated)
    settings = {
        "accuracy": accuracy, "method": method, "formulation": formulation, "rtol": rtol, **run
    }  # fmt: skip
    design = attempt(problems, lambda: read_design(
        over, sample, count, seed, partial(factor_unit, machine)
    ))  # fmt: skip
    request = attempt(problems, lambda: plan_request(
        machine, tuple(design[0].factors) if design else (), quantities=dict(quantities),  # type: ignore[arg-type]
        series=tuple(keep), analysis=analysis, span=(t_start, t_end), instants=points,
        values=(parameters, guess, start), settings=settings,
    ))  # fmt: skip
    if problems or design is None or request is None:
        raise InputError(problems)
    with store_lock(path):
        _require_place(path, resume=resume)  # another sweep may have begun meanwhile
        return _study(path, machine, request, *design, workers, scheduler, progress=progress)


def _require_place(path: Path, *, resume: bool) -> None:
    """Refuse a store that exists, or whose folder does not, before anything runs."""
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist.")
    if path.exists() and not resume:
        raise InputError(
            f"{path} exists, and a sweep overwrites nothing. Go on with it by --resume "
            "(resume=True), or choose another name."
        )


def _study(
    path: Path, machine: Machine, request: Request, design: Design, points: FloatArray,
    workers: int | None, scheduler: str | None, *, progress: bool,
) -> Study:  # fmt: skip
    """The study of a request: its store, which is created or goes on, and the runs it lacks."""
    todo, seconds, tried = np.arange(len(points)), None, []
    store = open_store(path, "r+") if path.exists() else None
    if store is not None:
        changes = [*differences(store.about.facts, request.facts(points))]
        if changes:
            raise InputError(
                f"{path} has runs of another sweep, so it cannot go on: {'; '.join(changes)}. "
                "Repeat the request as it was, or begin a store of another name."
            )
        todo, seconds = store.unmade(), store.about.seconds
        if not len(todo):
            return Study(path, machine, request)
    if seconds is None or any(row.reconnects for row in machine.mechanism.description.watched):
        seconds, runs, rows = try_members(machine, request, points, todo)
        todo, tried = np.setdiff1d(todo, runs), [(runs, rows)]
    cores = available_cores() if workers is None else workers
    numbers = len(request.quantities) + len(request.series) * request.instants + 1
    size, chunk = file_sizes(len(points), seconds, cores, 8 * numbers)
    tasks = tasks_of(todo, chunk if store is None else store.about.chunk, size)
    pool = Pool(machine, request)
    if scheduler is not None:
        pool = ClusterWorkers(pickled_job(machine, request), scheduler)
    elif tasks and cores and (workers or seconds * len(todo) > LEAST_SECONDS):
        pool = LocalWorkers(pickled_job(machine, request), min(cores, len(tasks)))
    with closing(pool):
        if store is None:
            units = units_of(machine, request)
            create_store(path, request, design, points, units, chunk, seconds)
            store = open_store(path, "r+")
        title = f"sweep of {machine.mechanism.title}"
        execution = execute(pool, store, points, tried, tasks, title, progress)
    return Study(path, machine, request, execution)


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
