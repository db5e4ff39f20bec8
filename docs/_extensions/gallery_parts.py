"""Parts of the pages of machines: our numbers beside the book's, figures, and moving pictures."""

from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from moving_pictures import save
from sphinx_gallery.scrapers import figure_rst

from linkwright import Animation
from models.studies.chapter import STUDIES


class BesideTheBook:
    """The table of a study: ours, exact, book."""

    def __init__(self, name: str) -> None:
        (study,) = (study for study in STUDIES if study.name == name)
        self.rows = study.table()

    def _repr_html_(self) -> str:
        """The table, and below it the reasons where the book differs."""
        reasons = list(dict.fromkeys(row.reason for row in self.rows if row.reason))
        head = "".join(
            f"<th>{word}</th>" for word in ("where", "quantity", "ours", "exact", "book")
        )
        lines = []
        for row in self.rows:
            mark = f" <sup>{reasons.index(row.reason) + 1}</sup>" if row.reason else ""
            book = f"{row.book:.10g}" if isinstance(row.book, float) else str(row.book or "")
            cells = (row.section, row.quantity, f"{row.ours:.6g}", f"{row.exact:.9g}")
            text = "".join(f"<td>{escape(cell)}</td>" for cell in cells)
            lines.append(f"<tr>{text}<td>{escape(book)}{mark}</td></tr>")
        notes = "".join(f"<li>The book: {escape(reason)}</li>" for reason in reasons)
        table = f"<table class='table dataframe'><tr>{head}</tr>{''.join(lines)}</table>"
        return f"<div class='beside-the-book'>{table}<ol>{notes}</ol></div>"


def figures_of_the_book(name: str) -> list[Figure]:
    """The figures of a study, arranged as in the book."""
    (study,) = (study for study in STUDIES if study.name == name)
    return [figure for _, figure in study.figures()]


def scrape(block: Any, variables: dict[str, Any], settings: dict[str, Any]) -> str:
    """Save the figures that are the value of a block of a script, or the motion of its result."""
    value = variables["example_globals"].get("___")
    if isinstance(value, Animation):
        name = Path(variables["src_file"]).stem.removeprefix("plot_")
        save(name, variables["example_globals"]["result"])
    paths: Iterator[str] = variables["image_path_iterator"]
    found = value if isinstance(value, list) else [value]
    saved = []
    for figure in found:
        if isinstance(figure, Figure):
            path = next(paths)
            figure.savefig(path, dpi=120)
            saved.append(path)
    if saved:
        variables["example_globals"]["___"] = None  # else the next block would save them again
    return figure_rst(saved, settings["src_dir"])
