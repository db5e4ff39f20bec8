"""The reference: from a file, or a run of one method; runs of other methods confirm it.

A run alone proves nothing, however tight its tolerance. It is compared with runs of other methods,
and the least difference is how far it is known: two methods of different order will hardly agree by
chance in the worst of hundreds of instants. A file is confirmed in the same way, or shown to belong
to another machine.
"""

import csv
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

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
from runtime.accuracy_target.run_comparison import own_instants
from runtime.integrate.method import LEADING, MULTISTEP, REGISTER, SWITCHING
from runtime.mechanism.dense_equations import Equations, FloatArray, magnitudes
from runtime.mechanism.module_tables import Description
from runtime.results.result import Result
from runtime.studies.harness import Runner, Setting, outcome_name
from runtime.studies.work_precision.diagram import Check, Reference

TIGHTEST = 1e-13  # accuracy: rtol of reference runs; the compared runs stay a digit away
LIMIT_FACTOR = 6.0  # safety: times the time limit of a run that a reference run may take
_STEPS_FACTOR = 20  # safety: times the number of steps of a run that a reference run may take
DOUBTFUL = 1e-6  # accuracy: scaled error above which a reference is no longer known
_ROUNDING = 1e-15  # accuracy: least scaled error to which a reference is known
# safety: least order of a method whose runs confirm; at order 3 they take fifty times the steps
_WITNESS_ORDER = 5
OR = "|"  # between the names of a quantity of which a scene has one or another: ``a.x|b.x``
_CONSERVED = 1e-9  # accuracy: relative change of the energy below which it is conserved


def _independent_methods() -> tuple[str, ...]:
    """The first accurate method of each family and order; a second one of both would err alike."""
    kinds: dict[tuple[str, int], str] = {}
    for name, method in REGISTER.items():
        if method.family != SWITCHING and method.order >= _WITNESS_ORDER:
            kinds.setdefault((method.family, method.order), name)
    return tuple(kinds.values())


_OTHERS = tuple(Setting(name) for name in _independent_methods() if name != LEADING)
# At the tightest tolerance a multistep method is the slowest. Implicit ones pass where it is stiff.
_ONE_STEP = [setting for setting in _OTHERS if REGISTER[setting.method].family != MULTISTEP]
_ONE_STEP.sort(key=lambda setting: not REGISTER[setting.method].implicit)
_FIRST = (Setting(LEADING, "reduced"), Setting(LEADING), *_ONE_STEP)


def default_quantities(description: Description) -> tuple[str, ...]:
    """The coordinates that the scene starts from and their velocities, or all; and states."""
    fixed = {row.name for row in description.start if row.role == "fixed"}
    rows = [row for row in description.positions if fixed & {row.name, row.velocity}]
    rows = rows or [*description.positions]
    names = tuple(name for row in rows for name in (row.name, row.velocity))
    return names + description.states.names


def series_of(description: Description, quantities: Sequence[str]) -> tuple[str, ...]:
    """The series of the quantities: of names with ``|`` the first that exists, or InputError."""
    table, series, problems = description.series, [], []
    for text in quantities:
        choices = [name.strip() for name in text.split(OR)]
        found = next(filter(None, map(table.get, choices)), None)
        series += [found.name] if found else []
        problems += [] if found else [f"{description.title}: {table.unknown(choices[0])}"]
    if problems:
        raise InputError(problems)
    return tuple(series)


