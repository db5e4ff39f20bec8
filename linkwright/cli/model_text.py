"""Names that a model file declares, read from its text: nothing of the file is executed.

Listings and the completion of a shell ask for them at every key. Names that a file computes, such
as those of scenes declared in a loop, are found in the file's docstring alone, where a section
`Scenes` names and describes them.
"""

import ast
import warnings
from dataclasses import dataclass, field
from pathlib import Path

from codegen.errors import ModelFileError
from codegen.files.library_folders import find_model_file, model_names, models_folder

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
