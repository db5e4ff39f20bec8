"""Models of a folder: names that their texts declare, and the listing of the command `list`.

Nothing of a file is executed: the completion of a shell asks for names at every key. Names that a
file computes, such as those of scenes declared in a loop, are found in the file's docstring alone,
where a section `Scenes` names and describes them.
"""

import ast
import os
import re
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from codegen.errors import InputError
from codegen.files.library_folders import model_names, models_folder
from codegen.readers.values import one_line, shown
from linkwright.cli.output import write_line

# Methods of a model whose first argument is no name of an element of the machine.
_OTHERS = {"alternatives", "altered", "at", "body", "misfits", "parameter", "particle", "recompose"}
_OTHERS |= {"sampled", "scene", "state", "state_equation", "table", "with_", "without"}
LIBRARY = "the library"
# A line that is no heading, and the paragraph that is indented under it.
_DESCRIBED = re.compile(r"^(\S.*)\n(?!-)(?:[ \t]*\n)*((?:[ \t]+\S.*\n)*)", re.MULTILINE)
_MARKS = re.compile(r"(\*\*?|``?)(\S.*?)\1")
_LONGEST = 2000  # layout: characters of a line from a docstring


@dataclass(frozen=True)
class ModelText:
    """Names in the text of a model file."""

    path: Path
    summary: str = ""  # the first paragraph of its docstring
    scenes: dict[str, str] = field(default_factory=dict)  # with their lines in the docstring
    parameters: tuple[str, ...] = ()
    bodies: tuple[str, ...] = ()
    elements: tuple[str, ...] = ()  # joints, drivers and effects

    @property
    def coordinates(self) -> list[str]:
        """Names of the coordinates of the bodies."""
        return [f"{body}.{q}" for body in self.bodies for q in ("x", "y", "phi")]


def read_model_text(path: Path) -> ModelText | None:
    """The names in a model file; None where it cannot be read as Python."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an escape that is none is no matter of a listing
            tree = ast.parse(path.read_bytes())
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    named: dict[str, dict[str, str]] = {}  # method → names, each once
    calls = (node for node in ast.walk(tree) if isinstance(node, ast.Call))
    for call in sorted(calls, key=lambda node: node.lineno):
        match call:
            case ast.Call(ast.Attribute(attr=of), [ast.Constant(str(name)), *_]):
                if name.isidentifier():
                    named.setdefault(of, {})[name] = ""
    text = ast.get_docstring(tree) or ""
    described = dict[str, str]()  # scenes in the section of the docstring
    for names, line in _DESCRIBED.findall(text.partition("\nScenes\n------\n")[2] + "\n"):
        scenes = [name.strip() for name in names.split(",")]
        if not all(map(str.isidentifier, scenes)):
            break
        described |= dict.fromkeys(scenes, " ".join(line.split()))
    elements = (name for method, names in named.items() if method not in _OTHERS for name in names)
    return ModelText(
        path, " ".join(text.partition("\n\n")[0].split()), named.get("scene", {}) | described,
        tuple(named.get("parameter", ())),
        tuple(named.get("body", {}) | named.get("particle", {})), tuple(dict.fromkeys(elements)),
    )  # fmt: skip


def models_in(folder: Path) -> list[ModelText]:
    """The models of a folder, by name."""
    texts = (read_model_text(folder / f"{name}.py") for name in model_names(folder))
    return [text for text in texts if text is not None]


def found_models(folder: Path | None) -> dict[str, list[ModelText]]:
    """Title → models of a folder, or of all where commands look for them: here, the library's."""
    here, library = Path.cwd(), models_folder()
    places = {"this folder": here, "models": here / "models"}
    if library is not None and library.resolve() not in (here.resolve(), here / "models"):
        places[LIBRARY] = library
    if folder is not None:
        if not os.path.isdir(folder):  # noqa: PTH112 (nor is a name that is too long)
            raise InputError(
                f"{shown(str(folder))} is no folder; give the folder of some model files."
            )
        places = {one_line(folder): folder}
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
            name = text.path.stem if title == LIBRARY else text.path.name
            table.add_row(Text(f"  {name}", "bold"), Text(plain(text.summary)))
            for scene, line in text.scenes.items():
                table.add_row(Text(f"    {scene}"), Text(plain(line), "dim"))
        console.print(table)
    if not any(found.values()):
        write_line("There is no model here. linkwright new NAME writes one to start from.")


def plain(text: str) -> str:
    """Text without the marks of emphasis and code, and without what does not print."""
    return one_line(_MARKS.sub(r"\2", text), _LONGEST)
