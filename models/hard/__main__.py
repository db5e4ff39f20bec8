"""``python -m models.hard``: every hard case by every method at every tolerance.

Writes the page `benchmarks/results/hard-cases.md` and the cells as JSON lines. Fails where a cell
is silently wrong or hangs.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from models.hard.cases import CASES, GROUPS, find
from models.hard.suite.case import Case
from models.hard.suite.cell import SETTINGS, Cell, Setting, Verdict, suits
from models.hard.suite.page import markdown
from models.hard.suite.worker import LIMIT, Worker

BAD = (Verdict.WRONG, Verdict.HANGS)

console = Console(highlight=False)


def main(
    only: Annotated[
        list[str] | None, typer.Option(help="A case, by name; repeatable. All by default.")
    ] = None,
    method: Annotated[
        list[str] | None, typer.Option(help="A method; repeatable. All by default.")
    ] = None,
    quick: Annotated[
        bool, typer.Option(help="The middle tolerance alone, and no page unless --out.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(help="The page; benchmarks/results/hard-cases.md for a run of everything."),
    ] = None,
    results: Annotated[Path, typer.Option(help="The cells, a JSON object a line.")] = Path(
        "results/hard-cases.jsonl"
    ),
    limit: Annotated[float, typer.Option(help="Seconds after which a cell counts as hanging.")] = (
        LIMIT
    ),
) -> None:
    """Run the hard cases and evaluate every cell."""
    names = [case.name for case in CASES]
    for name in only or ():
        if name not in names:
            raise typer.BadParameter(f"{name!r} is none of {', '.join(names)}", param_hint="--only")
    for name in method or ():
        if name not in {setting.method for setting in SETTINGS}:
            known = ", ".join(dict.fromkeys(setting.method for setting in SETTINGS))
            raise typer.BadParameter(f"{name!r} is none of {known}", param_hint="--method")
    cases = [case for case in CASES if case.name in (only or names)]
    settings = [setting for setting in SETTINGS if not method or setting.method in method]
    cells = []
    results.parent.mkdir(parents=True, exist_ok=True)
    # Written as they come: a run that is broken off leaves what it has found.
    with results.open("w", encoding="utf-8") as lines:
        for cell in run_all(cases, settings, quick, limit):
            cells.append(cell)
            lines.write(json.dumps(cell.record(), ensure_ascii=False) + "\n")
            lines.flush()
    whole = not (only or method or quick)
    page = out or (Path("benchmarks/results/hard-cases.md") if whole else None)
    if page is not None:
        page.write_text(markdown(GROUPS, cells), encoding="utf-8")
    summary(cells)
    wrote = " and ".join(str(path) for path in (page, results) if path is not None)
    console.print(f"[bold]Wrote[/] {wrote}")
    if any(cell.verdict in BAD for cell in cells):
        raise typer.Exit(1)


def tolerances(case: Case, quick: bool) -> tuple[float, ...]:
    """All of the case, or the one in the middle."""
    return (case.tolerances[len(case.tolerances) // 2],) if quick else case.tolerances


def run_all(
    cases: list[Case], settings: list[Setting], quick: bool, limit: float
) -> Iterator[Cell]:
    """Every cell, in the order of the page, with a bar."""
    cells = [
        (c, setting, rtol)
        for c in cases
        for setting in settings
        if suits(c, setting)
        for rtol in tolerances(c, quick)
    ]
    worker = Worker(find, limit)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bar:
        task = bar.add_task("starting", total=len(cells))
        for case, setting, rtol in cells:
            bar.update(task, description=f"{case.name}, {setting.method}, rtol {rtol:.0e}")
            yield worker.run(case, setting, rtol)
            bar.advance(task)
    worker.close()


def summary(cells: list[Cell]) -> None:
    """How many cells of each verdict, and every one that is not as it should be."""
    for kind in Verdict:
        count = sum(cell.verdict is kind for cell in cells)
        if count:
            console.print(f"[bold]{count}[/] {kind}")
    for cell in cells:
        if cell.note:
            setting = f"{cell.method}, {cell.correction}, rtol {cell.rtol:.0e}"
            console.print(f"  {cell.verdict}: {cell.case}, {setting}: {cell.note}", soft_wrap=True)


if __name__ == "__main__":
    typer.run(main)
