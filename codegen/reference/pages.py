"""All pages of the reference as files in a folder, and whether they are up to date."""

from pathlib import Path

from codegen.declare.names import nearest
from codegen.elements.registry import Kind, kinds_of_elements
from codegen.errors import ModelError
from codegen.generated_files.generated_file import Written, write_folder
from codegen.model import Model
from codegen.reference.page import page

INDEX = "index.md"
ABOUT = """# Elements

The joints, drivers and forces of the library. Each page shows the equations of an element as they \
are compiled, and their cost in operations. In them i and j are the two bodies of an element, with \
the coordinates x, y, φ; s'_i is a point in the frame of body i, s_i = A_i s'_i the same vector in \
global axes, and d the way from the point of i to that of j."""
WRITTEN = "*Written by `python -m codegen elements --out docs/elements`.*"
ROLES = {"joint": "Joints", "driver": "Drivers", "force": "Forces"}


def slug(kind: str) -> str:
    """The name of a kind's file, without its ending: ``cam-and-follower``."""
    return "-".join(kind.lower().replace("_", " ").split())


def find_kind(name: str) -> str:
    """The kind of that name, with spaces, hyphens or underscores; ModelError if there is none."""
    known = kinds_of_elements()
    for kind in known:
        if slug(name) == slug(kind):
            return kind
    raise ModelError(f"there is no element '{name}'; {nearest(name, known)}")


def chosen_kinds(model: Model | None = None, only: str | None = None) -> dict[str, Kind]:
    """The kinds that have pages: the library's, and a user's with an example in `model`."""
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
    """Write the pages of all kinds and their index, or the page of one kind; as `write_folder`.

    `model` has elements of one's own, `only` is one kind, without the index. Raises InputError if a
    kind has no sound example, or the folder cannot be written.
    """
    kinds = chosen_kinds(model, only)
    texts = {f"{slug(name)}.md": page(name, model) for name in kinds}
    if only is not None:
        return write_folder(folder, texts, check=check)
    return write_folder(folder, texts | {INDEX: index(kinds)}, others="*.md", check=check)


def index(kinds: dict[str, Kind]) -> str:
    """The list of the kinds, role by role."""
    sections = []
    for role, heading in ROLES.items():
        chosen = (kind for kind in kinds.values() if kind.role == role)
        rows = (f"- [{kind.name}]({slug(kind.name)}.md): {kind.summary}" for kind in chosen)
        sections.append("\n".join((f"## {heading}", "", *rows)))
    return "\n\n".join((ABOUT, *sections, WRITTEN)) + "\n"
