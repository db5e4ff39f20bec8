"""A sweep: its request is checked, its machine built, a few runs measured, the others made."""

import os
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing, suppress
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from codegen.errors import InputError, LinkwrightError, UnknownNameError
from codegen.object_display import counted
from codegen.readers import arguments as readers
from codegen.readers.values import KindError
from runtime.core.arrays import Integers, Matrix
from runtime.integrate.method import IMPLICIT
from runtime.machine_facade import Machine
from runtime.machine_loading import load
from runtime.mechanism.table_rows import unknown
from runtime.processors import available_cores
from runtime.studies.harness import (
    READERS,
    analysis_of,
    read_simulation_arguments,
    require_time_span,
    takes_simulation_arguments,
)
from runtime.studies.quantity import Function, declared_unit
from runtime.sweeps.design import Design, read_design
from runtime.sweeps.execution import ClusterWorkers, LocalWorkers, Pool, execute
from runtime.sweeps.request import (
    MEMORY,
    Request,
    Rows,
    companion_texts,
    differences,
    evaluate_members,
)
from runtime.sweeps.store import (
    create_store,
    file_sizes,
    name_problems,
    open_store,
    require_zarr,
    store_lock,
    tasks_of,
)
from runtime.sweeps.study import Study
from runtime.validation.arguments import check

if TYPE_CHECKING:
    import xarray as xr

    from codegen import Model, Scene
    from runtime.integrate.problem import Formulation


Answer = TypeVar("Answer")
Over = Mapping[str, Any] | Sequence[str]
_NAMES = readers.texts('("max:B.fx",)')
_LEAST_SECONDS = 1.5  # measured: s of runs, below which processes would take longer to start
_TRIAL_SECONDS = 0.5  # measured: s of the processor after which a mean time of runs is known
_TRIALS = 5  # measured: members that are run beforehand
_SLOW_SECONDS = 10.0  # measured: s of a first run, beside which loading and compiling are short


def _over(value: Any) -> Any:
    """A mapping, texts, or a dataset of points."""
    if isinstance(value, str):
        return (value,)
    if isinstance(value, Mapping | list | tuple) and all(isinstance(x, str) for x in value):
        return value
    raise KindError(
        'it must be factors by name, such as {"J1": "200:1000:81"}, or an xarray.Dataset of points.'
    )


def _quantities(value: Any) -> dict[str, str | Function]:
    """Texts, or texts and functions, by columns: that of ``bob.phi`` is ``end:bob.phi``."""
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


