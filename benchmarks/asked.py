"""Simulations that are asked for an accuracy: the true error, and the cost beside the cheapest run.

Every dynamic scene of the library is asked for 1e-3 … 1e-10. The error that is reached is taken
from a reference, and the cost is that of all runs that were made, the estimation included. Beside
it stands the cheapest of all single runs that reach the accuracy, over methods, formulations and
half decades of tolerance: a choice that only one who knows the solution can make.
"""

import math
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from codegen.errors import LinkwrightError

if TYPE_CHECKING:
    from runtime.analyses.accurate import ReachedAccuracy
    from runtime.analyses.accurate.comparing import Columns
    from runtime.analyses.prepared import Prepared
    from runtime.machine import Machine
    from runtime.results.result import Result

Array = npt.NDArray[np.float64]

SCENES = (
    ("slider_crank", "compressor", 2.0),
    ("slider_crank", "compressor_massless_rod", 2.0),
    ("quick_return", "shaper", 2.0),
    ("coil_spring", "surge", 10.0),
    ("coil_spring", "impact", 8.0),
    ("coil_spring", "impact_damped", 8.0),
    ("four_bar", "constant_torque", 2.0),
    ("web_cutter", "running", 2.0),
    ("film_follower", "motor", 2.0),
    ("film_follower", "constant_torque", 1.0),
    ("rack_and_pinion", "running", 2.0),
    ("rack_and_pinion", "running_massless_coupler", 2.0),
    ("gear_slider", "train_running", 2.0),
    ("valve_lifter", "free_follower", 0.5),
)
"""Model, scene and time of the run, s."""

ASKED = tuple(10.0**-k for k in range(3, 11))
METHODS = ("dop853", "dopri5", "radau5", "bdf")
FORMULATIONS = ("reduced", "cartesian")
GRID = tuple(10.0 ** (-0.5 * k) for k in range(2, 27))
"""rtol of single runs, 1e-1 … 1e-13."""
LONG = 0.1
"""Processor time from which on a run is not repeated, s."""
POINTS = 501
TRUSTED = 0.3
"""Of the accuracy asked, that the reference may be off by; beyond it no ratio is counted."""


@dataclass(frozen=True)
class Row:
    """A scene that was asked for an accuracy.

    Attributes
    ----------
    true, estimated
        Largest relative error, from the reference, and as the result says.
    floor
        By how much two references differ.
    ratio
        Of the true error to the accuracy asked.
    milliseconds, cheapest
        Of all runs that were made; of the cheapest single run that is as accurate.
    cost
        Their ratio; not a number where no single run is.
    """

    model: str
    scene: str
    asked: float
    outcome: str
    horizon: float
    true: float
    estimated: float
    floor: float
    ratio: float
    runs: int
    method: str
    formulation: str
    rtol: float
    milliseconds: float
    cheapest: float
    setting: str
    cost: float

    @property
    def counted(self) -> bool:
        """Whether the reference is good enough to judge it, and a result was given."""
        return self.outcome == "OK" and self.floor <= TRUSTED * self.asked


def measure(
    scenes: Sequence[tuple[str, str, float]],
    asked: Sequence[float],
    folder: Path | None,
    repeats: int,
    grid: Sequence[float] = GRID,
) -> Iterator[Row]:
    """All scenes in turn.

    Parameters
    ----------
    folder
        An empty one, into which the models are copied and built; None: the library's own, with what
        is built there. References build what is missing.
    """
    from runtime import load

    models = Path(__file__).resolve().parent.parent / "models"
    if folder is not None:
        shutil.copytree(models, folder / "models", dirs_exist_ok=True)
    for model, scene, t_end in scenes:
        place = model if folder is None else folder / "models" / f"{model}.py"
        machine = load(place, scene, folder=folder)
        yield from _of_scene(machine, model, t_end, asked, repeats, grid)


