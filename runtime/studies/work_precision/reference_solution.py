"""The reference: from a file, or a run of one method that runs of other methods confirm.

A run alone proves nothing, however tight its tolerance. It is compared with runs of other methods,
and the least difference is how far it is known: two methods of different order will hardly agree by
chance in the worst of hundreds of instants. A file is confirmed in the same way, or shown to belong
to another machine.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from codegen.errors import LinkwrightError
from runtime.integrate.method import LEADING, METHODS, MULTISTEP, REGISTER, SWITCHING
from runtime.mechanism.dense_equations import Equations, magnitudes
from runtime.studies.error_norms import Errors, Scale, errors, scaled_errors, scales
from runtime.studies.series import group_magnitude, require_numbers, series_values
from runtime.studies.work_precision.compared_quantities import ReferenceFile, series_of
from runtime.studies.work_precision.diagram import DONE, Check, Reference, Setting
from runtime.studies.work_precision.settings_grid import (
    FORMULATIONS,
    TIGHTEST,
    all_settings,
)
from runtime.studies.work_precision.timed_runs import Runner

if TYPE_CHECKING:
    from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]

LIMIT_FACTOR = 6.0  # safety: times the time limit of a run that a reference run may take
_STEPS_FACTOR = 20  # safety: times the number of steps of a run that a reference run may take
DOUBTFUL = 1e-6  # accuracy: scaled error above which a reference is no longer known
_ROUNDING = 1e-15  # accuracy: least scaled error to which a reference is known
_CONSERVED = 1e-9  # accuracy: relative change of the energy below which it is conserved


def _independent_methods() -> tuple[str, ...]:
    """The first method of each family and order; a second one of both would err alike."""
    kinds: dict[tuple[str, int], str] = {}
    for name, method in REGISTER.items():
        if method.family != SWITCHING:
            kinds.setdefault((method.family, method.order), name)
    return tuple(kinds.values())


_OTHERS = tuple(Setting(name) for name in _independent_methods() if name != LEADING)
# At the tightest tolerance a multistep method is the slowest. Implicit ones pass where it is stiff.
_ONE_STEP = (setting for setting in _OTHERS if REGISTER[setting.method].family != MULTISTEP)
_FIRST = (
    Setting(LEADING, "reduced"),
    Setting(LEADING),
    *sorted(_ONE_STEP, key=lambda setting: not REGISTER[setting.method].implicit),
)


@dataclass(frozen=True)
class ReferenceSolution:
    """The solution with which runs are compared.

    Attributes
    ----------
    names
        Quantities, as the user spelled them.
    values : (k, j)
        At the instants of the study.
    scales
        Of their errors.
    total : (k,)
        Total energy in J; nan where the scene has none.
    energy
        "start" where energy is conserved, "reference" where it changes, "" where there is none.
    length, speed
        Divisors of the residuals of positions and velocities.
    about
        Source, checks, and how far it is known.
    """

    names: tuple[str, ...]
    values: FloatArray
    scales: tuple[Scale, ...]
    total: FloatArray
    energy: str
    length: float
    speed: float
    about: Reference

    def errors(self, result: "Result") -> Errors:
        """The errors of a run."""
        return errors(_values(result, self.names), self.values, self.scales)

    def energy_error(self, result: "Result") -> float | None:
        """Largest error of the energy over the largest magnitude of it and its parts."""
        if not self.energy:
            return None
        total = result.samples.energy.sum(axis=1)
        expected = self.total[0] if self.energy == "start" else self.total
        size = max(float(np.abs(result.samples.energy).max()), float(np.abs(self.total).max()))
        return float(np.abs(total - expected).max()) / size if size > 0.0 else 0.0


def find_reference(
    runner: Runner,
    names: Sequence[str],
    file: ReferenceFile | None,
    progress: Callable[[str], None],
    settings: Sequence[Setting] = all_settings(METHODS, FORMULATIONS),
) -> ReferenceSolution:
    """The reference, confirmed.

    Parameters
    ----------
    file
        The reference that the user gave, if any.
    settings
        Those of the study. Reduced equations are built for the reference only if one of these takes
        them; derivatives, which implicit methods take, also where otherwise there would be no
        reference, or none that is confirmed.

    Raises
    ------
    LinkwrightError
        If no run reaches the end, nothing confirms the one that does, or a quantity has no value.
    """
    runner = replace(runner, limit=LIMIT_FACTOR * runner.limit, steps=_STEPS_FACTOR * runner.steps)
    title, end = runner.machine.description.title, runner.instants[-1]
    built = frozenset(setting.companion for setting in settings)
    failures: list[str] = []
    setting, best = next(
        _completed_runs(runner, _built_first(_FIRST, built), failures, progress), (None, None)
    )
    if setting is None or best is None:
        raise LinkwrightError(
            f"{title}: no run at rtol {TIGHTEST:g} reaches t = {end:g} s, so there is no "
            f"reference: {'; '.join(failures)}."
        )
    computed = _values(best, names)
    require_numbers(runner.machine.description, names, computed)
    source = f"{setting.title}, rtol {TIGHTEST:g}"
    others = [] if file is None else [(source, computed)]
    for other, result in _confirming_runs(runner, setting, built, progress):
        others.append((f"{other.title}, rtol {TIGHTEST:g}", _values(result, names)))
    if not others:
        raise LinkwrightError(
            f"{title}: only {source} reaches t = {end:g} s, and a run alone is no reference. Ask "
            "for a shorter run, raise the limit, or give --reference."
        )
    values = computed if file is None else file.values
    by, length = _scales(runner, best, names, values)
    differences = [errors(run, values, by).worst for _, run in others]
    nearest = int(np.argmin(differences))
    doubtful = scaled_errors(others[nearest][1], values, by).max(axis=1) > DOUBTFUL
    about = Reference(
        source if file is None else str(file.path),
        independent=file is not None,
        checks=tuple(Check(run, e) for (run, _), e in zip(others, differences, strict=True)),
        floor=max(differences[nearest], _ROUNDING),
        horizon=float(runner.instants[int(np.argmax(doubtful))]) if doubtful.any() else None,
    )
    speed = float(np.abs(best.samples.v).max()) or 1.0
    return ReferenceSolution(tuple(names), values, by, *_energy(best), length, speed, about)


def _values(result: "Result", names: Sequence[str]) -> FloatArray:
    """The quantities over time, (k, j)."""
    return series_values(result, series_of(result.description, names))


def _scales(
    runner: Runner, best: "Result", names: Sequence[str], values: FloatArray
) -> tuple[tuple[Scale, ...], float]:
    """Scales of the quantities, and the machine's typical length."""
    description = runner.machine.description
    series = series_of(description, names)
    parameters = runner.machine.parameter_values(runner.parameters)
    sizes = magnitudes(
        Equations(runner.machine.mechanism, parameters), runner.begin.t, runner.begin.q
    )
    units = [best.series(name)[1] for name in series]
    whole = [group_magnitude(best, name) for name in series]
    length = float(sizes[description.is_length].max(initial=0.0)) or 1.0
    return scales(series, units, description, sizes, values, whole), length


