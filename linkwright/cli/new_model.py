"""The command `linkwright new`: a commented model to start from."""

from pathlib import Path

from codegen.errors import GeneratedFileError, InputError
from codegen.readers.names import name_problem, nearest
from linkwright.cli.completion import MODELS_TO_START_FROM as KINDS

_TEMPLATES = Path(__file__).parents[1] / "templates"
_PLACEHOLDER = "NAME"  # layout: in a template, where the name of the model stands


def text_of(kind: str, name: str) -> str:
    """The text of a model of a kind, under a name; InputError where there is no such kind."""
    kind = kind.replace("_", "-")
    if kind not in KINDS:
        raise InputError(
            f"there is no model to start from of kind {kind!r}; {nearest(kind, KINDS)}"
        )
    template = _TEMPLATES / f"{kind.replace('-', '_')}.py"
    return template.read_text(encoding="utf-8").replace(_PLACEHOLDER, name)


def write_model(name: str, kind: str) -> Path:
    """Write NAME.py into the working folder; InputError where it is there, or the name is none."""
    stem = name.removesuffix(".py")
    if problem := name_problem("model", stem):
        raise InputError(problem)
    path = Path(f"{stem}.py")
    text = text_of(kind, stem)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise InputError(
            f"{path} is there already, and stays as it is; give another name, or delete it first."
        ) from None
    except OSError as error:
        raise GeneratedFileError(f"{path} cannot be written: {error.strerror or error}.") from error
    return path


def first_commands(path: Path, kind: str) -> tuple[str, ...]:
    """What to type next: command lines, each with what it answers."""
    lines = text_of(kind, path.stem).splitlines()
    said = [line.strip().partition("  ") for line in lines if line.startswith("    linkwright ")]
    widest = max(len(command) for command, _, _ in said)
    return tuple(f"{command:<{widest}}  {about.strip()}" for command, _, about in said)
