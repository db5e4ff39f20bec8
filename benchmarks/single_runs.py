"""Single runs of a scene at one tolerance each, over methods, formulations and tolerances."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from codegen.errors import LinkwrightError

if TYPE_CHECKING:
    from runtime.accuracy_target.runs import Quantities
    from runtime.dynamics.formulations import Coordinates
    from runtime.dynamics.prepared_simulation import PreparedSimulation
    from runtime.integrate.problem import Options, Trajectory
    from runtime.machine_facade import Machine
    from runtime.results.result import Result

Array = npt.NDArray[np.float64]

METHODS = ("dop853", "dopri5", "radau5", "bdf")
FORMULATIONS = ("reduced", "cartesian")
GRID = tuple(10.0 ** (-0.5 * k) for k in range(2, 27))
"""rtol of single runs, 1e-1 … 1e-13."""
LONG = 0.1
"""Processor time from which on a run is not repeated, s."""


@dataclass(frozen=True)
class Single:
    """A run at one tolerance: its processor time in s, its error, and how to run it again."""

    seconds: float
    error: float
    setting: str
    timed: Callable[[], "tuple[float, Trajectory]"]


def single_runs(
    machine: "Machine",
    t: Array,
    repeats: int,
    grid: Sequence[float],
    reference: "Result",
    quantities: "Quantities",
) -> list[Single]:
    """Every single run that reached its end."""
    from runtime.core.outcomes import Outcome
    from runtime.dynamics.formulations import formulate
    from runtime.integrate.problem import Options

    ready = prepared(machine, t)
    found, longest = [], 0.0
    for formulation, method in product(FORMULATIONS, METHODS):
        try:
            taken = formulate(ready, cast(Any, formulation), method, "step")
        except LinkwrightError:
            continue
        for rtol in grid:
            options = Options(method=cast(Any, method), rtol=rtol, t_eval=t)
            again = partial(_timed, ready, taken, options)
            seconds = math.inf
            for _ in range(repeats):
                took, run = again()
                seconds = min(seconds, took)
                if seconds > LONG:
                    break
            if method == METHODS[0]:
                longest = max(longest, seconds)
            elif seconds > longest:
                break  # no tighter run of this method can be the cheapest
            if run.outcome is Outcome.OK:
                error = error_of(
                    reference, np.hstack([run.q, run.v])[:, quantities.state_columns], quantities
                )
                setting = f"{method}, {formulation}, {rtol:.0e}"
                found.append(Single(seconds, error, setting, again))
    return found


def _timed(
    ready: "PreparedSimulation", taken: "Coordinates", options: "Options"
) -> tuple[float, "Trajectory"]:
    """The processor time of a run in s, and the run."""
    from runtime.progress_bar import silent
    from runtime.studies.harness import processor_time

    run, seconds = processor_time(lambda: ready.run(taken, options, silent))
    return seconds, run


def prepared(machine: "Machine", t: Array) -> "PreparedSimulation":
    from runtime.dynamics.prepared_simulation import PreparedSimulation

    end = float(t[-1])
    return PreparedSimulation(
        machine.mechanism, end, t_start=0.0, parameters=None, guess=None, start=None
    )


def error_of(reference: "Result", values: Array, quantities: "Quantities") -> float:
    """Largest |y - r| / (s + |r|) at the instants that `values` has."""
    from runtime.accuracy_target.run_comparison import difference

    count = len(values)
    return difference(
        reference.t[:count],
        values,
        quantities.of_result(reference),
        quantities,
        quantities.wholes(reference),
    ).largest
