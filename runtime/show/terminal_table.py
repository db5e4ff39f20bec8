"""Tables and what they mean, on a terminal: no wider than a person reads."""

import shutil
from collections.abc import Iterable
from textwrap import fill

from rich.console import Console
from rich.table import Table

NARROW, WIDE, UNKNOWN = 80, 140, 120
"""Columns that a table has at least and at most, and where nothing says how wide the screen is."""
ROOMY = 96
"""Columns from which on there is room for blanks beside every number."""


def width() -> int:
    """Columns of the terminal, within what a table is made for."""
    return min(max(shutil.get_terminal_size((UNKNOWN, 24)).columns, NARROW), WIDE)


def padding() -> tuple[int, int]:
    """Blanks above and beside every number."""
    return 0, 1 if width() >= ROOMY else 0


def show(tables: Iterable[Table], sentences: Iterable[str]) -> None:
    """Print tables, and below them sentences that say what they mean."""
    screen = Console(width=width(), highlight=False)
    for table in tables:
        screen.print(table)
    for line in sentences:
        lines = fill(line, width(), initial_indent="  ", subsequent_indent="    ")
        screen.print(lines, markup=False)
