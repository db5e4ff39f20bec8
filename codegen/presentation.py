"""Tables on terminals, figures and pages; matplotlib and rich are loaded when they are used."""

import io
import shutil
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from codegen.errors import InputError, module_of_extra
from codegen.files.whole_files import whole_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from rich.table import Table


NARROW, WIDE, UNKNOWN = 80, 140, 120
"""Least and largest width of a table in columns; width where the terminal does not report one."""
ROOMY = 96
"""Width from which on the numbers of a table have blanks beside them."""
_RESOLUTION = 110  # layout: dots per inch of a notebook, 700 to 1000 of them across a page
PICTURES, PAGES, MOVIES = (".png", ".svg", ".pdf"), (".html", ".htm"), (".mp4", ".gif", ".svg")
VIEWS = ("usual", "x", "y", "z", "-x", "-y", "-z")
"""Of stills in space: along an axis from its positive side, with - from the other."""
STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem;
       color: #1b1f24; }
h1 { font-size: 1.5rem; margin-bottom: 0; } h2 { font-size: 1.1rem; margin-top: 2rem; }
table { border-collapse: collapse; } td, th { padding: .15rem 1rem .15rem 0; text-align: left; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
tr.out { color: #7a838c; } svg { width: 100%; height: auto; }
.outcome { padding: .5rem 1rem; border-left: .3rem solid #2b8a3e; background: #f3faf4; }
.failed { border-color: #c92a2a; background: #fdf3f3; }
"""


def terminal_width() -> int:
    """Columns of the terminal, between the least and largest width of a table."""
    return min(max(shutil.get_terminal_size((UNKNOWN, 24)).columns, NARROW), WIDE)


_IN_PYPLOT: ContextVar[bool | None] = ContextVar("_IN_PYPLOT", default=None)


@contextmanager
def in_pyplot(wanted: bool = True) -> Iterator[None]:
    """Whether pyplot shows and closes the figures that the block makes; the outermost one says.

    What a user is given is in pyplot, what is made for a file is not.
    """
    token = _IN_PYPLOT.set(wanted if _IN_PYPLOT.get() is None else _IN_PYPLOT.get())
    try:
        yield
    finally:
        _IN_PYPLOT.reset(token)


def new_figure(purpose: str, width: float, height: float, **options: Any) -> "Figure":
    """An empty figure for a "plot", "picture" or "report", sizes in inches."""
    module_of_extra("matplotlib.figure", "plot", f"A {purpose} needs matplotlib")
    from matplotlib.figure import Figure

    class NotebookFigure(Figure):
        """A figure that a notebook shows as a picture, once, unless it stands in a window."""

        def __reduce__(self) -> Any:  # as a plain figure, whose class can be imported
            return Figure.__new__, (Figure,), self.__getstate__()

        def _ipython_display_(self) -> None:
            from IPython import display
            from matplotlib import pyplot
            from matplotlib.backends.backend_agg import FigureCanvasAgg

            manager, notebook = self.canvas.manager, cast(Any, display)  # which has no types
            if manager is not None and pyplot.fignum_exists(manager.num):
                if type(self.canvas) is not FigureCanvasAgg:
                    return
                pyplot.close(self)  # else the inline backend shows it at the end of the cell, too
            stream = io.BytesIO()
            self.savefig(stream, format="png", dpi=_RESOLUTION)
            notebook.display(notebook.Image(stream.getvalue()))

    options |= {"figsize": (width, height), "layout": "constrained"}
    if not _IN_PYPLOT.get():
        return NotebookFigure(**options)
    from matplotlib import pyplot

    return pyplot.figure(FigureClass=NotebookFigure, **options)


def finish_axes(axes: "Axes", **grid: Any) -> None:
    """A left and a lower edge only, and a pale grid behind the curves."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(visible=True, **grid)
    axes.set_axisbelow(True)


def save_figure(figure: "Figure", target: Path | io.StringIO) -> None:
    """Write .png, .svg or .pdf; the .svg of one figure has the same bytes every time."""
    import matplotlib as mpl

    svg = isinstance(target, io.StringIO) or target.suffix.lower() == ".svg"
    options: dict[str, Any] = {"format": "svg", "metadata": {"Date": None}} if svg else {}
    with mpl.rc_context({"svg.hashsalt": "linkwright", "svg.fonttype": "none"}):
        figure.savefig(target, **options)


def html_figure(figure: "Figure") -> str:
    """A figure as an element of a page."""
    stream = io.StringIO()
    save_figure(figure, stream)
    text = stream.getvalue()
    return text[text.index("<svg") :]


def html_page(title: str, parts: Iterable[str]) -> str:
    """A page that needs nothing else."""
    body = "\n".join(parts)
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{escape(title)}</title><style>{STYLE}</style></head>\n"
        f"<body>\n{body}\n</body></html>\n"
    )


def save_picture(figure: "Figure", path: Path) -> None:
    """Write a picture, whole or not at all."""
    with whole_file(path) as temporary:
        save_figure(figure, temporary)


def check_picture(path: Path) -> None:
    """Refuse an ending that is no picture's, or a place in no folder, before anything is drawn."""
    if path.suffix.lower() not in PICTURES:
        raise InputError(f"--out {path}: a picture ends in .png, .svg or .pdf.")
    check_parent(path)


def check_parent(path: Path) -> None:
    """Refuse a place for a picture whose folder does not exist."""
    if not path.resolve().parent.is_dir():
        raise InputError(f"{path}: the folder {path.resolve().parent} does not exist.")


def is_page(file: Path) -> bool:
    """Whether a page is meant, by the ending of a name, in capitals or not."""
    return file.suffix.lower() in PAGES


def is_movie(file: Path) -> bool:
    """Whether a movie is meant, or a figure of several positions."""
    return file.suffix.lower() in MOVIES


def new_table(
    title: str, head: Sequence[str], *sections: Iterable[Iterable[object]],
    caption: str | None = None, texts: int = 1, least: int = 3,
) -> "Table":  # fmt: skip
    """A table of rows in sections: so many columns of texts, which fold, then those of numbers.

    A column of texts has `least` characters at least.
    """
    from rich.table import Table

    table = Table(title=title, caption=caption, padding=(0, 1 if terminal_width() >= ROOMY else 0))
    for name in head[:texts]:
        table.add_column(name, overflow="fold", min_width=least)
    for name in head[texts:]:
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
