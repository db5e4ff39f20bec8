"""``python -m models.studies``: the compressor from symbols to curves.

Builds the scenes of section 8.2, runs them, prints the table "ours, exact, book", and writes the
figures.
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
from models.studies.rows import Row

console = Console(highlight=False)
WARM = "from runtime.warm import warm; warm('dop853')"
SCENES = (
    *("gravity_equilibrium", "gas_equilibrium", "gas_equilibrium_as_printed", "kinematics"),
    *("inverse_dynamics", "inverse_dynamics_without_gas", "compressor"),
)
MODEL = Path(__file__).resolve().parent.parent / "slider_crank.py"


def main(
    out: Annotated[Path, typer.Option(help="Folder for the figures.")] = Path("figures"),
    only_figures: Annotated[bool, typer.Option(help="No table.")] = False,
) -> None:
    """Build, simulate, tabulate and draw the compressor of section 8.2."""
    with console.status("starting") as status:
        clock = perf_counter()
        # The runtime's own loops compile beside the machine's kernels, the first time.
        warming = subprocess.Popen([sys.executable, "-c", WARM])
        built = build(MODEL, SCENES, progress=status.update)
        status.update("compiling the runtime, once")
        warming.wait()
        operations = sum(sum(scene.operations.values()) for scene in built.scenes)
        console.print(
            f"[bold]Built[/] {len(built.scenes)} scenes of {MODEL.name}, {operations} operations "
            f"in all: {perf_counter() - clock:.1f} s"
        )

        status.update("simulating")
        clock = perf_counter()
        from models.studies.compressor import table

        rows = table()
        console.print(f"[bold]Ran[/] the studies of section 8.2: {perf_counter() - clock:.1f} s")
        if not only_figures:
            print_table(rows)

        status.update("drawing")
        from models.studies.figures import draw

        paths = draw(out)
    console.print(f"[bold]Drew[/] {len(paths)} files into {out}: figures 8.2.4 to 8.2.8")


def print_table(rows: list[Row]) -> None:
    """The table "ours, exact, book", with the reasons for differences below."""
    shown = Table(title="Ours, exact, book", box=box.SIMPLE_HEAD, pad_edge=False, padding=0)
    for heading in ("where", "quantity"):
        shown.add_column(heading, no_wrap=True)
    for heading in ("ours", "exact", "book"):
        shown.add_column(heading, justify="right", no_wrap=True)
    shown.add_column("")
    reasons: list[str] = []
    for row in rows:
        if row.reason and row.reason not in reasons:
            reasons.append(row.reason)
        mark = f"({reasons.index(row.reason) + 1})" if row.reason else ""
        book = "" if row.book is None else f"{row.book:.10g}"
        numbers = (f"{row.ours:.9g}", f"{row.exact:.9g}", book)
        shown.add_row(row.section, row.quantity, *numbers, mark)
    console.print(shown)
    for number, reason in enumerate(reasons, 1):
        console.print(f"({number}) the book: {reason}")


if __name__ == "__main__":
    typer.run(main)
