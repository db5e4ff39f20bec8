"""Tables with explanatory sentences, on a terminal: no wider than a person reads."""

import textwrap
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from codegen.presentation import terminal_width

if TYPE_CHECKING:
    from rich.table import Table

ROOMY = 96
"""Width from which on numbers have blanks beside them."""


def new_table(
    title: str, caption: str, head: Sequence[str], *sections: Iterable[Sequence[object]], least: int
) -> "Table":
    """A table of rows in sections: a first column of names, which folds, then one of numbers each.

    The first column has `least` characters at least.
    """
    from rich.table import Table

    table = Table(title=title, caption=caption, padding=(0, 1 if terminal_width() >= ROOMY else 0))
    table.add_column(head[0], overflow="fold", ratio=1, min_width=least)
    for name in head[1:]:
        table.add_column(name, justify="right", no_wrap=True)
    for section in sections:
        for row in section:
            table.add_row(*map(str, row))
        table.add_section()
    return table


def show(tables: Iterable["Table"], sentences: Iterable[str]) -> None:
    """Print tables, and below them the sentences that explain them."""
    from rich.console import Console

    screen = Console(width=terminal_width(), highlight=False)
    for table in tables:
        screen.print(table)
    for sentence in sentences:
        lines = textwrap.fill(
            sentence, terminal_width(), initial_indent="  ", subsequent_indent="    "
        )
        screen.print(lines, markup=False)


def shortened(text: str, longest: float) -> str:
    """The text, cut at a word where it is too long."""
    if len(text) <= longest:
        return text
    return textwrap.shorten(text, int(longest), placeholder=" …")


def milliseconds(seconds: float) -> str:
    """A time with its unit."""
    return f"{1e3 * seconds:.3g} ms" if seconds < 1.0 else f"{seconds:.3g} s"
