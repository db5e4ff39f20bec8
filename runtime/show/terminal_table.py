"""Tables with explanatory sentences, on a terminal: no wider than a person reads."""

import shutil
from collections.abc import Iterable, Sequence
from textwrap import fill

from rich.console import Console
from rich.table import Table

NARROW, WIDE, UNKNOWN = 80, 140, 120
"""Least and largest width of a table in columns; width where the terminal does not report one."""
ROOMY = 96
"""Width from which on numbers have blanks beside them."""


def width() -> int:
    """Columns of the terminal, between the least and largest width of a table."""
    return min(max(shutil.get_terminal_size((UNKNOWN, 24)).columns, NARROW), WIDE)


def new_table(title: str, caption: str, first: str, numbers: Sequence[str], least: int) -> Table:
    """A table without rows: a first column of names, which folds, then columns of numbers.

    Parameters
    ----------
    least
        Width of the first column in characters, at least.
    """
    padding = 0, 1 if width() >= ROOMY else 0
    table = Table(title=title, caption=caption, padding=padding)
    table.add_column(first, overflow="fold", ratio=1, min_width=least)
    for name in numbers:
        table.add_column(name, justify="right", no_wrap=True)
    return table


def show(tables: Iterable[Table], sentences: Iterable[str]) -> None:
    """Print tables, and below them the sentences that explain them."""
    screen = Console(width=width(), highlight=False)
    for table in tables:
        screen.print(table)
    for sentence in sentences:
        lines = fill(sentence, width(), initial_indent="  ", subsequent_indent="    ")
        screen.print(lines, markup=False)
