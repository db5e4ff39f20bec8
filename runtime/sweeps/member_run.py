"""One member of a sweep: its run, and the row that is kept of it."""

from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import FAILURES, InputError, LinkwrightError
from codegen.readers.values import one_line
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.results.result import Result
from runtime.sweeps.request import Request

FloatArray = npt.NDArray[np.float64]
OK = "OK"  # outcome of a run to its end; other runs have the name of an `Outcome`, or one of these
REFUSED = "REFUSED"  # the values make no machine: it does not assemble, a length is negative, …
ERROR = "ERROR"  # a function of the user's own raised an exception
KILLED = "KILLED"  # the run ended its process again and again
MEMORY = "MEMORY"  # the run, or a quantity of it, got no memory
REPEATED = {KILLED, MEMORY}  # outcomes that another day may not have: resumption repeats the runs
FAILED_TO_RUN = {
    REFUSED: "the run was refused: its values make no machine, or no start",
    ERROR: "an exception ended the run",
    KILLED: "the run ended its process, several times",
    MEMORY: "the memory did not suffice",
}
"""Outcome → its meaning; all others are those of `runtime.core.outcomes.Outcome`."""
_LONGEST = 2000  # layout: characters of a message that are kept
_SAME = 1e-9  # accuracy: share of the run within which an instant is the one that was asked for


class Row(NamedTuple):
    """All that is kept of one run."""

    quantities: FloatArray  # (quantities,), not a number where there is none
    outcome: str
    message: str
    t_last: float  # s; the instant that the run reached
    series: FloatArray  # (series, instants), not a number behind the end


def run_member(machine: Machine, request: Request, point: FloatArray) -> Result:
    """The run of a member, by the same words in every process.

    Raises
    ------
    LinkwrightError
        If its values make no machine.
    """
    values: dict[str, Any] = {**request.values(point), "progress": False}
    first, last, count = request.t_start, request.t_end, request.points
    if request.analysis == "simulate":
        options = dict(request.options)
        return machine.simulate(last, count, t_start=first, **values, **options)
    if request.analysis == "equilibrium":
        return machine.equilibrium(**values, t=first)
    driven = machine.kinematics if request.analysis == "kinematics" else machine.inverse_dynamics
    return driven(np.linspace(first, last, count), **values)


def evaluate_member(machine: Machine, request: Request, point: FloatArray) -> Row:
    """Run a member and read its quantities; every failure is a row."""
    try:
        result = run_member(machine, request, point)
    except LinkwrightError as error:
        return without_run(request, REFUSED, str(error))
    except FAILURES as error:
        outcome = MEMORY if isinstance(error, MemoryError) else ERROR
        return without_run(request, outcome, f"{type(error).__name__}: {error}")
    return _row_of(result, request)


def _row_of(result: Result, request: Request) -> Row:
    """What is kept of a result; a quantity that it does not have is not a number."""
    if result.outcome is Outcome.INTERRUPTED:
        raise KeyboardInterrupt  # the wish to stop is no outcome of a member
    row, outcome, notes = without_run(request, "", ""), result.outcome.name, [result.message]
    if not result.failed:
        for k, quantity in enumerate(request.readers.values()):
            try:
                row.quantities[k] = quantity.read(result).value
            except InputError as error:
                notes.append(str(error))
            except FAILURES as error:
                outcome = MEMORY if isinstance(error, MemoryError) else outcome
                notes.append(f"{quantity.text}: {type(error).__name__}: {error}")
    if len(result.t):
        row = row._replace(t_last=float(result.t[-1]))
        _keep_series(result, request, row.series)
    return row._replace(outcome=outcome, message=message_text("\n".join(notes)))


def without_run(request: Request, outcome: str, message: str) -> Row:
    """The row of a member that has no result."""
    quantities = np.full(len(request.quantities), np.nan)
    series = np.full((len(request.keep), request.points), np.nan)
    return Row(quantities, outcome, message_text(message), np.nan, series)


def _keep_series(result: Result, request: Request, series: FloatArray) -> None:
    """Write the series that are kept, at the instants of the sweep."""
    instants = np.linspace(request.t_start, request.t_end, request.points)
    span = max(request.t_end - request.t_start, 1e-300)
    nearest = np.rint((result.t - request.t_start) / span * (request.points - 1)).astype(int)
    inside = (nearest >= 0) & (nearest < request.points)
    near = np.where(inside, nearest, 0)
    there = inside & (np.abs(instants[near] - result.t) <= _SAME * span)
    for k, name in enumerate(request.keep):
        with suppress(InputError):  # of a scene, behind a change of joints, that has no such series
            series[k, near[there]] = result.series(name)[0][there]


def message_text(text: str) -> str:
    """A message as a file keeps it."""
    return one_line(text, _LONGEST)
