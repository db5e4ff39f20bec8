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

from codegen.errors import InputError, ModelFileError
from codegen.files.library_folders import find_model_file, model_names, models_folder
from codegen.readers.values import one_line, shown
from linkwright.cli.output import write_line

# Methods of a model whose first argument is no name of an element of the machine.
_OTHERS = {"alternatives", "altered", "at", "body", "misfits", "parameter", "particle", "recompose"}
_OTHERS |= {"sampled", "scene", "state", "state_equation", "table", "with_", "without"}
LIBRARY = "the library"
_COORDINATES = ("x", "y", "phi")


@dataclass(frozen=True)
class ModelText:
    """Names in the text of a model file.

    Attributes
    ----------
    path
        The file.
    summary
        The first line of its docstring.
    scenes
        Scene → its line in the section `Scenes` of the docstring, or nothing.
    parameters, bodies, elements
        Names of parameters, of bodies, and of joints, drivers and effects.
    """

    path: Path
    summary: str = ""
    scenes: dict[str, str] = field(default_factory=dict)
    parameters: tuple[str, ...] = ()
    bodies: tuple[str, ...] = ()
    elements: tuple[str, ...] = ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates of the bodies."""
        return tuple(f"{body}.{q}" for body in self.bodies for q in _COORDINATES)


def read_model_text(path: Path) -> ModelText | None:
    """The names in a model file; None where it cannot be read as Python."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an escape that is none is no matter of a listing
            tree = ast.parse(path.read_bytes())
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    text = ast.get_docstring(tree) or ""
    named: dict[str, list[str]] = {}
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call) and node.args]
    for call in sorted(calls, key=lambda node: node.lineno):
        first = call.args[0]
        name = first.value if isinstance(first, ast.Constant) else None
        if isinstance(call.func, ast.Attribute) and isinstance(name, str) and name.isidentifier():
            named.setdefault(call.func.attr, []).append(name)
    described = _scene_lines(text)
    literal = named.get("scene", [])
    elements = (name for method, names in named.items() if method not in _OTHERS for name in names)
    return ModelText(
        path,
        " ".join(text.partition("\n\n")[0].split()) if text else "",
        {name: described.get(name, "") for name in (*literal, *described)},
        tuple(dict.fromkeys(named.get("parameter", ()))),
        tuple(dict.fromkeys((*named.get("body", ()), *named.get("particle", ())))),
        tuple(dict.fromkeys(elements)),
    )


def _scene_lines(text: str) -> dict[str, str]:
    """Scene → its description in the section `Scenes` of a docstring, on one line."""
    _, found, section = text.partition("\nScenes\n------\n")
    described: dict[str, str] = {}
    names: list[str] = []
    for line in section.splitlines() if found else ():
        if line and not line[0].isspace():
            names = [name.strip() for name in line.split(",")]
            if not all(name.isidentifier() for name in names):
                break
            described |= dict.fromkeys(names, "")
        elif line.strip():
            for name in names:
                described[name] = f"{described[name]} {line.strip()}".strip()
        elif names and described[names[-1]]:
            names = []
    return described


def folders_of_models() -> list[tuple[str, Path]]:
    """Title and path of the folders where a command looks for models: here, and the library's."""
    here = Path.cwd()
    library = models_folder()
    places = [("this folder", here), ("models", here / "models")]
    if library is not None and library.resolve() not in (here.resolve(), here / "models"):
        places.append((LIBRARY, library))
    return [(title, folder) for title, folder in places if folder.is_dir()]


def models_in(folder: Path) -> list[ModelText]:
    """The models of a folder, by name."""
    texts = (read_model_text(folder / f"{name}.py") for name in model_names(folder))
    return [text for text in texts if text is not None]


def find_model_text(model: str) -> ModelText | None:
    """The names in the file of a model, given by path or by name; None where there is none."""
    try:
        return read_model_text(find_model_file(model))
    except ModelFileError:
        return None


_MARKS = re.compile(r"(\*\*?|``?)(\S.*?)\1")
_LONGEST = 2000  # layout: characters of a line from a docstring


def found_models(folder: Path | None) -> list[tuple[str, list[ModelText]]]:
    """Title and models of a folder, or of all where commands look for models."""
    if folder is None:
        places = folders_of_models()
    else:
        places = [(one_line(folder), folder)]
        if not os.path.isdir(folder):  # noqa: PTH112 (nor is a name that is too long)
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