def _completed_runs(
    runner: Runner,
    settings: Sequence[Setting],
    failures: list[str],
    progress: Callable[[str], None],
) -> Iterator[tuple[Setting, "Result"]]:
    """Runs at the tightest tolerance that reach their end, one after the other."""
    for setting in settings:
        progress(f"{runner.machine.description.title}: reference, {setting.title}")
        try:
            run = runner.run(setting, TIGHTEST)
        except LinkwrightError as error:
            failures.append(f"{setting.title}: {error}")
            continue
        if run.outcome == DONE:
            yield setting, run.result
        else:
            failures.append(f"{setting.title}: {run.outcome}")


def _built_first(settings: Sequence[Setting], built: Collection[str]) -> list[Setting]:
    """First the settings whose companion modules are built, then others in all coordinates."""
    ready = [setting for setting in settings if setting.companion in {"", *built}]
    rest = [setting for setting in settings if setting not in ready]
    return ready + [setting for setting in rest if setting.formulation != "reduced"]


def _confirming_runs(
    runner: Runner, best: Setting, built: Collection[str], progress: Callable[[str], None]
) -> Iterator[tuple[Setting, "Result"]]:
    """Runs by other methods: two, but only one where a second would have to be built."""
    others = [setting for setting in _OTHERS if setting.method != best.method]
    runs = _completed_runs(runner, _built_first(others, built), [], progress)
    return islice(runs, 2 if "tangents" in built else 1)


def _energy(best: "Result") -> tuple[FloatArray, str]:
    """Total energy along the reference; whether runs are compared with it or with its start."""
    energy, drivers = best.samples.energy, best.description.drivers
    total = energy.sum(axis=1)
    if not np.isfinite(total).all() or not len(total):
        return np.full(len(total), np.nan), ""
    conserved = float(np.ptp(total)) <= _CONSERVED * float(np.abs(energy).max())
    return total, "start" if conserved and not drivers else "reference"