def distinct_quantities(description: Description, quantities: Sequence[str]) -> tuple[str, ...]:
    """The quantities as they are written; of those that are the same series, the first."""
    texts: dict[str, str] = {}
    for series, text in zip(series_of(description, quantities), quantities, strict=True):
        texts.setdefault(series, text)
    return tuple(texts.values())


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
    where = f"--reference {path}:"
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = [row for row in csv.reader(file) if row and not row[0].startswith("#")]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{where} cannot be read: {error}.") from error
    head = [name.strip() for name in rows[0]] if rows else []
    names = tuple(quantities) or tuple(name for name in dict.fromkeys(head) if name != "t")
    columns, missing = [], []
    for text in ("t", *names):
        here = [head.index(name) for name in map(str.strip, text.split(OR)) if name in head]
        columns += here[:1]
        missing += [] if here else [text]
    if missing or not names:
        raise InputError(
            f"{where} there is no column {', '.join(missing) or 'beside t'}; it has "
            f"{', '.join(head) or 'none'}. Name the columns t, in s, and as the series are named."
        )
    table = np.full((len(rows) - 1, len(columns)), np.nan)
    for k, row in enumerate(rows[1:]):
        with suppress(IndexError, ValueError):
            table[k] = [float(row[column]) for column in columns]
        if not np.isfinite(table[k]).all():
            raise InputError(
                f"{where} the {k + 1}. line of numbers is {', '.join(row)}; not all "
                "of the columns that are needed hold finite numbers."
            )
    table = table[table[:, 0] > t_start]
    if len(table) < 2 or not (np.diff(table[:, 0]) > 0.0).all():
        raise InputError(
            f"{where} it takes two instants or more after t = {t_start:g} s, each "
            "later than the one before it."
        )
    if t_end is not None and t_end > table[-1, 0]:
        raise InputError(f"{where} it ends at t = {table[-1, 0]:g} s, before {t_end:g} s.")
    table = table[table[:, 0] <= (np.inf if t_end is None else t_end)]
    return ReferenceFile(path, names, table[:, 0].copy(), table[:, 1:].copy())


class Places(NamedTuple):
    """The instants of a run with which others are compared."""

    t: FloatArray  # s, (k,); where a condition ended it, the last is that end
    start: float  # s
    instants: dict[str, float]  # its own, s
    are_compared: bool  # whether these, and its end, are quantities

    @property
    def names(self) -> tuple[str, ...]:
        """Of its own instants, where they are quantities."""
        return tuple(self.instants) if self.are_compared else ()

    def rows(self, result: Result) -> npt.NDArray[np.int64]:
        """The rows of another run with the same ways, (k,); behind its end that of its end."""
        last = len(result.t) - 1
        rows: npt.NDArray[np.int64] = np.minimum(np.searchsorted(result.t, self.t), last)
        if self.are_compared and result.ended_by:
            rows[-1:] = last
        return rows

    def columns(self, result: Result) -> FloatArray:
        """The instants of a run as quantities over time, s since the start, (k, m)."""
        own = own_instants(result)
        values = [own[name] - self.start for name in self.names]
        return np.tile(values, (len(self.t), 1)).reshape(len(self.t), len(values))

    def difference(self, result: Result) -> str:
        """Sentence on a run that ends, or changes joints, otherwise; empty where it does not."""
        ways = [", ".join(one) or "none" for one in (own_instants(result), self.instants)]
        if ways[0] == ways[1]:
            return ""
        return f"Its own instants are {ways[0]}, and those of the reference {ways[1]}."


