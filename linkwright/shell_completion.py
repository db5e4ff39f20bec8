"""Completion of the words of a command line: models, scenes, parameters, elements, methods.

Names come from the text of the model file that stands on the line, without executing it.
"""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import typer

from codegen.files.library_folders import LIBRARY, model_names, models_folder
from linkwright.command_panels_and_examples import KINDS
from linkwright.static_model_reading import ModelText, find_model_text

_KIND = re.compile(r'^    kind = "([^"]+)"', re.MULTILINE)


def models(incomplete: str) -> list[str]:
    """Model files and folders that go on from what is typed, and models by name."""
    typed = Path(incomplete)
    folder = typed if incomplete.endswith("/") or not incomplete else typed.parent
    found = []
    if folder.is_dir():
        files = [f"{name}.py" for name in model_names(folder.resolve())]
        found = [path.as_posix() for path in map(folder.joinpath, files)]
        if incomplete:
            inside = (path for path in folder.glob("[!._]*") if path.is_dir())
            found += sorted(f"{path.as_posix()}/" for path in inside)
    for place in (Path("models"), models_folder()):
        found += model_names(place) if place and "/" not in incomplete else []
    return [name for name in dict.fromkeys(found) if name.startswith(incomplete)]


def scenes(ctx: typer.Context, incomplete: str) -> list[tuple[str, str]]:
    """Scenes of the model on the line, with their descriptions."""
    text = _model(ctx)
    found = text.scenes.items() if text else ()
    return [(name, line) for name, line in found if name.startswith(incomplete)]


def settings(ctx: typer.Context, incomplete: str) -> list[str]:
    """Parameters of the model on the line, each with the = that follows."""
    text = _model(ctx)
    return _assigned(text.parameters if text else (), incomplete)


def coordinates(ctx: typer.Context, incomplete: str) -> list[str]:
    """Coordinates of the bodies of the model on the line, each with the = that follows."""
    text = _model(ctx)
    return _assigned(text.coordinates if text else (), incomplete)


def quantities(ctx: typer.Context, incomplete: str) -> list[str]:
    """Series of the model on the line: coordinates, and components of reactions."""
    text = _model(ctx)
    if text is None:
        return []
    reactions = (f"{name}.{axis}" for name in text.elements for axis in ("fx", "fy", "torque"))
    prefix, _, rest = incomplete.rpartition(":")
    series = (*text.coordinates, *reactions)
    return [f"{prefix}:{one}" if prefix else one for one in series if one.startswith(rest)]


def methods(incomplete: str) -> list[str]:
    """Integration methods."""
    from runtime.integrate.method import METHODS

    return _beginning(METHODS, incomplete)


def kinds(incomplete: str) -> list[str]:
    """Kinds of elements of the library, with hyphens between their words."""
    files = sorted((LIBRARY / "codegen" / "elements").rglob("*.py"))
    found = (kind for path in files for kind in _KIND.findall(path.read_text(encoding="utf-8")))
    return _beginning((kind.replace(" ", "-") for kind in found), incomplete)


def template_kinds(incomplete: str) -> list[str]:
    """Kinds of models to start from."""
    return _beginning(KINDS, incomplete)


def corrections(incomplete: str) -> list[str]:
    """Ways to return onto the constraints."""
    return _beginning(("step", "stage", "projection", "baumgarte", "hybrid"), incomplete)


def formulations(incomplete: str) -> list[str]:
    """Formulations of a simulation."""
    return _beginning(("cartesian", "reduced"), incomplete)


def _beginning(names: Iterable[str], incomplete: str) -> list[str]:
    return sorted(name for name in set(names) if name.startswith(incomplete))


def _assigned(names: Iterable[str], incomplete: str) -> list[str]:
    return [f"{name}=" for name in names if name.startswith(incomplete)]


def _model(ctx: Any) -> ModelText | None:
    """The text of the model on the line, or of the only one in the folder.

    Words that stand before an option without its value are not parsed: they are in `args`.
    """
    given = ctx.params.get("model") or ()
    words = [str(w) for w in (*((given,) if isinstance(given, str) else given), *ctx.args) if w]
    texts = (find_model_text(word) for word in words if not word.startswith("-"))
    if text := next((text for text in texts if text), None):
        return text
    local = model_names(Path.cwd())
    return find_model_text(f"{local[0]}.py") if len(local) == 1 else None
