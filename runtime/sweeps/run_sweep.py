"""A sweep: its design is checked, its machine built, one run measured, and its blocks are made."""

import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codegen.errors import InputError
from codegen.readers import arguments as readers
from codegen.readers.values import KindError
from runtime.machine_facade import Machine
from runtime.machine_loading import load
from runtime.studies.harness import READERS, takes_simulation_arguments
from runtime.studies.quantity import Function
from runtime.sweeps import store
from runtime.sweeps.design import NOTHING, Design, design_of, given_design, in_declared_units
from runtime.sweeps.execution import begin_store, execute, job_of, require_same, store_lock
from runtime.sweeps.factors import read_factors
from runtime.sweeps.member_run import REPEATED, Row
from runtime.sweeps.planning import Estimate, attempt, estimate_of, factor_unit, plan_of
from runtime.sweeps.request import Request
from runtime.sweeps.study import Study

if TYPE_CHECKING:
    import xarray as xr

    from codegen import Model, Scene
    from runtime.integrate.problem import Formulation
    from runtime.sweeps.dask_cluster import ClusterWorkers

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
    store.require_zarr()
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
    trials: Mapping[int, Row] = {}
    blocks: list[int] | None = None
    estimate: Estimate | None = None
    began = time.perf_counter()
    if path.exists():
        require_same(path, request, design)
        blocks = store.unfinished(store.open_group(path), repeated=REPEATED)
        if not blocks:
            return Study(path, machine, request)
    with _cluster(scheduler) as cluster:
        if blocks is None:
            estimate = estimate_of(machine, request, design)
            begin_store(path, request, design, estimate, workers)
            trials, blocks = estimate.rows, [*range(store.layout_of(store.open_group(path)).blocks)]
        elif any(row.reconnects for row in machine.mechanism.description.watched):
            estimate = estimate_of(machine, request, design)  # builds the scenes that are reached
            trials = estimate.rows
        execution = execute(
            job_of(path, machine, request, design, trials), blocks, workers=workers,
            cluster=cluster, progress=progress, title=f"sweep of {machine.mechanism.title}",
        )  # fmt: skip
    if estimate is not None:  # the members that were run beforehand are runs of the sweep
        execution = execution._replace(
            seconds=time.perf_counter() - began,
            simulation=execution.simulation + estimate.simulation,
            overhead=execution.overhead + estimate.overhead,
        )
    return Study(path, machine, request, execution)


@contextmanager
def _cluster(address: str | None) -> "Iterator[ClusterWorkers | None]":
    """The workers of a scheduler, which import their programs meanwhile; None without one."""
    if address is None:
        yield None
        return
    from runtime.sweeps.dask_cluster import ClusterWorkers

    workers = ClusterWorkers(address)
    try:
        yield workers
    finally:
        with suppress(OSError):
            workers.close()


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
