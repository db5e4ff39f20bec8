"""The plan of a sweep: a request that is checked, all problems at once; a few runs, measured."""

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from itertools import chain
from typing import Any, TypeVar

import numpy as np

from codegen.errors import InputError, LinkwrightError, UnknownNameError
from runtime.core.kinds import ANALYSES, analysis_name, analysis_title
from runtime.integrate.method import IMPLICIT
from runtime.machine_facade import Machine
from runtime.mechanism.table_rows import unknown
from runtime.studies.harness import (
    analysis_of,
    read_simulation_arguments,
    refuse_simulation_arguments,
    require_time_span,
)
from runtime.studies.quantity import Function, declared_unit
from runtime.sweeps.design import FloatArray
from runtime.sweeps.request import Request, Rows, companion_texts, evaluate_members
from runtime.sweeps.store import Integers, name_problems

Answer = TypeVar("Answer")
_TRIAL_SECONDS = 0.5  # measured: s of the processor after which a mean time of runs is known
_TRIALS = 5  # measured: members that are run beforehand
_SLOW_SECONDS = 10.0  # measured: s of a first run, beside which loading and compiling is little


def plan_request(
    machine: Machine, factors: tuple[str, ...], *, quantities: Mapping[str, str | Function],
    series: tuple[str, ...], analysis: str | None, span: tuple[float, float | None],
    instants: int, values: tuple[Mapping[str, float] | None, ...], settings: Mapping[str, Any],
) -> Request:  # fmt: skip
    """The request of a sweep.

    Raises
    ------
    InputError
        With everything that is wrong with it.
    """
    about, problems = machine.description, list[str]()
    kind, t_start = analysis_name(analysis or "") or analysis_of(machine), span[0]
    parameters, guess, start = (dict(given or {}) for given in values)
    for name in factors:
        if name in {**parameters, **start}:
            problems.append(
                f"{name} varies, and has one value as well (parameters, start): leave out one of "
                "them."
            )
    if kind not in ANALYSES:
        problems.append(f"There is no analysis {kind!r}; there are: {', '.join(ANALYSES)}.")
    attempt(problems, lambda: machine.parameter_values(parameters))
    options = attempt(problems, lambda: read_simulation_arguments(machine, settings)) or {}
    if kind in ANALYSES and kind != "simulate":
        attempt(problems, lambda: refuse_simulation_arguments(
            options, machine.mechanism.title, analysis_title(kind)
        ))  # fmt: skip
    t_end = None
    if kind != "equilibrium":
        t_end = attempt(problems, lambda: require_time_span(machine, t_start, span[1]))
    for given in quantities.values():
        if isinstance(given, str):
            attempt(problems, partial(declared_unit, given, about))
    rows = [attempt(problems, partial(about.series.find, name)) for name in series]
    kept = tuple(row.name for row in rows if row)  # `strut.force` of ``force(strut)``
    problems += name_problems([*factors, *quantities, *kept])
    if problems:
        raise InputError(problems)
    assert machine.mechanism.origin is not None
    return Request(
        model=f"{about.model}/{about.scene}", generated_module=machine.mechanism.origin.digest,
        companions=_companions(machine, kind, options), analysis=kind, factors=factors,
        start_values=tuple(name for name in factors if name not in machine.parameters.names),
        quantities=dict(quantities), series=kept, t_start=t_start,
        t_end=t_start if t_end is None else t_end, instants=instants, parameters=parameters,
        guess=guess, start=start, options=options,
    )  # fmt: skip


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
    machine: Machine, request: Request, points: FloatArray, runs: Integers
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
