"""The reference: from a file, or a run of one method; runs of other methods confirm it.

A run alone proves nothing, however tight its tolerance. It is compared with runs of other methods,
and the least difference is how far it is known: two methods of different order will hardly agree by
chance in the worst of hundreds of instants. A file is confirmed in the same way, or shown to belong
to another machine.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
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
    with_signs_of,
)
from runtime.accuracy_target.runs import own_instants
from runtime.integrate.method import LEADING, MULTISTEP, REGISTER, SWITCHING
from runtime.mechanism.dense_equations import Equations, FloatArray, magnitudes
from runtime.mechanism.module_tables import Description
from runtime.results.result import Result
from runtime.studies.diagram import Check, Reference
from runtime.studies.harness import Report, Runner, Setting, outcome_name

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
    table, found, problems = description.series, list[str](), list[str]()
    for text in quantities:
        names = [name.strip() for name in text.split(OR)]
        row = next(filter(None, map(table.get, names)), None)
        if row is None:
            problems.append(f"{description.title}: {table.unknown(names[0])}")
        else:
            found.append(row.name)
    if problems:
        raise InputError(problems)
    return found


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


class ReferenceSolution:
    """What runs are compared with: quantities of a file or of a run, at the instants of that run.

    The run is there also beside a file, which says nothing of own instants.
    """

    about: Reference

    def __init__(
        self, runner: Runner, run: Result, names: Sequence[str], file: ReferenceFile | None = None
    ) -> None:  # fmt: skip
        self.names, self.file, self.start = tuple(names), file, runner.begin.t
        self.t, last = runner.instants, float(run.t[-1])  # s, (k,)
        if run.ended_by:  # by a condition: the end of the run is the last instant
            self.t = np.append(self.t[self.t < last], [] if file else [last])
        self.instants = own_instants(run)
        self.own = () if file else tuple(self.instants)  # those that are quantities
        self.computed = self.values(run)  # of the quantities, (k, j)
        self.reference = file.values[: len(self.t)] if file else self.computed
        about = run.description
        parameters = runner.machine.parameter_values(runner.words.get("parameters"))
        equations = Equations(runner.machine.mechanism, parameters)
        sizes = magnitudes(equations, runner.begin.t, runner.begin.q)
        series = series_of(about, self.names)
        self.scales = scales(
            series, [run.series(name)[1] for name in series], about, sizes,
            self.reference[:, : len(series)], [group_magnitude(run, name) for name in series],
        )  # fmt: skip
        self.scales += tuple(Scale(name, "s", "others", last - self.start) for name in self.own)
        # divisors of the residuals of positions and of velocities
        self.length = float(sizes[about.is_length].max(initial=0.0)) or 1.0
        self.speed = float(np.abs(run.samples.v).max()) or 1.0
        # "start" where energy is conserved, "reference" where it changes, "" without any
        energy, self.energy = run.samples.energy, ""
        self.total = energy.sum(axis=1)[self.rows(run)]  # J, (k,)
        if len(self.total) and np.isfinite(self.total).all():
            conserved = float(np.ptp(self.total)) <= _CONSERVED * float(np.abs(energy).max())
            self.energy = "start" if conserved and not about.drivers else "reference"

    def rows(self, result: Result) -> list[int]:
        """The rows of another run with the same ways, (k,); behind its end that of its end."""
        last = len(result.t) - 1
        rows: list[int] = np.minimum(np.searchsorted(result.t, self.t), last).tolist()
        if not self.file and result.ended_by:
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

    def errors(self, values: FloatArray) -> Errors:
        """The errors of the values of a run."""
        return errors(values, self.reference, self.scales)

    def energy_error(self, result: Result) -> float | None:
        """Largest error of the energy over the largest magnitude of it and its parts."""
        if not self.energy:
            return None
        total = result.samples.energy.sum(axis=1)[self.rows(result)]
        expected = self.total[0] if self.energy == "start" else self.total
        size = max(float(np.abs(result.samples.energy).max()), float(np.abs(self.total).max()))
        return float(np.abs(total - expected).max()) / size if size > 0.0 else 0.0


def find_reference(
    runner: Runner, names: Sequence[str], file: ReferenceFile | None,
    progress: Report, settings: Sequence[Setting],
) -> ReferenceSolution:  # fmt: skip
    """The reference, from the user's file or from a run, confirmed.

    Reduced equations are built for it only if a setting of the study takes them; derivatives, which
    implicit methods take, also where otherwise there would be no reference, or none that is
    confirmed. Raises LinkwrightError if no run reaches the end, nothing confirms the one that does,
    or a quantity has no value.
    """
    runner = replace(runner, limit=LIMIT_FACTOR * runner.limit, steps=_STEPS_FACTOR * runner.steps)
    built, end = {setting.companion for setting in settings}, runner.instants[-1]
    failures = list[str]()

    def completed(among: Sequence[Setting]) -> Iterator[tuple[Setting, str, Result]]:
        """Runs at the tightest tolerance that reach their end; those first that are built."""
        ready = [setting for setting in among if setting.companion in {"", *built}]
        rest = [one for one in among if one not in ready and one.formulation != "reduced"]
        for setting in ready + rest:
            progress(f"{runner.title}: reference, {setting.title}")
            try:
                result = runner.run(setting, TIGHTEST)
            except LinkwrightError as error:
                failures.append(f"{setting.title}: {error}")
                continue
            if result.failed:
                failures.append(f"{setting.title}: {outcome_name(result)}")
            else:
                yield setting, f"{setting.title}, rtol {TIGHTEST:g}", result

    first = next(completed(_FIRST), None)
    if first is None:
        raise LinkwrightError(
            f"{runner.title}: no run at rtol {TIGHTEST:g} reaches t = {end:g} s, so there is no "
            f"reference: {'; '.join(failures)}."
        )
    setting, source, best = first
    found = ReferenceSolution(runner, best, names, file)
    require_numbers(best.description, names, found.computed)
    others = dict[str, FloatArray]({source: found.computed} if file else {})
    # Runs by other methods confirm it: two, but only one where a second would have to be built.
    confirming = completed([other for other in _OTHERS if other.method != setting.method])
    agreeing = ((title, run) for _, title, run in confirming if not found.difference(run))
    for title, run in islice(agreeing, 2 if "tangents" in built else 1):
        others[title] = found.values(run)
    if not others:
        raise LinkwrightError(
            f"{runner.title}: only {source} reaches t = {end:g} s, and a run alone is no "
            "reference. Ask for a shorter run, raise the limit, or give --reference."
        )
    checks = [Check(title, found.errors(values).worst) for title, values in others.items()]
    nearest = min(checks, key=lambda check: check.error)
    sizes = np.array([scale.value for scale in found.scales])
    series = [scale.name for scale in found.scales]
    confirmed = with_signs_of(found.reference, others[nearest.title], series)
    gaps = scaled_errors(confirmed, found.reference, sizes)
    doubtful = found.t[gaps.max(axis=1) > DOUBTFUL].tolist()
    found.about = Reference(
        str(file.path) if file else source, independent=file is not None, checks=tuple(checks),
        floor=max(nearest.error, _ROUNDING), horizon=doubtful[0] if doubtful else None,
    )  # fmt: skip
    return found
