"""Models of a folder, and the listing of the command `list`."""

import os
from pathlib import Path
from typing import Any

from codegen.errors import InputError
from codegen.files.library_folders import model_names, models_folder
from codegen.files.model_text import ModelText, plain, read_model_text
from codegen.readers.values import one_line, shown
from linkwright.cli.output import write_line

LIBRARY, IN_SPACE = "the library", "the library, in space"


def models_in(folder: Path) -> list[ModelText]:
    """The models of a folder, by name."""
    texts = (read_model_text(folder / f"{name}.py") for name in model_names(folder))
    return [text for text in texts if text is not None]


def found_models(folder: Path | None) -> dict[str, list[ModelText]]:
    """Title → models of a folder, or of all where commands look for them: here, the library's."""
    here, library = Path.cwd(), models_folder()
    own = here / "models"
    places = {"this folder": here, "space": here / "space"}
    places |= {"models": own, "models/space": own / "space"}
    if library is not None and library.resolve() not in (here.resolve(), own):
        places |= {LIBRARY: library, IN_SPACE: library / "space"}
    if folder is not None:
        if not os.path.isdir(folder):  # noqa: PTH112 (nor is a name that is too long)
            raise InputError(
                f"{shown(str(folder))} is no folder; give the folder of some model files."
            )
        places = {one_line(folder): folder, f"{one_line(folder)}/space": folder / "space"}
    return {title: models_in(path) for title, path in places.items() if path.is_dir()}


def facts(found: dict[str, list[ModelText]]) -> dict[str, Any]:
    """The JSON object of the listing."""
    models = [
        {
            "name": text.path.stem,
            "path": str(text.path),
            "summary": text.summary,
            "scenes": [{"name": name, "summary": line} for name, line in text.scenes.items()],
        }
        for texts in found.values()
        for text in texts
    ]
    return {"ok": True, "models": models}


def show(found: dict[str, list[ModelText]]) -> None:
    """Print the listing: under each model its scenes."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(highlight=False)
    for title, texts in found.items():
        if not texts:
            continue
        console.print(Text(title, "bold cyan"))
        table = Table.grid(padding=(0, 2))
        table.add_column(no_wrap=True)
        table.add_column(ratio=1)
        for text in texts:
            stem, name = text.path.stem, text.path.name
            name = {LIBRARY: stem, IN_SPACE: f"space/{stem}"}.get(title, name)
            table.add_row(Text(f"  {name}", "bold"), Text(plain(text.summary)))
            for scene, line in text.scenes.items():
                table.add_row(Text(f"    {scene}"), Text(plain(line), "dim"))
        console.print(table)
    if not any(found.values()):
        write_line("There is no model here. linkwright new NAME writes one to start from.")
