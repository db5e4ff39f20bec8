"""Simulations with an accuracy target: the true error, and the cost over that of the cheapest run.

Every dynamic scene of the library has the targets 1e-3 … 1e-10. The error is taken from a
reference; the cost is that of all runs, the error estimate included. It is compared with the
cheapest of all single runs that meet the target, over methods, formulations and half decades of
tolerance: a choice that takes knowledge of the solution.
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

from benchmarks.single_runs import GRID, LONG, Single, error_of, prepared, single_runs
from codegen.errors import LinkwrightError

if TYPE_CHECKING:
    from runtime.accuracy_target.runs import Quantities
    from runtime.machine_facade import Machine
    from runtime.results.result import Result
    from runtime.results.run_records import ReachedAccuracy

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

TARGETS = tuple(10.0**-k for k in range(3, 11))
RIVALS = 3
"""Number of the cheapest sufficient single runs that take turns with the search."""
TURNS = 3
"""Turns per repeat of a single run."""
POINTS = 501
TRUSTED = 0.3
"""Share of the target by which the reference may be wrong; beyond it no ratio counts."""


@dataclass(frozen=True)
class Row:
    """A scene with an accuracy target.

    Attributes
    ----------
    true, estimated
        Largest relative error, from the reference, and as estimated by the simulation.
    floor
        Difference of two references.
    ratio
        Of the true error to the target.
    milliseconds, cheapest
        Of all runs of the search; of the cheapest single run that is as accurate.
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
        """Whether the reference is good enough to compare with, and the target was met."""
        return self.outcome == "OK" and self.floor <= TRUSTED * self.asked


def measure(
    scenes: Sequence[tuple[str, str, float]],
    targets: Sequence[float],
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
        yield from _of_scene(machine, model, t_end, targets, repeats, grid)


def _of_scene(
    machine: "Machine",
    model: str,
    t_end: float,
    targets: Sequence[float],
    repeats: int,
    grid: Sequence[float],
) -> Iterator[Row]:
    from runtime.accuracy_target.runs import quantities_of

    t = np.linspace(0.0, t_end, POINTS)
    quantities = quantities_of(machine.description, None, prepared(machine, t).sizes)
    reference, other = _references(machine, t_end, t)
    floor = reference_difference(reference, other, quantities)
    candidates = single_runs(machine, t, repeats, grid, reference, quantities)
    for accuracy in targets:
        first = _simulate(machine, t_end, t, accuracy)
        if first is None:
            yield Row(model, machine.scene, accuracy, "REFUSED", 0.0, math.nan, math.nan,
                      floor, math.nan, 0, "", "", math.nan, math.nan, math.nan, "",
                      math.nan)  # fmt: skip
            continue
        result, reached = first
        true = error_of(reference, quantities.of_result(result), quantities)
        rivals = sorted(
            (one for one in candidates if one.error <= accuracy), key=lambda one: one.seconds
        )
        seconds, time, setting = _in_turns(
            partial(_simulate, machine, t_end, t, accuracy), rivals[:RIVALS], TURNS * repeats
        )
        yield Row(
            model,
            machine.scene,
            accuracy,
            result.outcome.name,
            float(result.t[-1]),
            true,
            reached.estimated,
            floor,
            true / accuracy,
            len(reached.runs),
            reached.method,
            reached.formulation,
            reached.rtol,
            seconds * 1e3,
            time * 1e3,
            setting,
            seconds / time,
        )


def _in_turns(
    search: Callable[[], "tuple[Result, ReachedAccuracy] | None"],
    rivals: Sequence[Single],
    turns: int,
) -> tuple[float, float, str]:
    """Seconds of all runs of a search, of the cheapest rival, and the setting of the rival.

    They take turns, as the machine is not always equally fast; the least time of each run counts.
    """
    searched: dict[int, float] = {}
    single = [math.inf] * len(rivals)
    for turn in range(turns + 1):
        found = search()
        assert found is not None
        again = [one.timed()[0] for one in rivals]
        if turn == 0:  # for caches
            continue
        for k, run in enumerate(found[1].runs):
            searched[k] = min(searched.get(k, math.inf), run.seconds)
        single = list(map(min, single, again))
        if sum(searched.values()) > LONG:
            break
    seconds = sum(searched.values())
    if not rivals:
        return seconds, math.nan, ""
    best = int(np.argmin(single))
    return seconds, single[best], rivals[best].setting


def _simulate(
    machine: "Machine", t_end: float, t: Array, accuracy: float
) -> tuple["Result", "ReachedAccuracy"] | None:
    try:
        result = machine.simulate(t_end, t, accuracy=accuracy, progress=False)
    except LinkwrightError:
        return None
    assert result.accuracy is not None
    return result, result.accuracy


def _references(machine: "Machine", t_end: float, t: Array) -> tuple["Result", "Result | None"]:
    """Two solutions by different methods and, if possible, in different coordinates.

    All runs are compared with the first; the second may not exist.
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


def reference_difference(
    reference: "Result", other: "Result | None", quantities: "Quantities"
) -> float:
    """Difference of two references; infinite unless both reach the end."""
    if other is None or reference.failed or other.failed:
        return math.inf
    return error_of(reference, quantities.of_result(other), quantities)
