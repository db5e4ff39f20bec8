"""The tables and the list of figures as a page of Markdown."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from models.studies.chapter import Study
from models.studies.rows import Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEAD = """# Gallery

The machines of Haug's chapter 8 with its projects and of chapter 12, each from its declaration to
the numbers and figures of the book. "Ours" is the result of this program, "exact" an independent
solution in extended precision or a closed form, "book" the printed value. Where the book differs
from the exact value, the reason stands below the table. `make gallery` draws the figures into
`figures/`, as PNG and SVG.
"""

TABLE = "| where | quantity | ours | exact | book | |\n|---|---|--:|--:|--:|---|"

OURS = "{:.6g}"
"""Digits that do not change from one machine to the next."""


@dataclass(frozen=True)
class Shown:
    """What a study gave.

    Attributes
    ----------
    study, rows
        The study and its table.
    figures
        Name of the file without its ending → what is drawn.
    """

    study: Study
    rows: list[Row]
    figures: dict[str, str] = field(default_factory=dict)

    def noting(self, figures: "Iterable[tuple[str, Figure]]") -> "Iterator[tuple[str, Figure]]":
        """The same figures one by one, their titles noted on the way."""
        for number, figure in figures:
            self.figures[f"figure_{number}"] = title_of(figure)
            yield number, figure


def title_of(figure: "Figure") -> str:
    """The title of a figure, or those of its axes."""
    titles = [figure.get_suptitle(), *(axes.get_title() for axes in figure.axes)]
    return "; ".join(dict.fromkeys(" ".join(title.split()) for title in titles if title))


def markdown(shown: Iterable[Shown]) -> str:
    """The page."""
    return "\n".join((HEAD, *(section(part) for part in shown), ENDING))


ENDING = "*Written by `python -m models.studies --gallery docs/gallery/book.md`.*\n"


def section(part: Shown) -> str:
    """One machine: its table, the reasons, the figures."""
    study = part.study
    scenes = ", ".join(f"`{scene}`" for scene in study.scenes)
    declared = f"Declared in [{study.path.name}](../../models/{study.machine}.py); scenes {scenes}."
    lines = [f"## {study.title[0].upper()}{study.title[1:]}", "", declared, "", TABLE]
    reasons: list[str] = []
    for row in part.rows:
        if row.reason and row.reason not in reasons:
            reasons.append(row.reason)
        mark = f"({reasons.index(row.reason) + 1})" if row.reason else ""
        book = f"{row.book:.10g}" if isinstance(row.book, float) else row.book or ""
        cells = (
            row.section,
            row.quantity,
            OURS.format(row.ours),
            f"{row.exact:.9g}",
            str(book),
            mark,
        )
        lines.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    lines += ["", *(f"({k}) The book: {reason}  " for k, reason in enumerate(reasons, 1))]
    lines += [""] if reasons else []
    lines += [f"- `{name}`: {title}" for name, title in part.figures.items()]
    return "\n".join((*lines, ""))
