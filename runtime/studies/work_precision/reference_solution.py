"""The reference: from a file, or a run of one method that runs of other methods confirm.

A run alone proves nothing, however tight its tolerance. It is compared with runs of other methods,
and the least difference is how far it is known: two methods of different order that agree by
chance, in the worst of hundreds of instants, are not to be expected. A file is confirmed in the
same way, or shown to be that of another machine.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from codegen.errors import LinkwrightError
from runtime.integrate.method import METHODS
from runtime.mechanism.dense_equations import Equations, magnitudes
from runtime.studies.error_norms import (
    Errors,
    Scale,
    errors,
    kindred,
    require_numbers,
    scaled,
    scales,
)
from runtime.studies.work_precision.compared_quantities import Given, columns, named
from runtime.studies.work_precision.diagram import DONE, Check, Reference, Setting
from runtime.studies.work_precision.settings_grid import FORMULATIONS, TIGHTEST
from runtime.studies.work_precision.settings_grid import settings as every
from runtime.studies.work_precision.timed_runs import Runner, Stopwatch

if TYPE_CHECKING:
    from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]

PATIENCE = 6.0
"""Times the limit of a run that one for the reference may take."""
DOUBTFUL = 1e-6
"""Scaled error above which a reference is no longer known."""
_ROUNDING = 1e-15
_KEPT = 1e-9
_FIRST = (Setting("dop853", "reduced"), Setting("dop853"), Setting("radau5"), Setting("dopri5"))
_OTHERS = (Setting("dopri5"), Setting("radau5"), Setting("bdf"))


@dataclass(frozen=True)
class Truth:
    """What runs are compared with.

    Attributes
    ----------
    names
        Quantities, as the user spelled them.
    values : (k, j)
        Them, at the instants.
    scales
        What their errors are measured by.
    total : (k,)
        Total energy in J; nan where the scene has none.
    energy
        "start" where the energy stays, "reference" where it changes, "" where there is none.
    length, speed
        What residuals of positions and velocities are divided by.
    """

    names: tuple[str, ...]
    values: FloatArray
    scales: tuple[Scale, ...]
    total: FloatArray
    energy: str
    length: float
    speed: float
    reference: Reference

    def errors(self, result: "Result") -> Errors:
        """Those of a run."""
        return errors(columns(result, self.names), self.values, self.scales)

    def energy_error(self, result: "Result") -> float | None:
        """Largest error of the energy over its largest magnitude, that of its parts included."""
        if not self.energy:
            return None
        total = result.samples.energy.sum(axis=1)
        kept = self.total[0] if self.energy == "start" else self.total
        size = max(float(np.abs(result.samples.energy).max()), float(np.abs(self.total).max()))
        return float(np.abs(total - kept).max()) / size if size > 0.0 else 0.0


def find_truth(
    runner: Runner,
    names: Sequence[str],
    given: Given | None,
    progress: Callable[[str], None],
    tried: Sequence[Setting] = every(METHODS, FORMULATIONS),
) -> Truth:
    """The reference, confirmed.

    Parameters
    ----------
    given
        The one from a file, if any.
    tried
        Settings that are compared with it. Reduced equations are built for the reference only where
        they are for one of these; derivatives, which implicit methods take, also where without them
        there is none, or nothing confirms it.

    Raises
    ------
    LinkwrightError
        If no run reaches the end, nothing confirms the one that does, or a quantity has no value.
    """
    patient = replace(runner, limit=PATIENCE * runner.limit, steps=20 * runner.steps)
    told = runner.machine.description
    failures: list[str] = []
    built = frozenset(setting.companion for setting in tried)
    runs = _runs(patient, _cheap_first(_FIRST, built), failures, progress)
    first = next(runs, None)
    if first is None:
        raise LinkwrightError(
            f"{told.title}: no run at rtol {TIGHTEST:g} reaches t = {runner.instants[-1]:g} s, so "
            f"there is no reference: {'; '.join(failures)}."
        )
    setting, best = first
    own = columns(best, names)
    require_numbers(told, names, own)
    values = own if given is None else given.values
    series = named(told, names)
    units = [best.series(name)[1] for name in series]
    sizes = magnitudes(
        Equations(runner.machine.mechanism, runner.machine.parameter_values(runner.parameters)),
        runner.begin.t, runner.begin.q,
    )  # fmt: skip
    whole = [kindred(best, name) for name in series]
    by = scales(series, units, told, sizes, values, whole)
    title = f"{setting.title}, rtol {TIGHTEST:g}"
    others = [] if given is None else [(title, own)]
    others += [
        (name, columns(run, names)) for name, run in _checks(patient, setting, built, progress)
    ]
    if not others:
        raise LinkwrightError(
            f"{told.title}: only {title} reaches t = {runner.instants[-1]:g} s, and a run alone is "
            "no reference. Ask for a shorter run, raise the limit, or give --reference."
        )
    apart = [errors(found, values, by).worst for _, found in others]
    checks = [Check(name, error) for (name, _), error in zip(others, apart, strict=True)]
    nearest = min(apart)
    parted = scaled(others[apart.index(nearest)][1], values, by).max(axis=1) > DOUBTFUL
    horizon = float(runner.instants[int(np.argmax(parted))]) if parted.any() else None
    source = title if given is None else str(given.path)
    total, energy = _energy(best)
    length = told.is_length
    return Truth(
        tuple(names), values, by, total, energy,
        float(sizes[length].max(initial=0.0)) or 1.0,
        float(np.abs(best.samples.v).max()) or 1.0,
        Reference(source, given is not None, tuple(checks), max(nearest, _ROUNDING), horizon),
    )  # fmt: skip


def _runs(
    runner: Runner,
    settings: Sequence[Setting],
    failures: list[str],
    progress: Callable[[str], None],
) -> Iterator[tuple[Setting, "Result"]]:
    """Runs at the tightest tolerance that reach their end, one after the other."""
    for setting in settings:
        progress(f"{runner.machine.description.title}: reference, {setting.title}")
        try:
            result, outcome = runner.run(setting, TIGHTEST, Stopwatch())
        except LinkwrightError as error:
            failures.append(f"{setting.title}: {error}")
            continue
        if outcome == DONE:
            yield setting, result
        else:
            failures.append(f"{setting.title}: {outcome}")


def _cheap_first(settings: Sequence[Setting], built: Collection[str]) -> list[Setting]:
    """Those first that take nothing but what is built; no others in reduced coordinates."""
    there = [setting for setting in settings if setting.companion in {"", *built}]
    rest = [setting for setting in settings if setting not in there]
    return there + [setting for setting in rest if setting.formulation != "reduced"]


def _checks(
    runner: Runner, best: Setting, built: Collection[str], progress: Callable[[str], None]
) -> Iterator[tuple[str, "Result"]]:
    """Runs by other methods; two are enough, and one will do where a second has to be built."""
    others = [setting for setting in _OTHERS if setting.method != best.method]
    others = _cheap_first(others, built)
    enough = 2 if "tangents" in built else 1
    for setting, result in islice(_runs(runner, others, [], progress), enough):
        yield f"{setting.title}, rtol {TIGHTEST:g}", result


def _energy(best: "Result") -> tuple[FloatArray, str]:
    """Total energy along the reference, and what it is held against: it stays, or it changes."""
    energy, told = best.samples.energy, best.description
    total = energy.sum(axis=1)
    if not np.isfinite(total).all() or not len(total):
        return np.full(len(total), np.nan), ""
    kept = float(np.ptp(total)) <= _KEPT * float(np.abs(energy).max())
    return total, "start" if kept and not told.drivers else "reference"