@readers.reads(**READERS | {
    "over": _over, "quantities": _quantities, "out": readers.path,
    "sample": readers.optional(readers.text("a name")),
    "count": readers.optional(readers.count(1)), "seed": readers.count(0), "keep": _NAMES,
    "points": readers.count(2, 10**7), "workers": readers.optional(readers.count(0, 4096)),
    "scheduler": readers.optional(readers.text("the address of a Dask scheduler")),
    "resume": readers.flag, "progress": readers.flag,
})  # fmt: skip
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
    """Run a machine many times, with different values each time, and keep a row for each run.

    Parameters
    ----------
    model, scene, folder, generated
        As in `load`.
    over
        Parameters and start values that vary, in SI units or with a unit, by name →
        numbers, a text (``"200:1000:81"``, ``"225,450,900"``), an interval ``"200:1000"`` or a
        distribution ``"normal:450:20"`` or ``("normal", 450.0, 20.0)``. Or an `xarray.Dataset` with
        the points.
    quantities
        The numbers that each row has: texts as in `matters`, such as ``"max:B.fx"``, ``"bob.phi"``
        (at the end; its column is ``end:bob.phi``), ``"event:latch"``; or texts and functions of a
        result by name.
    out
        The folder of the Zarr store, ``study.zarr``, which must not exist unless `resume`.
    t_end, t_start, points
        Last and first instant of each run, s; number of output instants, for the quantities.
    sample, count, seed
        By default all combinations of the values. "lhs" (Latin hypercube), "sobol", "halton" or
        "random" draw `count` points from intervals and distributions; "saltelli", the design of
        Sobol' indices, draws `count` · (factors + 2). The same seed draws the same points.
    keep
        Series of which each run keeps all values at the output instants.
    analysis
        "simulate", "kinematics", "inverse_dynamics" or "equilibrium"; unless given, it follows from
        the scene.
    parameters, guess, start
        As in the analyses, the same for all runs.
    accuracy, method, formulation, rtol
        For simulations, as in `simulate`; also atol, controllers, until, correction, time_scale,
        first_step, max_step, max_steps and max_bytes.
    workers
        Processes on this computer; with 0 the calling process makes the runs. By default one for
        each core, or 0 if a sweep takes less time than the start of processes.
    scheduler
        The address of a Dask scheduler, whose cluster makes the runs in place of `workers`.
    resume
        Whether to go on with a store of the same sweep, whose finished runs remain.
    progress
        Whether a terminal shows a bar with the remaining time.

    Returns
    -------
    Study
        All runs. Runs that fail have an outcome and a message; an interrupted sweep returns the
        finished runs.

    Raises
    ------
    InputError
        If arguments make no sense, `out` exists, or `resume` finds another sweep there.
    LinkwrightError
        If the processes cannot work, for example after the loss of the scheduler or with a full
        disk. Finished runs remain, and `resume` goes on.

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
    about, kind = machine.description, analysis or analysis_of(machine)
    design = attempt(problems, lambda: read_design(
        over, sample, count, seed, partial(factor_unit, machine)
    ))  # fmt: skip
    factors = tuple(design[0].factors) if design else ()
    problems += [
        f"{name} varies, and has one value as well (parameters, start): leave out one of them."
        for name in factors if name in {**(parameters or {}), **(start or {})}
    ]  # fmt: skip
    values = attempt(problems, lambda: check(
        machine.mechanism, {"parameters": parameters, "guess": guess, "start": start or {}},
        start_has_values=True,
    )) or {}  # fmt: skip
    attempt(problems, lambda: machine.parameter_values(values.get("parameters")))
    run |= {"accuracy": accuracy, "method": method, "formulation": formulation, "rtol": rtol}
    options = attempt(problems, lambda: read_simulation_arguments(machine, run, kind)) or {}
    last = attempt(problems, lambda: require_time_span(machine, kind, t_start, t_end))
    wanted: dict[str, str | Function] = dict(quantities)  # type: ignore[arg-type]
    for given in wanted.values():
        if isinstance(given, str):
            attempt(problems, partial(declared_unit, given, about))
    rows = [attempt(problems, partial(about.series.find, name)) for name in keep]
    kept = tuple(row.name for row in rows if row)  # `strut.force` of ``force(strut)``
    problems += name_problems([*factors, *wanted, *kept])
    if problems or design is None:
        raise InputError(problems)
    assert machine.mechanism.origin is not None
    request = Request(
        model=about.title, generated_module=machine.mechanism.origin.digest,
        companions=_companions(machine, kind, options), analysis=kind, factors=factors,
        start_values=tuple(name for name in factors if name not in machine.parameters.names),
        quantities=wanted, series=kept, t_start=t_start,
        t_end=t_start if last is None else last, instants=points,
        **{word: given or {} for word, given in values.items()}, options=options,
    )  # fmt: skip
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
    path: Path, machine: Machine, request: Request, design: Design, points: Matrix,
    workers: int | None, scheduler: str | None, *, progress: bool,
) -> Study:  # fmt: skip
    """The study of a request: its store, which is created or goes on, and the runs it lacks."""
    began, todo, seconds, tried = time.perf_counter(), np.arange(len(points)), None, []
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
        if MEMORY not in rows.outcomes:  # which a worker may have
            todo, tried = todo[~np.isin(todo, runs)], [(runs, rows)]
    cores = available_cores() if workers is None else workers
    numbers = len(request.quantities) + len(request.series) * request.instants + 1
    size, chunk = file_sizes(len(points), seconds, cores, 8 * numbers)
    tasks = tasks_of(todo, chunk if store is None else store.about.chunk, size)
    pool = Pool(machine, request)
    if scheduler is not None:
        pool = ClusterWorkers(machine, request, scheduler)
    elif tasks and cores and (workers or seconds * len(todo) > _LEAST_SECONDS):
        pool = LocalWorkers(machine, request, min(cores, len(tasks)))
    with closing(pool):
        if store is None:
            units = units_of(machine, request)
            create_store(path, request, design, points, units, chunk, seconds)
            store = open_store(path, "r+")
        made, lost = execute(pool, store, points, tried, tasks, progress)
    note = f"{counted(made, 'run')} in {time.perf_counter() - began:.1f} s"
    note += f"; {counted(lost, 'lost worker')} replaced" if lost else ""
    return Study(path, machine, request, note)


def attempt(problems: list[str], read: Callable[[], Answer]) -> Answer | None:
    """The answer of a check; None where it fails, with its problems added to the others."""
    try:
        return read()
    except InputError as error:
        problems += [text for text in error.problems if text not in problems]
        return None


def factor_unit(machine: Machine, name: str) -> str:
    """The unit of a factor, of a parameter the declared one; InputError where it varies nothing."""
    title = machine.mechanism.title
    if name in machine.description.unused:
        raise InputError(
            f"{title}: nothing that takes part depends on parameter {name}, so that its values "
            "would make no difference. Leave it out."
        )
    units = {row.name: row.unit for row in machine.coordinates}
    units |= {row.velocity: row.velocity_unit for row in machine.coordinates}
    units |= dict.fromkeys(machine.description.spins, "rad/s")
    units |= {row.name: row.unit for row in machine.parameters}
    if name not in units:
        raise UnknownNameError(f"{title}: {unknown('parameter or coordinate', name, units)}")
    return units[name]


def units_of(machine: Machine, request: Request) -> dict[str, str]:
    """The units of all columns, by name."""
    about = machine.description
    units = {name: factor_unit(machine, name) for name in request.factors}
    units |= {name: about.series.find(name).unit for name in request.series}
    texts = {name: text for name, text in request.quantities.items() if isinstance(text, str)}
    return units | {name: declared_unit(text, about) for name, text in texts.items()}


def try_members(
    machine: Machine, request: Request, points: Matrix, runs: Integers
) -> tuple[float, Integers, Rows]:
    """Seconds of the processor that a run takes; a few of the runs, and their rows.

    All that is built on demand is there then.
    """
    tried = runs[np.unique(np.linspace(0, len(runs) - 1, _TRIALS).astype(int))]
    times, rows = list[float](), list[Rows]()
    for run in tried.tolist():
        started = time.process_time()
        rows.append(evaluate_members(machine, request, points[run : run + 1]))
        times.append(time.process_time() - started)
        slow = times[0] > _SLOW_SECONDS
        if slow or sum(times[1:]) > _TRIAL_SECONDS:
            break
    seconds = float(np.mean(times if slow else times[1:] or times))  # the first one compiles
    numbers, series, outcomes, messages = zip(*rows, strict=True)
    texts = ([*chain.from_iterable(column)] for column in (outcomes, messages))
    joined = Rows(np.concatenate(numbers), np.concatenate(series), *texts)
    return seconds, tried[: len(rows)], joined


def _companions(machine: Machine, kind: str, options: Mapping[str, Any]) -> dict[str, str]:
    """SHA-256 of the modules that the options take, built so that no worker does."""
    if kind != "simulate":
        return {}
    if options.get("accuracy") is None:
        if options.get("formulation") == "reduced":
            return companion_texts(machine, ("reduced",))
        implicit = options.get("method") in {*IMPLICIT, "auto"}
        return companion_texts(machine, ("tangents",) if implicit else ())
    found = dict[str, str]()
    for name in ("reduced", "tangents"):
        with suppress(LinkwrightError):  # of a scene that has none
            found |= companion_texts(machine, (name,))
    return found
