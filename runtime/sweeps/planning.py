"""The plan of a sweep: the request is checked, all problems at once, and one run is measured."""

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, NamedTuple, TypeVar

import numpy as np

from codegen.errors import InputError, LinkwrightError
from runtime.core.kinds import ANALYSES, analysis_name, analysis_title
from runtime.integrate.method import IMPLICIT
from runtime.machine_facade import Machine
from runtime.mechanism.module_tables import Description
from runtime.mechanism.table_rows import unknown
from runtime.studies.harness import (
    analysis_of,
    read_simulation_arguments,
    refuse_simulation_arguments,
    require_time_span,
)
from runtime.studies.quantity import Function, declared_unit
from runtime.sweeps.block import companions_of
from runtime.sweeps.design import Design
from runtime.sweeps.member_run import Row, evaluate_member
from runtime.sweeps.request import Request
from runtime.sweeps.store import name_problems

Answer = TypeVar("Answer")
_TRIAL_SECONDS = 0.5  # measured: s of the processor after which a mean time of runs is known
_TRIALS = 5  # measured: members that are run beforehand
_SLOW_SECONDS = 10.0  # measured: s of a first run, beside which loading and compiling is little
_MOST_BYTES = 1 << 16  # safety: of series of these members, which travel with each task


def plan_of(
    machine: Machine, design: Design, *, quantities: Mapping[str, str | Function],
    keep: tuple[str, ...], analysis: str | None, span: tuple[float, float | None], points: int,
    values: tuple[Mapping[str, float] | None, ...], settings: Mapping[str, Any],
) -> Request:  # fmt: skip
    """The request of a sweep.

    Raises
    ------
    InputError
        With everything that is wrong with it.
    """
    about, mechanism = machine.description, machine.mechanism
    kind, t_start = analysis_name(analysis or "") or analysis_of(machine), span[0]
    parameters, guess, start = (dict(given or {}) for given in values)
    problems = list[str]()
    starts = _starts(machine, design, problems)
    problems += _given_again(design, parameters, start)
    if kind not in ANALYSES:
        problems.append(f"There is no analysis {kind!r}; there are: {', '.join(ANALYSES)}.")
    attempt(problems, lambda: machine.parameter_values(parameters))
    options = attempt(problems, lambda: _words(machine, kind, settings)) or {}
    t_end = t_start
    if kind != "equilibrium":
        t_end = attempt(problems, lambda: require_time_span(machine, t_start, span[1])) or t_start
    problems += _columns_problems(machine, design, quantities, keep)
    if problems:
        raise InputError(problems)
    assert mechanism.origin is not None
    return Request(
        about.model, about.scene, mechanism.origin.digest, kind, design.names, starts,
        dict(quantities), _own_names(about, keep),
        float(t_start), float(t_end), points, parameters, guess, start, options,
        _companions(machine, kind, options),
    )  # fmt: skip


def attempt(problems: list[str], read: Callable[[], Answer]) -> Answer | None:
    """The answer of a check; None where it fails, with its problems added to the others."""
    try:
        return read()
    except InputError as error:
        problems += [text for text in error.problems if text not in problems]
        return None


