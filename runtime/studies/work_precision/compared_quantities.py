"""The quantities that are compared, and a reference that is read from a file."""

import csv
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from codegen.errors import InputError
from runtime.mechanism.module_tables import Description
from runtime.studies.series_by_name import FloatArray, series_names, unknown_series

OR = "|"  # between the names of a quantity of which a scene has one or another: ``a.x|b.x``


def default_quantities(description: Description) -> tuple[str, ...]:
    """The coordinates that the scene starts from and their velocities; all where it fixes none."""
    fixed = {row.name for row in description.start if row.role == "fixed"}
    rows = [row for row in description.coordinates if fixed & {row.name, row.velocity}]
    rows = rows or list(description.coordinates)
    return tuple(name for row in rows for name in (row.name, row.velocity))


def series_of(description: Description, quantities: Sequence[str]) -> tuple[str, ...]:
    """The series that the quantities are in a scene: of names with ``|`` the first that it has.

    Raises InputError with every quantity that it has not.
    """
    known = series_names(description)
    existing = {name for listed in known.values() for name in listed}
    series, problems = [], []
    for text in quantities:
        choices = [name.strip() for name in text.split(OR)]
        here = [name for name in choices if name in existing]
        series += here[:1]
        problems += [] if here else [f"{description.title}: {unknown_series(choices[0], known)}"]
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
