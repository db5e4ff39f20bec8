"""Measurements as a table on the terminal and as JSON and Markdown files."""

import json
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from runtime.studies.harness import processor

LIBRARIES = ("linkwright", "numba", "numpy", "scipy", "sympy")
console = Console(width=110, highlight=False)


@dataclass(frozen=True)
class Report:
    """One measurement.

    Attributes
    ----------
    name
        Of the files.
    title, headings, cells
        The table; the first `words` columns are words, the others numbers.
    verdicts
        Conclusions, in sentences.
    records
        All rows, for the JSON file.
    """

    name: str
    title: str
    headings: tuple[str, ...]
    cells: Sequence[Sequence[str]]
    verdicts: Sequence[str]
    records: Sequence[dict[str, Any]]
    words: int = 1


def records(rows: Sequence[Any]) -> list[dict[str, Any]]:
    """Rows as plain dictionaries."""
    return [asdict(row) for row in rows]


def verdict(what: str, value: float, bar: float, unit: str = "") -> str:
    """Whether a bar holds, in a sentence."""
    if value <= bar:
        return f"{what} {value:.2f}{unit}; the bar of {bar:g}{unit} holds."
    return (
        f"{what} {value:.2f}{unit}; the bar of {bar:g}{unit} is missed by {value - bar:.2f}{unit}."
    )


def show(report: Report) -> None:
    """The table and the verdicts on the terminal."""
    table = Table(title=report.title)
    for k, heading in enumerate(report.headings):
        table.add_column(heading, justify="left" if k < report.words else "right")
    for row in report.cells:
        table.add_row(*row)
    console.print(table)
    for sentence in report.verdicts:
        console.print(sentence)


def markdown(report: Report) -> str:
    """The same for a reader of files."""
    signs = [":--" if k < report.words else "--:" for k in range(len(report.headings))]
    rows = [report.headings, signs, *report.cells]
    table = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    made_with = ", ".join(f"{name} {value}" for name, value in versions().items())
    sentences = "".join(f"- {sentence}\n" for sentence in report.verdicts)
    parts = (f"# {report.title}\n", f"{table}\n", sentences, f"Measured with {made_with}.\n")
    return "\n".join(part for part in parts if part)


def save(name: str, rows: Sequence[dict[str, Any]], folder: Path) -> Path:
    """The measurement as JSON."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.json"
    path.write_text(json.dumps({"versions": versions(), "rows": list(rows)}, indent=2) + "\n")
    return path


def finish(report: Report, folder: Path) -> None:
    """Show it, and write it down."""
    show(report)
    path = save(report.name, report.records, folder)
    path.with_suffix(".md").write_text(markdown(report), encoding="utf-8")
    console.print(f"written: {path}, and {path.with_suffix('.md').name} beside it")


def versions() -> dict[str, str]:
    """Versions of Python and libraries, and the processor: name → text."""
    found = {"python": platform.python_version(), "processor": processor()}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "source tree"
    return found