@dataclass(frozen=True)
class ReferenceSolution:
    """The solution with which runs are compared."""

    names: tuple[str, ...]  # of the quantities, as the user spelled them
    places: Places  # at which it is compared, k
    values: FloatArray  # there, (k, j)
    scales: tuple[Scale, ...]  # of their errors
    total: FloatArray  # energy in J, (k,)
    energy: str  # "start" where energy is conserved, "reference" where it changes, "" without any
    length: float  # divisor of the residuals of positions
    speed: float  # the same of velocities
    about: Reference

    def errors(self, result: Result) -> Errors:
        """The errors of a run."""
        return errors(_values(result, self.names, self.places), self.values, self.scales)

    def energy_error(self, result: Result) -> float | None:
        """Largest error of the energy over the largest magnitude of it and its parts."""
        if not self.energy:
            return None
        total = result.samples.energy.sum(axis=1)[self.places.rows(result)]
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
    description, end = runner.machine.description, runner.instants[-1]
    built = frozenset(setting.companion for setting in settings)
    failures: list[str] = []
    runs = _completed_runs(runner, _built_first(_FIRST, built), failures, progress)
    setting, best = next(runs, (None, None))
    if setting is None or best is None:
        raise LinkwrightError(
            f"{runner.title}: no run at rtol {TIGHTEST:g} reaches t = {end:g} s, so there is no "
            f"reference: {'; '.join(failures)}."
        )
    places = _places(best, runner, file)
    computed = _values(best, names, places)
    require_numbers(description, names, computed)
    source = f"{setting.title}, rtol {TIGHTEST:g}"
    others = [] if file is None else [(source, computed)]
    # Runs by other methods confirm it: two, but only one where a second would have to be built.
    candidates = _built_first([other for other in _OTHERS if other.method != setting.method], built)
    confirming = _completed_runs(runner, candidates, [], progress)
    agreeing = ((one, run) for one, run in confirming if not places.difference(run))
    for other, result in islice(agreeing, 2 if "tangents" in built else 1):
        others.append((f"{other.title}, rtol {TIGHTEST:g}", _values(result, names, places)))
    if not others:
        raise LinkwrightError(
            f"{runner.title}: only {source} reaches t = {end:g} s, and a run alone is no "
            "reference. Ask for a shorter run, raise the limit, or give --reference."
        )
    values = computed if file is None else file.values[: len(places.t)]
    machine, begin = runner.machine, runner.begin
    equations = Equations(machine.mechanism, machine.parameter_values(runner.parameters))
    sizes = magnitudes(equations, begin.t, begin.q)
    series = series_of(best.description, names)
    units = [best.series(name)[1] for name in series]
    whole = [group_magnitude(best, name) for name in series]
    by = scales(series, units, description, sizes, values[:, : len(series)], whole)
    span = float(best.t[-1]) - begin.t
    by += tuple(Scale(name, "s", "others", span) for name in places.names)
    differences = [errors(run, values, by).worst for _, run in others]
    nearest = int(np.argmin(differences))
    by_values = np.array([scale.value for scale in by])
    doubtful = scaled_errors(others[nearest][1], values, by_values).max(axis=1) > DOUBTFUL
    about = Reference(
        source if file is None else str(file.path), independent=file is not None,
        checks=tuple(Check(run, e) for (run, _), e in zip(others, differences, strict=True)),
        floor=max(differences[nearest], _ROUNDING),
        horizon=float(places.t[int(np.argmax(doubtful))]) if doubtful.any() else None,
    )  # fmt: skip
    length = float(sizes[description.is_length].max(initial=0.0)) or 1.0
    speed = float(np.abs(best.samples.v).max()) or 1.0
    energy = _energy(best, places)
    return ReferenceSolution(tuple(names), places, values, by, *energy, length, speed, about)


def _places(best: Result, runner: Runner, file: ReferenceFile | None) -> Places:
    """The instants of a study up to the end of its best run, and that end, unless of a file."""
    t, end = runner.instants, float(best.t[-1])
    if best.ended_by:
        t = t[t < end] if file is not None else np.append(t[t < end], end)
    return Places(t, runner.begin.t, own_instants(best), file is None)


def _values(result: Result, names: Sequence[str], places: Places) -> FloatArray:
    """The quantities over time, and the run's own instants, (k, j)."""
    series = series_of(result.description, names)
    values = series_values(result, series)[places.rows(result)]
    return np.hstack([values, places.columns(result)])


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


def _energy(best: Result, places: Places) -> tuple[FloatArray, str]:
    """Total energy along the reference; whether runs are compared with it or with its start."""
    energy, drivers = best.samples.energy, best.description.drivers
    total = energy.sum(axis=1)[places.rows(best)]
    if not np.isfinite(total).all() or not len(total):
        return total, ""
    conserved = float(np.ptp(total)) <= _CONSERVED * float(np.abs(energy).max())
    return total, "start" if conserved and not drivers else "reference"
