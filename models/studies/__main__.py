"""``python -m models.studies``: the compressor from symbols to curves.

Builds the scenes of section 8.2, runs them, prints the table "ours, exact, book", and writes the
figures.
"""

from pathlib import Path
from time import perf_counter
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from codegen import build
from models.studies.compressor import table
from models.studies.rows import Row

console = Console()
MODEL = Path(__file__).resolve().parent.parent / "slider_crank.py"


def main(
    out: Annotated[Path, typer.Option(help="Folder for the figures.")] = Path("figures"),
    only_figures: Annotated[bool, typer.Option(help="No table.")] = False,
) -> None:
    """Build, simulate, tabulate and draw the compressor of section 8.2."""
    started = perf_counter()
    with console.status("building") as status:
        built = build(MODEL, progress=status.update)
        count = sum(sum(scene.operations.values()) for scene in built.scenes)
        console.print(
            f"[bold]built[/] {len(built.scenes)} scenes of {MODEL.name}, {count} operations "
            f"in all, in {perf_counter() - started:.1f} s"
        )
        status.update("simulating")
        running = perf_counter()
        rows = table()
        console.print(f"[bold]ran[/] the studies in {perf_counter() - running:.1f} s")
        if not only_figures:
            console.print(as_table(rows))
        status.update("drawing")
        from models.studies.figures import draw

        paths = draw(out)
    console.print(f"[bold]drew[/] {', '.join(path.name for path in paths)} in {out}")


def as_table(rows: list[Row]) -> Table:
    """The table "ours, exact, book"."""
    result = Table(title="Section 8.2: ours, exact, book", title_justify="left")
    for heading in ("where", "quantity"):
        result.add_column(heading, no_wrap=True)
    for heading in ("ours", "exact", "book"):
        result.add_column(heading, justify="right", no_wrap=True)
    result.add_column("unit")
    result.add_column("why the book differs")
    for row in rows:
        book = "" if row.book is None else f"{row.book:.10g}"
        result.add_row(
            row.section, row.quantity, f"{row.ours:.9g}", f"{row.exact:.9g}", book, row.unit,
            row.reason,
        )  # fmt: skip
    return result


if __name__ == "__main__":
    typer.run(main)
