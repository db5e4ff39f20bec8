"""The reference: from a file, or a run of one method; runs of other methods confirm it.

A run alone proves nothing, however tight its tolerance. It is compared with runs of other methods,
and the least difference is how far it is known: two methods of different order will hardly agree by
chance in the worst of hundreds of instants. A file is confirmed in the same way, or shown to belong
to another machine.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from codegen.errors import InputError, LinkwrightError
from runtime.accuracy_target.error_norms import (
    Errors,
    Scale,
    errors,
    group_magnitude,
    require_numbers,
    scaled_errors,
    scales,
    series_values,
)
from runtime.accuracy_target.runs import own_instants
from runtime.integrate.method import LEADING, MULTISTEP, REGISTER, SWITCHING
from runtime.mechanism.dense_equations import Equations, FloatArray, magnitudes
from runtime.mechanism.module_tables import Description
from runtime.results.result import Result
from runtime.studies.diagram import Check, Reference
from runtime.studies.harness import Runner, Setting, outcome_name

TIGHTEST = 1e-13  # accuracy: rtol of reference runs; the compared runs stay a digit away
LIMIT_FACTOR = 6.0  # safety: times the time limit of a run that a reference run may take
_STEPS_FACTOR = 20  # safety: times the number of steps of a run that a reference run may take
DOUBTFUL = 1e-6  # accuracy: scaled error above which a reference is no longer known
_ROUNDING = 1e-15  # accuracy: least scaled error to which a reference is known
# safety: least order of a method whose runs confirm; at order 3 they take fifty times the steps
_WITNESS_ORDER = 5
OR = "|"  # between the names of a quantity of which a scene has one or another: ``a.x|b.x``
_CONSERVED = 1e-9  # accuracy: relative change of the energy below which it is conserved

_KINDS = {
    (method.family, method.order): name
    for name, method in reversed(REGISTER.items())
    if method.family != SWITCHING and method.order >= _WITNESS_ORDER
}
# The first method of each family and order: a second one would err alike.
_OTHERS = [Setting(name) for name in REGISTER if name in {*_KINDS.values()} - {LEADING}]
# At the tightest tolerance a multistep method is the slowest. Implicit ones pass where it is stiff.
_ONE_STEP = [setting for setting in _OTHERS if REGISTER[setting.method].family != MULTISTEP]
_ONE_STEP.sort(key=lambda setting: not REGISTER[setting.method].implicit)
_FIRST = (Setting(LEADING, "reduced"), Setting(LEADING), *_ONE_STEP)


def default_quantities(description: Description) -> tuple[str, ...]:
    """The coordinates that the scene starts from and their velocities, or all; and states."""
    fixed = {row.name for row in description.start if row.role == "fixed"}
    rows = [row for row in description.positions if fixed & {row.name, row.velocity}]
    names = [(row.name, row.velocity) for row in rows or description.positions]
    return (*(name for pair in names for name in pair), *description.states.names)


def series_of(description: Description, quantities: Sequence[str]) -> list[str]:
    """The series of the quantities: of names with ``|`` the first that exists, or InputError."""
    table = description.series
    choices = [[name.strip() for name in text.split(OR)] for text in quantities]
    found = [next(filter(None, map(table.get, names)), None) for names in choices]
    if None in found:
        raise InputError(
            f"{description.title}: {table.unknown(names[0])}"
            for names, row in zip(choices, found, strict=True)
            if row is None
        )
    return [row.name for row in found if row is not None]


class ReferenceFile(NamedTuple):
    """A reference from a file: its quantities, instants in s, (k,), and values, (k, j)."""

    path: Path
    names: tuple[str, ...]
    t: FloatArray
    values: FloatArray


def read_reference(
    path: Path, quantities: Sequence[str], t_start: float, t_end: float | None
) -> ReferenceFile:
    """Read a file with a line of names, ``t`` among them, and a line of numbers per instant.

    Without `quantities` all columns are read. Instants up to `t_start`, where nothing is
    integrated, and after `t_end` are left out. Raises InputError if the file cannot be read, lacks
    a column, holds a text that is no number, or ends before `t_end`.
    """
    import pandas as pd

    where = f"--reference {path}:"
    try:
        table = pd.read_csv(path, comment="#", skipinitialspace=True, index_col=False, dtype=str)
    except (OSError, ValueError) as error:
        raise InputError(f"{where} cannot be read: {error}.") from error
    names = tuple(quantities) or tuple(name for name in table if name != "t")
    columns = {
        text: next((name for name in map(str.strip, text.split(OR)) if name in table), "")
        for text in ("t", *names)
    }
    missing = [text for text, column in columns.items() if not column]
    if missing or not names:
        raise InputError(
            f"{where} there is no column {', '.join(missing) or 'beside t'}; it has "
            f"{', '.join(table)}. Name the columns t, in s, and as the series are named."
        )
    cells = table[[*columns.values()]].to_numpy()
    numbers = np.full(cells.shape, np.nan)
    for place, cell in np.ndenumerate(cells):
        with suppress(ValueError):
            numbers[place] = float(cell)
    for row in np.flatnonzero(~np.isfinite(numbers).all(axis=1)):
        raise InputError(
            f"{where} the {row + 1}. line of numbers is {', '.join(map(str, cells[row]))}; not all "
            "of the columns that are needed hold finite numbers."
        )
    numbers = numbers[numbers[:, 0] > t_start]
    if len(numbers) < 2 or not (np.diff(numbers[:, 0]) > 0.0).all():
        raise InputError(
            f"{where} it takes two instants or more after t = {t_start:g} s, each "
            "later than the one before it."
        )
    last = float(numbers[-1, 0])
    if t_end is not None and t_end > last:
        raise InputError(f"{where} it ends at t = {last:g} s, before {t_end:g} s.")
    numbers = numbers[numbers[:, 0] <= (last if t_end is None else t_end)]
    return ReferenceFile(path, names, numbers[:, 0].copy(), numbers[:, 1:].copy())


@dataclass(frozen=True)
class Compared:
    """The quantities and the instants at which runs are compared."""

    names: tuple[str, ...]  # of the quantities, as the user spelled them
    t: FloatArray  # s, (k,); where a condition ended the reference, the last is that end
    start: float  # s
    instants: dict[str, float]  # own ones of the reference, s
    from_file: bool  # whether the user's file has the reference, and says nothing of own instants

    @property
    def own(self) -> tuple[str, ...]:
        """The names of own instants that are quantities."""
        return () if self.from_file else tuple(self.instants)

    def rows(self, result: Result) -> list[int]:
        """The rows of another run with the same ways, (k,); behind its end that of its end."""
        last = len(result.t) - 1
        rows: list[int] = np.minimum(np.searchsorted(result.t, self.t), last).tolist()
        if not self.from_file and result.ended_by:
            rows[-1:] = [last]
        return rows

    def values(self, result: Result) -> FloatArray:
        """The quantities over time, and own instants, s since the start, (k, j)."""
        series = series_of(result.description, self.names)
        values, own = series_values(result, series)[self.rows(result)], own_instants(result)
        since = np.array([own[name] - self.start for name in self.own])
        return np.hstack([values, np.broadcast_to(since, (len(self.t), len(since)))])

    def difference(self, result: Result) -> str:
        """Sentence on a run that ends, or changes joints, otherwise; empty where it does not."""
        ways = [", ".join(one) or "none" for one in (own_instants(result), self.instants)]
        if ways[0] == ways[1]:
            return ""
        return f"Its own instants are {ways[0]}, and those of the reference {ways[1]}."


@dataclass(frozen=True)
class ReferenceSolution:
    """The solution with which runs are compared."""

    compared: Compared
    values: FloatArray  # of the quantities, (k, j)
    scales: tuple[Scale, ...]  # of their errors
    total: FloatArray  # energy in J, (k,)
    energy: str  # "start" where energy is conserved, "reference" where it changes, "" without any
    length: float  # divisor of the residuals of positions
    speed: float  # the same of velocities
    about: Reference

    def errors(self, result: Result) -> Errors:
        """The errors of a run."""
        return errors(self.compared.values(result), self.values, self.scales)

    def energy_error(self, result: Result) -> float | None:
        """Largest error of the energy over the largest magnitude of it and its parts."""
        if not self.energy:
            return None
        total = result.samples.energy.sum(axis=1)[self.compared.rows(result)]
        expected = self.total[0] if self.energy == "start" else self.total
        size = max(float(np.abs(result.samples.energy).max()), float(np.abs(self.total).max()))
        return float(np.abs(total - expected).max()) / size if size > 0.0 else 0.0


def find_reference(
    runner: Runner, names: Sequence[str], file: ReferenceFile | None,
    progress: Callable[[str], None], settings: Sequence[Setting],
) -> ReferenceSolution:  # fmt: skip
    """The reference, from the user's file or from a run, confirmed.

    Reduced equations are built for it only if a setting of the study takes them; derivatives, which
    implicit methods take, also where otherwise there would be no reference, or none that is
    confirmed. Raises LinkwrightError if no run reaches the end, nothing confirms the one that does,
    or a quantity has no value.
    """
    runner = replace(runner, limit=LIMIT_FACTOR * runner.limit, steps=_STEPS_FACTOR * runner.steps)
    built = {setting.companion for setting in settings}
    end, failures = runner.instants[-1], list[str]()
    runs = _completed_runs(runner, _built_first(_FIRST, built), failures, progress)
    setting, best = next(runs, (None, None))
    if setting is None or best is None:
        raise LinkwrightError(
            f"{runner.title}: no run at rtol {TIGHTEST:g} reaches t = {end:g} s, so there is no "
            f"reference: {'; '.join(failures)}."
        )
    t, last = runner.instants, float(best.t[-1])
    if best.ended_by:
        t = np.append(t[t < last], [] if file else [last])
    compared = Compared(tuple(names), t, runner.begin.t, own_instants(best), file is not None)
    computed = compared.values(best)
    require_numbers(best.description, names, computed)
    source = f"{setting.title}, rtol {TIGHTEST:g}"
    others = [(source, computed)] if file else []
    # Runs by other methods confirm it: two, but only one where a second would have to be built.
    candidates = _built_first([other for other in _OTHERS if other.method != setting.method], built)
    confirming = _completed_runs(runner, candidates, [], progress)
    agreeing = ((one, run) for one, run in confirming if not compared.difference(run))
    for other, result in islice(agreeing, 2 if "tangents" in built else 1):
        others.append((f"{other.title}, rtol {TIGHTEST:g}", compared.values(result)))
    if not others:
        raise LinkwrightError(
            f"{runner.title}: only {source} reaches t = {end:g} s, and a run alone is no "
            "reference. Ask for a shorter run, raise the limit, or give --reference."
        )
    values = file.values[: len(t)] if file else computed
    parameters = runner.machine.parameter_values(runner.words.get("parameters"))
    sizes = magnitudes(
        Equations(runner.machine.mechanism, parameters), runner.begin.t, runner.begin.q
    )
    by = _scales(best, compared, sizes, values)
    differences = [errors(run, values, by).worst for _, run in others]
    nearest = int(np.argmin(differences))
    gaps = scaled_errors(others[nearest][1], values, np.array([scale.value for scale in by]))
    doubtful = t[gaps.max(axis=1) > DOUBTFUL]
    about = Reference(
        str(file.path) if file else source, independent=file is not None,
        checks=tuple(Check(run, e) for (run, _), e in zip(others, differences, strict=True)),
        floor=max(differences[nearest], _ROUNDING),
        horizon=float(doubtful[0]) if len(doubtful) else None,
    )  # fmt: skip
    total, kind = _energy(best, compared)
    lengths = sizes[best.description.is_length]
    return ReferenceSolution(
        compared, values, by, total, kind, length=float(lengths.max(initial=0.0)) or 1.0,
        speed=float(np.abs(best.samples.v).max()) or 1.0, about=about,
    )  # fmt: skip


def _scales(
    best: Result, compared: Compared, sizes: FloatArray, values: FloatArray
) -> tuple[Scale, ...]:
    """The scales of quantities and of own instants, whose size is the time of the run."""
    series = series_of(best.description, compared.names)
    units = [best.series(name)[1] for name in series]
    whole = [group_magnitude(best, name) for name in series]
    by = scales(series, units, best.description, sizes, values[:, : len(series)], whole)
    span = float(best.t[-1]) - compared.start
    return by + tuple(Scale(name, "s", "others", span) for name in compared.own)


def _completed_runs(
    runner: Runner, settings: Sequence[Setting], failures: list[str],
    progress: Callable[[str], None],
) -> Iterator[tuple[Setting, Result]]:  # fmt: skip
    """Runs at the tightest tolerance that reach their end, one after the other."""
    for setting in settings:
        progress(f"{runner.title}: reference, {setting.title}")
        try:
            result = runner.run(setting, TIGHTEST)
        except LinkwrightError as error:
            failures.append(f"{setting.title}: {error}")
            continue
        if result.failed:
            failures.append(f"{setting.title}: {outcome_name(result)}")
        else:
            yield setting, result


def _built_first(settings: Sequence[Setting], built: Collection[str]) -> list[Setting]:
    """First the settings whose companion modules are built, then others in all coordinates."""
    ready = [setting for setting in settings if setting.companion in {"", *built}]
    rest = [s for s in settings if s not in ready and s.formulation != "reduced"]
    return ready + rest


def _energy(best: Result, compared: Compared) -> tuple[FloatArray, str]:
    """Total energy along the reference; whether runs are compared with it or with its start."""
    energy, drivers = best.samples.energy, best.description.drivers
    total = energy.sum(axis=1)[compared.rows(best)]
    if not np.isfinite(total).all() or not len(total):
        return total, ""
    conserved = float(np.ptp(total)) <= _CONSERVED * float(np.abs(energy).max())
    return total, "start" if conserved and not drivers else "reference"
