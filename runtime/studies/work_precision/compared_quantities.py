"""The quantities that are compared, and a reference that is read from a file."""

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from runtime.studies.effect_ranking.quantity import names as series_of
from runtime.studies.effect_ranking.quantity import no_series

if TYPE_CHECKING:
    from runtime.mechanism.description import Description
    from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]
OR = "|"
"""Between the names of a quantity of which a scene has one or another: ``a.x|b.x``."""


def default_names(told: "Description") -> tuple[str, ...]:
    """The coordinates that the scene starts from, and their velocities: what it is about.

    Where it fixes none, all coordinates and velocities.
    """
    fixed = {row.name for row in told.start if row.role == "fixed"}
    rows = [row for row in told.coordinates if fixed & {row.name, row.velocity}]
    rows = rows or list(told.coordinates)
    return tuple(name for row in rows for name in (row.name, row.velocity))


def named(told: "Description", quantities: Sequence[str]) -> tuple[str, ...]:
    """The series that the quantities are in a scene, of names with ``|`` the first that it has.

    Raises
    ------
    InputError
        With every quantity that it has not.
    """
    known = series_of(told)
    every = {name for listed in known.values() for name in listed}
    found, problems = [], []
    for text in quantities:
        choices = [name.strip() for name in text.split(OR)]
        there = [name for name in choices if name in every]
        if there:
            found.append(there[0])
        else:
            problems.append(f"{told.title}: {no_series(choices[0], known)}")
    if problems:
        raise InputError(problems)
    return tuple(found)


def distinct(told: "Description", quantities: Sequence[str]) -> tuple[str, ...]:
    """The quantities as they are written, of those that are one series the first.

    Raises
    ------
    InputError
        As `named`.
    """
    found: dict[str, str] = {}
    for series, text in zip(named(told, quantities), quantities, strict=True):
        found.setdefault(series, text)
    return tuple(found.values())


def columns(result: "Result", quantities: Sequence[str]) -> FloatArray:
    """The quantities over time, (k, j).

    Raises
    ------
    InputError
        As `named`.
    """
    found = [result.series(name)[0] for name in named(result.description, quantities)]
    return np.column_stack(found)


class Given(NamedTuple):
    """A reference from a file: its quantities, instants in s, (k,), and values, (k, j)."""

    path: Path
    names: tuple[str, ...]
    t: FloatArray
    values: FloatArray

    def until(self, end: float) -> "Given":
        """Its part up to an instant."""
        inside = self.t <= end
        return self._replace(t=self.t[inside], values=self.values[inside])


def read_reference(path: Path, quantities: Sequence[str], t_start: float) -> Given:
    """Read a file with a line of names, ``t`` among them, and a line of numbers an instant.

    Parameters
    ----------
    quantities
        Those that are wanted; none: all columns of the file.
    t_start
        Instants up to it are left out: nothing is integrated there.

    Raises
    ------
    InputError
        If the file cannot be read, lacks a column, or holds what is no number.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = [row for row in csv.reader(file) if row and not row[0].startswith("#")]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"--reference {path}: cannot be read: {error}.") from error
    head = [name.strip() for name in rows[0]] if rows else []
    wanted = tuple(quantities) or tuple(name for name in dict.fromkeys(head) if name != "t")
    places, missing = [], []
    for text in ("t", *wanted):
        there = [head.index(name) for name in map(str.strip, text.split(OR)) if name in head]
        places += there[:1]
        missing += [] if there else [text]
    if missing or not wanted:
        raise InputError(
            f"--reference {path}: there is no column {', '.join(missing) or 'beside t'}; it has "
            f"{', '.join(head) or 'none'}. Name the columns t, in s, and as the series are named."
        )
    table = _numbers(path, rows[1:], places)
    table = table[table[:, 0] > t_start]
    if len(table) < 2 or not (np.diff(table[:, 0]) > 0.0).all():
        raise InputError(
            f"--reference {path}: it takes two instants or more after t = {t_start:g} s, each "
            "later than the one before it."
        )
    return Given(path, wanted, table[:, 0].copy(), table[:, 1:].copy())


def _numbers(path: Path, rows: Sequence[Sequence[str]], places: Sequence[int]) -> FloatArray:
    table = np.empty((len(rows), len(places)))
    for k, row in enumerate(rows):
        for j, place in enumerate(places):
            try:
                table[k, j] = float(row[place])
            except (IndexError, ValueError):
                table[k, j] = math.nan
        if not np.isfinite(table[k]).all():
            raise InputError(
                f"--reference {path}: the {k + 1}. line of numbers is {', '.join(row)}, of which "
                "not all that are needed are finite numbers."
            )
    return table
