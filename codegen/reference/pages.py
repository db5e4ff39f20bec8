"""All pages of the reference as files in a folder, and whether they are what they should be."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from codegen.declare.names import nearest
from codegen.elements.registry import Kind, kinds_of_elements
from codegen.errors import GeneratedFileError, ModelError
from codegen.generated_files.generated_file import is_current
from codegen.model import Model
from codegen.reference.page import page

INDEX = "index.md"
ROLES = {"joint": "Joints", "driver": "Drivers", "force": "Forces"}


@dataclass(frozen=True)
class Written:
    """The pages of a folder, and those among them that were missing, old, or of no kind."""

    pages: tuple[Path, ...]
    stale: tuple[Path, ...]


def slug(kind: str) -> str:
    """The name of a kind's file, without its ending: ``cam-and-follower``."""
    return "-".join(kind.lower().split())


def find_kind(name: str) -> str:
    """The kind that a command line means: by its name or its file's.

    Raises
    ------
    ModelError
        If there is none.
    """
    known = kinds_of_elements()
    for kind in known:
        if name in (kind, slug(kind)):
            return kind
    raise ModelError(f"there is no element '{name}'; {nearest(name, known)}")


def chosen_kinds(model: Model | None = None, only: str | None = None) -> dict[str, Kind]:
    """The kinds that have pages: the library's, and a user's own that `model` has an example of."""
    elements = () if model is None else (*model.joints.values(), *model.effects.values())
    in_model = {element.kind for element in elements}
    return {
        name: kind
        for name, kind in kinds_of_elements().items()
        if only in (None, name) and (not kind.is_user_defined or name in in_model or only == name)
    }


def write(
    folder: Path, model: Model | None = None, only: str | None = None, *, check: bool = False
) -> Written:
    """Write the pages of all kinds and their index, or the page of one kind.

    Parameters
    ----------
    folder
        Where the pages are; made where it is missing.
    model
        A model with elements of one's own.
    only
        One kind, without the index.
    check
        Write nothing; only say what is stale.

    Raises
    ------
    InputError
        If a kind has no sound example, or the folder cannot be written.
    """
    texts = {folder / name: text for name, text in _texts(model, only)}
    stale = []
    for path, text in texts.items():
        if not is_current(path, text):
            stale.append(path)
            if not check:
                _put(path, text)
    if only is None and folder.is_dir():
        stale += sorted(path for path in folder.glob("*.md") if path not in texts)
    return Written(tuple(texts), tuple(stale))


def _put(path: Path, text: str) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text.encode())
    except OSError as error:
        raise GeneratedFileError(
            f"cannot write {path}: {error.strerror or error}; choose another folder with --out."
        ) from error


def _texts(model: Model | None, only: str | None) -> Iterator[tuple[str, str]]:
    kinds = chosen_kinds(model, only)
    for name in kinds:
        yield f"{slug(name)}.md", page(name, model)
    if only is None:
        yield INDEX, index(kinds)


def index(kinds: dict[str, Kind]) -> str:
    """The list of the kinds, role by role."""
    parts = [
        "# Elements",
        (
            "The joints, drivers and forces of the library. Each page shows the equations of an "
            "element as they are compiled, and their cost in operations. In them i and j are "
            "the two bodies of an element, with the coordinates x, y, φ; s'_i is a point in the "
            "frame of body i, s_i = A_i s'_i the same vector in global axes, and d the way from "
            "the point of i to that of j."
        ),
    ]
    for role, heading in ROLES.items():
        rows = [
            f"- [{kind.name}]({slug(kind.name)}.md): {kind.summary}"
            for kind in kinds.values()
            if kind.role == role
        ]
        parts.append("\n".join((f"## {heading}", "", *rows)))
    parts.append("*Written by `python -m codegen elements --out docs/elements`.*")
    return "\n\n".join(parts) + "\n"
