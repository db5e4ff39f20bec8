"""`python -m codegen explain`: ledgers on the terminal, as JSON, as pictures."""

import json
from dataclasses import asdict
from pathlib import Path

import typer
from rich.console import Console

from codegen.errors import SceneError
from codegen.explain.ledger_data import Ledger
from codegen.explain.scene_comparison import Comparison
from codegen.explain.terminal_table import compared, matrix, notes, run_table, table, width

PAPER = 1000
"""A matrix takes the width that its columns need, whatever the terminal's."""


def one_question(scene: str | None, compare: tuple[str, str] | None) -> None:
    """Refuse a scene beside two others."""
    if scene is not None and compare is not None:
        raise SceneError(
            f"--scene {scene} beside --compare {' '.join(compare)}: give the one or the other."
        )


def show(
    ledgers: tuple[Ledger, ...], beside: Comparison | None, *, kernels: bool, as_json: bool
) -> None:
    """Print what was asked for on stdout."""
    if as_json:
        answer: dict[str, object] = {"scenes": [asdict(ledger) for ledger in ledgers]}
        if beside is not None:
            answer["differences"] = [asdict(row) for row in (*beside.rows, beside.total)]
        typer.echo(json.dumps(answer))
        return
    screen = Console(width=width(), highlight=False)
    if beside is not None:
        screen.print(compared(beside))
    for ledger in ledgers:
        if beside is None:
            screen.print(table(ledger))
        if ledger.run is not None:
            screen.print(run_table(ledger))
        if kernels:
            Console(width=PAPER, highlight=False).print(matrix(ledger))
        named = f"{ledger.scene}: " if beside is not None else ""
        for line in notes(ledger):
            screen.print(f"  {named}{line}", markup=False)


def save(ledgers: tuple[Ledger, ...], path: Path) -> Path:
    """The picture of ledgers as .png or .svg, or a page with their tables as .html."""
    from codegen.explain.picture import write

    return write(ledgers, path)
