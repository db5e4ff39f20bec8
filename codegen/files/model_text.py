"""The text of a model file: its docstring, and the names that it declares.

Nothing of a file is executed: the completion of a shell asks for names at every key. Names that a
file computes, such as those of scenes declared in a loop, are found in the file's docstring alone,
where a section `Scenes` names and describes them.
"""

import ast
import re
import warnings
from dataclasses import dataclass, field
from pathlib import Path

from codegen.readers.values import one_line

# Methods of a model whose first argument is no name of an element of the machine.
_OTHERS = {"alternatives", "altered", "at", "body", "misfits", "parameter", "particle", "recompose"}
_OTHERS |= {"sampled", "scene", "state", "state_equation", "table", "with_", "without"}
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


def plain(text: str) -> str:
    """Text without the marks of emphasis and code, and without what does not print."""
    return one_line(_MARKS.sub(r"\2", text), _LONGEST)
