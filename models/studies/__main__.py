"""``python -m models.studies [NAME]...``: the machines of the chapter from symbols to curves.

Builds the scenes of each study, runs them, prints the table "ours, exact, book", and writes the
figures and a page with the machine in motion.
"""

import subprocess
import sys
from pathlib import Path
from time import perf_counter
from typing import Annotated

import typer
from rich import box
from rich.console import Console
from rich.table import Table

from codegen import build
from models.studies.chapter import STUDIES, Study
from models.studies.gallery import Shown, markdown
from models.studies.rows import Row

console = Console(highlight=False)
PRECOMPILE = (sys.executable, "-m", "runtime.precompile", "dop853")
NAMES = tuple(study.name for study in STUDIES)


def main(
    names: Annotated[
        list[str] | None, typer.Argument(help=f"Some of: {', '.join(NAMES)}; all of them.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for the figures.")] = Path("figures"),
    only_figures: Annotated[bool, typer.Option(help="No table.")] = False,
    gallery: Annotated[
        Path | None, typer.Option(help="A Markdown file to write the tables into.")
    ] = None,
) -> None:
    """Build, simulate, tabulate and draw the machines of chapter 8."""
    for name in names or ():
        if name not in NAMES:
            raise typer.BadParameter(f"{name!r} is none of {', '.join(NAMES)}")
    if gallery and only_figures:
        raise typer.BadParameter("--gallery writes the tables; leave out --only-figures")
    chosen = [study for study in STUDIES if study.name in (names or NAMES)]
    shown: list[Shown] = []
    paths: list[Path] = []
    pages: list[Path] = []
    with console.status("starting") as status:
        clock = perf_counter()
        # The runtime's own loops compile beside the machines' kernels, the first time.
        compiling = subprocess.Popen(PRECOMPILE)
        built = [build(study.path, study.scenes, progress=status.update) for study in chosen]
        status.update("compiling the runtime, once")
        compiling.wait()
        scenes = [scene for report in built for scene in report.scenes]
        operations = sum(sum(scene.operations.values()) for scene in scenes)
        console.print(
            f"[bold]Built[/] {len(scenes)} scenes of {_files(chosen)}, {operations} operations "
            f"in all: {perf_counter() - clock:.1f} s"
        )
        for study in chosen:
            clock = perf_counter()
            status.update(f"simulating {study.title}")
            shown.append(Shown(study, [] if only_figures else study.table()))
            if not only_figures:
                console.print(f"[bold]Ran[/] {study.title}: {perf_counter() - clock:.1f} s")
        from models.studies.drawing import draw

        for part in shown:
            status.update(f"drawing {part.study.title}")
            paths += draw(part.noting(part.study.figures()), out)
        if not only_figures:
            from models.studies.animations import MACHINES, write_pages

            machines = MACHINES if gallery else dict.fromkeys(study.machine for study in chosen)
            pages += write_pages(machines, out, status.update)
    if not only_figures:
        print_table([row for part in shown for row in part.rows])
    if gallery:
        gallery.parent.mkdir(parents=True, exist_ok=True)
        gallery.write_text(markdown(shown), encoding="utf-8")
        console.print(f"[bold]Wrote[/] {gallery}")
    numbers = sorted({path.stem.removeprefix("figure_").replace("_", ".") for path in paths})
    console.print(f"[bold]Drew[/] {len(paths)} files into {out}: figures {', '.join(numbers)}")
    if pages:
        shown_in = ", ".join(map(str, pages))
        console.print(f"[bold]In motion[/], to open in a browser: {shown_in}")


def _files(chosen: list[Study]) -> str:
    return ", ".join(dict.fromkeys(study.path.name for study in chosen))


def print_table(rows: list[Row]) -> None:
    """The table "ours, exact, book", with the reasons for differences below."""
    shown = Table(title="Ours, exact, book", box=box.SIMPLE_HEAD, pad_edge=False, padding=0)
    shown.add_column("where", overflow="fold")
    shown.add_column("quantity", overflow="fold")
    for heading in ("ours", "exact", "book"):
        shown.add_column(heading, justify="right", no_wrap=True)
    shown.add_column("", no_wrap=True)
    reasons: list[str] = []
    for row in rows:
        if row.reason and row.reason not in reasons:
            reasons.append(row.reason)
        mark = f"({reasons.index(row.reason) + 1})" if row.reason else ""
        book = f"{row.book:.10g}" if isinstance(row.book, float) else row.book or ""
        numbers = (f"{row.ours:.9g}", f"{row.exact:.9g}", book)
        shown.add_row(row.section, row.quantity, *numbers, mark)
    console.print(shown)
    for number, reason in enumerate(reasons, 1):
        console.print(f"({number}) the book: {reason}")


if __name__ == "__main__":
    typer.run(main)
