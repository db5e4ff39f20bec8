"""Simulations that are asked for an accuracy: the true error, and the cost beside the cheapest run.

Every dynamic scene of the library is asked for 1e-3 … 1e-10. The error that is reached is taken
from a reference, and the cost is that of all runs that were made, the estimation included. Beside
it stands the cheapest of all single runs that reach the accuracy, over methods, formulations and
half decades of tolerance: a choice that only one who knows the solution can make.
"""

import math
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from benchmarks.report import Report, records
from codegen.errors import LinkwrightError

if TYPE_CHECKING:
    from runtime.analyses.accurate import Accuracy
    from runtime.machine import Machine
    from runtime.results.result import Result

Array = npt.NDArray[np.float64]

SHARE, WORST, COST = 0.95, 10.0, 3.0
"""Bars: share of the runs below what was asked, the worst ratio, the cost in times the cheapest."""

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
FORMULATIONS = ("cartesian", "reduced")
GRID = tuple(10.0 ** (-0.5 * k) for k in range(2, 27))
"""rtol of single runs, 1e-1 … 1e-13."""
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
        is built there.
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
    t = np.linspace(0.0, t_end, POINTS)
    truth, floor = _reference(machine, t_end, t)
    first = _accurate(machine, t_end, t, 1e-3)
    scales = {} if first is None else {row.name: row.scale for row in first[1].quantities}
    single = _single_runs(machine, t_end, t, repeats, grid, truth, scales)
    floor_error = _error(truth, floor, scales)
    for accuracy in asked:
        found = [_accurate(machine, t_end, t, accuracy) for _ in range(repeats + 1)]
        good = [one for one in found if one is not None]
        if not good:
            yield Row(model, machine.scene, accuracy, "REFUSED", 0.0, math.nan, math.nan,
                      floor_error, math.nan, 0, "", "", math.nan, math.nan, math.nan, "",
                      math.nan)  # fmt: skip
            continue
        result, told = good[0]
        # The least of each run over the repeats: what else runs on the machine is left out.
        seconds = sum(min(one[1].runs[k].seconds for one in good) for k in range(len(told.runs)))
        true = _error(truth, result, scales)
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
            floor_error,
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
) -> tuple["Result", "Accuracy"] | None:
    try:
        result = machine.simulate(t_end, t, accuracy=accuracy, progress=False)
    except LinkwrightError:
        return None
    assert result.accuracy is not None
    return result, result.accuracy


def _reference(machine: "Machine", t_end: float, t: Array) -> tuple["Result", "Result"]:
    """Two solutions that have neither the method nor, where it can be, the coordinates in common.

    The first is the one with which all are compared.
    """
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


def _single_runs(
    machine: "Machine",
    t_end: float,
    t: Array,
    repeats: int,
    grid: Sequence[float],
    truth: "Result",
    scales: dict[str, float],
) -> list[tuple[float, float, str]]:
    """Time in s, error and setting of every single run that reached its end."""
    found = []
    for formulation in FORMULATIONS:
        for method in METHODS:
            for rtol in grid:
                options: dict[str, Any] = {"formulation": formulation, "method": method}
                seconds, run = math.inf, None
                try:
                    for _ in range(repeats):
                        run = machine.simulate(t_end, t, rtol=rtol, progress=False, **options)
                        seconds = min(seconds, run.stats["integration_seconds"])
                except LinkwrightError:
                    break
                if run is not None and not run.failed:
                    error = _error(truth, run, scales)
                    found.append((seconds, error, f"{method}, {formulation}, {rtol:.0e}"))
    return found


def _error(truth: "Result", run: "Result", scales: dict[str, float]) -> float:
    """Largest |y - r| / (s + |r|) at the instants that `run` has."""
    worst = 0.0
    for name, scale in scales.items():
        right = truth.series(name)[0][: len(run.t)]
        values = run.series(name)[0][: len(right)]
        worst = max(worst, float((np.abs(values - right) / (scale + np.abs(right))).max()))
    return worst


def sentences(rows: Sequence[Row]) -> list[str]:
    """What follows, in sentences."""
    judged = [row for row in rows if row.counted]
    below = sum(row.ratio <= 1.0 for row in judged)
    worst = max(judged, key=lambda row: row.ratio)
    priced = [row for row in judged if math.isfinite(row.cost)]
    cheap = sum(row.cost <= COST for row in priced)
    dearest = max(priced, key=lambda row: row.cost)
    ended = [row for row in rows if row.outcome != "OK"]
    unknown = len(rows) - len(judged) - len(ended)
    right = (
        f"The true error is below what was asked in {below} of {len(judged)} runs "
        f"({100.0 * below / len(judged):.1f} %, the bar is {100.0 * SHARE:g} %); the worst is "
        f"{worst.ratio:.2g} times it ({worst.scene} at {worst.asked:.0e}; the bar is {WORST:g})."
    )
    price = (
        f"All runs together cost {median(row.cost for row in priced):.2f} times the cheapest "
        f"single run in the median, at most {COST:g} times in {cheap} of {len(priced)}, and "
        f"{dearest.cost:.2f} times at the most ({dearest.scene} at {dearest.asked:.0e})."
    )
    lines = [right, price]
    if ended:
        told = ", ".join(f"{row.scene} at {row.asked:.0e} ({row.outcome})" for row in ended)
        lines.append(f"Not reached over all the time, and said so: {told}.")
    if unknown:
        lines.append(f"{unknown} runs are closer to the exact solution than the references agree.")
    return lines


def report(quick: bool) -> list[Report]:
    """All scenes, built anew with their reduced equations; quick: one of them, three accuracies."""
    scenes, asked, repeats = SCENES, ASKED, 5
    if quick:
        scenes, asked, repeats = SCENES[:1], ASKED[::3], 1
    with tempfile.TemporaryDirectory() as place:
        rows = list(measure(scenes, asked, Path(place), repeats))
    headings = (
        "scene", "asked", "true", "estimated", "true over asked", "runs", "taken", "ms",
        "cheapest, ms", "cheapest setting", "cost",
    )  # fmt: skip
    table = [
        (
            f"{row.model}, {row.scene}",
            f"{row.asked:.0e}",
            f"{row.true:.1e}",
            f"{row.estimated:.1e}",
            f"{row.ratio:.2g}" if row.counted else row.outcome if row.outcome != "OK" else "?",
            str(row.runs),
            f"{row.method}, {row.formulation}, {row.rtol:.0e}",
            f"{row.milliseconds:.2f}",
            f"{row.cheapest:.2f}",
            row.setting,
            f"{row.cost:.2f}",
        )
        for row in rows
    ]
    title = "asked for an accuracy: true errors, and the cost beside the cheapest single run"
    return [Report("accuracy", title, headings, table, sentences(rows), records(rows))]