def _of_scene(
    machine: "Machine",
    model: str,
    t_end: float,
    asked: Sequence[float],
    repeats: int,
    grid: Sequence[float],
) -> Iterator[Row]:
    from runtime.analyses.accurate.comparing import columns

    t = np.linspace(0.0, t_end, POINTS)
    of = columns(machine.description, None, _prepared(machine, t).sizes)
    truth, other = _reference(machine, t_end, t)
    floor = _apart(truth, other, of)
    single = _single_runs(machine, t, repeats, grid, truth, of)
    for accuracy in asked:
        found = [_accurate(machine, t_end, t, accuracy) for _ in range(repeats + 1)]
        good = [one for one in found if one is not None]
        if not good:
            yield Row(model, machine.scene, accuracy, "REFUSED", 0.0, math.nan, math.nan,
                      floor, math.nan, 0, "", "", math.nan, math.nan, math.nan, "",
                      math.nan)  # fmt: skip
            continue
        result, told = good[0]
        # The least of each run over the repeats: what else runs on the machine is left out.
        seconds = sum(min(one[1].runs[k].seconds for one in good) for k in range(len(told.runs)))
        true = _error(truth, of.of_result(result), of)
        able = [(time, setting) for time, error, setting in single if error <= accuracy]
        time, setting = min(able, default=(math.nan, ""))
        yield Row(
            model,
            machine.scene,
            accuracy,
            result.outcome.name,
            float(result.t[-1]),
            true,
            told.estimated,
            floor,
            true / accuracy,
            len(told.runs),
            told.method,
            told.formulation,
            told.rtol,
            seconds * 1e3,
            time * 1e3,
            setting,
            seconds / time,
        )


def _accurate(
    machine: "Machine", t_end: float, t: Array, accuracy: float
) -> tuple["Result", "ReachedAccuracy"] | None:
    try:
        result = machine.simulate(t_end, t, accuracy=accuracy, progress=False)
    except LinkwrightError:
        return None
    assert result.accuracy is not None
    return result, result.accuracy


def _reference(machine: "Machine", t_end: float, t: Array) -> tuple["Result", "Result | None"]:
    """Two solutions that have neither the method nor, where it can be, the coordinates in common.

    The first is the one with which all are compared; of the second there may be none.
    """
    other = None
    tight = machine.simulate(t_end, t, rtol=1e-14, correction="stage", progress=False)
    for formulation in ("reduced", "cartesian"):
        options: dict[str, Any] = {"formulation": formulation, "method": "dopri5"}
        try:
            other = machine.simulate(t_end, t, rtol=3e-14, progress=False, **options)
        except LinkwrightError:
            continue
        if not other.failed:
            break
    return tight, other


def _apart(truth: "Result", other: "Result | None", of: "Columns") -> float:
    """By how much two references differ; infinite unless both reach the end."""
    if other is None or truth.failed or other.failed:
        return math.inf
    return _error(truth, of.of_result(other), of)


def _single_runs(
    machine: "Machine",
    t: Array,
    repeats: int,
    grid: Sequence[float],
    truth: "Result",
    of: "Columns",
) -> list[tuple[float, float, str]]:
    """Processor time in s, error and setting of every single run that reached its end."""
    from runtime.integrate.problem import Options
    from runtime.outcomes import Outcome
    from runtime.progress import silent

    ready = _prepared(machine, t)
    found, longest = [], 0.0
    for formulation, method in product(FORMULATIONS, METHODS):
        try:
            taken = ready.coordinates(cast(Any, formulation), method, "step")
        except LinkwrightError:
            continue
        for rtol in grid:
            options = Options(method=cast(Any, method), rtol=rtol, t_eval=t)
            seconds = math.inf
            for _ in range(repeats):
                began = process_time()
                run = ready.run(taken, options, silent)
                seconds = min(seconds, process_time() - began)
                if seconds > LONG:
                    break
            if method == METHODS[0]:
                longest = max(longest, seconds)
            elif seconds > longest:
                break  # no tighter run of this method can be the cheapest
            if run.outcome is Outcome.OK:
                error = _error(truth, of.of_run(run.q, run.v), of)
                found.append((seconds, error, f"{method}, {formulation}, {rtol:.0e}"))
    return found


def _prepared(machine: "Machine", t: Array) -> "Prepared":
    from runtime.analyses.prepared import Prepared

    end = float(t[-1])
    return Prepared(machine, end, t_start=0.0, parameters=None, guess=None, start=None)


def _error(truth: "Result", values: Array, of: "Columns") -> float:
    """Largest |y - r| / (s + |r|) at the instants that `values` has."""
    from runtime.analyses.accurate.comparing import difference

    count = len(values)
    return difference(truth.t[:count], values, of.of_result(truth), of, of.wholes(truth)).largest