def _words(machine: Machine, kind: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """The options of a simulation that are given; refused where nothing is integrated."""
    words = read_simulation_arguments(machine, settings)
    if kind in ANALYSES and kind != "simulate":
        refuse_simulation_arguments(words, machine.mechanism.title, analysis_title(kind))
    return words


def _starts(machine: Machine, design: Design, problems: list[str]) -> tuple[str, ...]:
    """The factors that are start values; sentences for those that are nothing at all."""
    parameters, title = machine.parameters.names, machine.mechanism.title
    states = [name for row in machine.coordinates for name in (row.name, row.velocity)]
    starts = tuple(n for n in design.names if n not in parameters and n in states)
    for name in design.names:
        if name in machine.description.unused:
            problems.append(
                f"{title}: nothing that takes part depends on parameter {name}, so that its values "
                "would make no difference. Leave it out."
            )
        elif name not in parameters and name not in states:
            known = [*parameters, *states]
            problems.append(f"{title}: {unknown('parameter or coordinate', name, known)}")
    return starts


def _given_again(design: Design, *given: Mapping[str, float]) -> list[str]:
    return [
        f"{name} varies, and has one value as well (parameters, start): leave out one of them."
        for name in design.names
        if any(name in values for values in given)
    ]


def _columns_problems(
    machine: Machine, design: Design, quantities: Mapping[str, str | Function],
    keep: tuple[str, ...],
) -> list[str]:  # fmt: skip
    """Sentences about quantities that cannot be read, series that do not exist, names twice."""
    about, problems = machine.description, list[str]()
    for given in quantities.values():
        if isinstance(given, str):
            attempt(problems, partial(declared_unit, given, about))
    for name in keep:
        attempt(problems, partial(about.series.find, name))
    names = [*design.names, *quantities, *_own_names(about, keep)]
    return [*problems, *name_problems(names)]


def _own_names(about: Description, names: tuple[str, ...]) -> tuple[str, ...]:
    """The names of series as tables have them: `strut.force` of ``force(strut)``."""
    rows = [about.series.get(name) for name in names]
    return tuple(row.name if row else name for row, name in zip(rows, names, strict=True))


class Estimate(NamedTuple):
    """What a few members have shown before the sweep."""

    seconds: float  # of the processor, a run
    rows: Mapping[int, Row]  # of these members, which need not be run again
    simulation: float  # s of the processor in these members, as runs take it that load nothing
    overhead: float  # s of the processor in loading and compiling for them


def estimate_of(machine: Machine, request: Request, design: Design) -> Estimate:
    """Run a few members: all that is built on demand is there then, and a run's time is known."""
    members = np.unique(np.linspace(0, len(design.points) - 1, _TRIALS).astype(int)).tolist()
    times, rows = list[float](), dict[int, Row]()
    for member in members:
        started = time.process_time()
        rows[member] = evaluate_member(machine, request, design.points[member])
        times.append(time.process_time() - started)
        slow = times[0] > _SLOW_SECONDS
        if slow or sum(times[1:]) > _TRIAL_SECONDS:
            break
    seconds = float(np.mean(times if slow else times[1:] or times))  # the first loads and compiles
    simulation = min(seconds * len(times), sum(times))
    if sum(row.series.nbytes for row in rows.values()) > _MOST_BYTES:
        rows = {}
    return Estimate(seconds, rows, simulation, sum(times) - simulation)


def units_of(machine: Machine, request: Request) -> dict[str, str]:
    """The units of all columns, by name."""
    about = machine.description
    units = {name: factor_unit(machine, name) or "" for name in request.names}
    units |= {name: about.series.find(name).unit for name in request.keep}
    for name, given in request.quantities.items():
        units[name] = declared_unit(given, about) if isinstance(given, str) else ""
    return units


def factor_unit(machine: Machine, name: str) -> str | None:
    """The unit of a factor, of a parameter the declared one; None where there is no such name."""
    if name in machine.parameters.names:
        return machine.parameters[name].unit
    for row in machine.coordinates:
        if name == row.name:
            return row.unit
        if name == row.velocity:
            return row.velocity_unit
    return None


def _companions(machine: Machine, kind: str, options: Mapping[str, Any]) -> dict[str, str]:
    """SHA-256 of the modules that the options take, built so that no worker does."""
    if kind != "simulate":
        return {}
    if options.get("accuracy") is None:
        if options.get("formulation") == "reduced":
            return companions_of(machine, ("reduced",))
        implicit = options.get("method") in {*IMPLICIT, "auto"}
        return companions_of(machine, ("tangents",) if implicit else ())
    found = dict[str, str]()
    for name in ("reduced", "tangents"):
        with suppress(LinkwrightError):  # of a scene that has none
            found |= companions_of(machine, (name,))
    return found
