"""Simulations that are asked for an accuracy: the true error, and the cost beside the cheapest run.

Every dynamic scene of the library is asked for 1e-3 … 1e-10. The error that is reached is taken
from a reference, and the cost is that of all runs that were made, the estimation included. Beside
it stands the cheapest of all single runs that reach the accuracy, over methods, formulations and
half decades of tolerance: a choice that only one who knows the solution can make.
"""

import math
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from benchmarks.single import GRID, LONG, Single, error_of, prepared, single_runs
from codegen.errors import LinkwrightError

if TYPE_CHECKING:
    from runtime.machine import Machine
    from runtime.results.result import Result
    from runtime.studies.accuracy_target import ReachedAccuracy
    from runtime.studies.accuracy_target.run_difference import Columns

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
RIVALS = 3
"""Of the cheapest single runs that are accurate enough, that take turns with ours."""
TURNS = 3
"""Turns by the repeats of a single run."""
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
    from runtime.studies.accuracy_target.run_difference import columns

    t = np.linspace(0.0, t_end, POINTS)
    of = columns(machine.description, None, prepared(machine, t).sizes)
    truth, other = _reference(machine, t_end, t)
    floor = _apart(truth, other, of)
    single = single_runs(machine, t, repeats, grid, truth, of)
    for accuracy in asked:
        first = _accurate(machine, t_end, t, accuracy)
        if first is None:
            yield Row(model, machine.scene, accuracy, "REFUSED", 0.0, math.nan, math.nan,
                      floor, math.nan, 0, "", "", math.nan, math.nan, math.nan, "",
                      math.nan)  # fmt: skip
            continue
        result, told = first
        true = error_of(truth, of.of_result(result), of)
        rivals = sorted(
            (one for one in single if one.error <= accuracy), key=lambda one: one.seconds
        )
        seconds, time, setting = _in_turns(
            partial(_accurate, machine, t_end, t, accuracy),
            rivals[:RIVALS],
            TURNS * repeats,
        )
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


def _in_turns(
    asked: Callable[[], "tuple[Result, ReachedAccuracy] | None"],
    rivals: Sequence[Single],
    turns: int,
) -> tuple[float, float, str]:
    """Seconds of all runs that are made when asked, of the cheapest rival, and its setting.

    They take turns, as the machine is not always equally fast; the least of each run counts.
    """
    ours: dict[int, float] = {}
    theirs = [math.inf] * len(rivals)
    for turn in range(turns + 1):
        found = asked()
        assert found is not None
        again = [one.timed()[0] for one in rivals]
        if turn == 0:  # for caches
            continue
        for k, run in enumerate(found[1].runs):
            ours[k] = min(ours.get(k, math.inf), run.seconds)
        theirs = list(map(min, theirs, again))
        if sum(ours.values()) > LONG:
            break
    seconds = sum(ours.values())
    if not rivals:
        return seconds, math.nan, ""
    best = int(np.argmin(theirs))
    return seconds, theirs[best], rivals[best].setting


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
    return error_of(truth, of.of_result(other), of)
