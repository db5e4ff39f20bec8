"""The command `linkwright list`: models and their scenes, a line each from their docstrings."""

import re
from pathlib import Path
from typing import Any

from codegen.errors import InputError
from codegen.readers.values import one_line, shown
from linkwright.cli.model_text import LIBRARY, ModelText, folders_of_models, models_in
from linkwright.cli.output import write_line

_MARKS = re.compile(r"(\*\*?|``?)(\S.*?)\1")
_LONGEST = 2000  # layout: characters of a line from a docstring


def found_models(folder: Path | None) -> list[tuple[str, list[ModelText]]]:
    """Title and models of a folder, or of all where commands look for models."""
    if folder is None:
        places = folders_of_models()
    else:
        places = [(one_line(folder), folder)]
        try:
            is_folder = folder.is_dir()
        except OSError:  # a name that is too long
            is_folder = False
        if not is_folder:
            raise InputError(
                f"{shown(str(folder))} is no folder; give the folder of some model files."
            )
    return [(title, models_in(path)) for title, path in places]


def facts(found: list[tuple[str, list[ModelText]]]) -> dict[str, Any]:
    """The JSON object of the listing."""
    models = [
        {
            "name": text.path.stem,
            "path": str(text.path),
            "summary": text.summary,
            "scenes": [{"name": name, "summary": line} for name, line in text.scenes.items()],
        }
        for _, texts in found
        for text in texts
    ]
    return {"ok": True, "models": models}


def show(found: list[tuple[str, list[ModelText]]]) -> None:
    """Print the listing: under each model its scenes."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    console = Console(highlight=False)
    for title, texts in found:
        if not texts:
            continue
        console.print(f"[bold cyan]{escape(title)}[/]")
        table = Table.grid(padding=(0, 2))
        table.add_column(no_wrap=True)
        table.add_column(ratio=1)
        for text in texts:
            name = text.path.stem if title == LIBRARY else text.path.name
            table.add_row(f"  [bold]{escape(name)}[/]", escape(plain(text.summary)))
            for scene, line in text.scenes.items():
                table.add_row(f"    {escape(scene)}", f"[dim]{escape(plain(line))}[/]")
        console.print(table)
    if not any(texts for _, texts in found):
        write_line("There is no model here. linkwright new NAME writes one to start from.")


def plain(text: str) -> str:
    """Text without the marks of emphasis and code, and without what does not print."""
    return one_line(_MARKS.sub(r"\2", text), _LONGEST)
