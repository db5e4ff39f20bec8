"""Completion of the words of a command line: models, scenes, parameters, elements, methods.

Names come from the text of the model file that stands on the line, without executing it.
"""

import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

import typer

from codegen.errors import ModelFileError
from codegen.files.library_folders import LIBRARY, find_model_file, model_names, models_folder
from codegen.files.model_text import ModelText, read_model_text
from runtime.integrate.method import METHODS

MODELS_TO_START_FROM = ("four-bar", "slider-crank", "pendulum", "cam-follower")
"""Kinds of models that `new` writes: each is a file of `linkwright/templates`."""

_KIND = re.compile(r'^    kind = "([^"]+)"', re.MULTILINE)


def models(incomplete: str) -> list[str]:
    """Model files and folders that go on from what is typed, and models by name."""
    typed = Path(incomplete)
    folder = typed if incomplete.endswith("/") or not incomplete else typed.parent
    found = [(folder / f"{name}.py").as_posix() for name in model_names(folder.resolve())]
    if incomplete:
        inside = (path for path in folder.glob("[!._]*") if path.is_dir())
        found += sorted(f"{path.as_posix()}/" for path in inside)
    for place in (Path("models"), models_folder()):
        found += model_names(place) if place and "/" not in incomplete else []
    return [name for name in dict.fromkeys(found) if name.startswith(incomplete)]


def _of_model(
    names: Callable[[ModelText], Iterable[str]], *, behind_colon: bool = False
) -> Callable[..., list[str]]:
    """A completion by names of the model on the line, if wanted behind a ``max:`` that is typed."""

    def complete(ctx: typer.Context, incomplete: str) -> list[str]:
        start = incomplete[: incomplete.rfind(":") + 1] if behind_colon else ""
        found = (f"{start}{name}" for name in names(_model(ctx)))
        return [name for name in found if name.startswith(incomplete)]

    return complete


def scenes(ctx: typer.Context, incomplete: str) -> list[tuple[str, str]]:
    """Scenes of the model on the line, with their descriptions."""
    found = _model(ctx).scenes.items()
    return [(name, line) for name, line in found if name.startswith(incomplete)]


settings = _of_model(lambda text: (f"{name}=" for name in text.parameters))
coordinates = _of_model(lambda text: (f"{name}=" for name in text.coordinates))
quantities = _of_model(lambda text: [
    *text.coordinates, *(f"{name}.{x}" for name in text.elements for x in ("fx", "fy", "torque"))
], behind_colon=True)  # fmt: skip


def one_of(*names: str) -> Callable[[str], list[str]]:
    """A completion by some names."""
    return lambda incomplete: sorted(name for name in names if name.startswith(incomplete))


def kinds(incomplete: str) -> list[str]:
    """Kinds of elements of the library, with hyphens between their words."""
    files = (LIBRARY / "codegen" / "elements").rglob("*.py")
    names = {kind for path in files for kind in _KIND.findall(path.read_text(encoding="utf-8"))}
    return one_of(*(kind.replace(" ", "-") for kind in names))(incomplete)


methods = one_of(*METHODS)
models_to_start_from = one_of(*MODELS_TO_START_FROM)
corrections = one_of("step", "stage", "projection", "baumgarte", "hybrid")
formulations = one_of("cartesian", "reduced")
analyses = one_of("simulate", "kinematics", "inverse-dynamics", "equilibrium")


def _model(ctx: typer.Context) -> ModelText:
    """The text of the model on the line, or of the only one in the folder; empty without any."""
    given = ctx.params.get("model") or ()
    words = [str(w) for w in (*((given,) if isinstance(given, str) else given), *ctx.args) if w]
    local = model_names(Path.cwd())  # in args: what stands before an option without its value
    words += [f"{local[0]}.py"] if len(local) == 1 else []
    for word in words:
        with suppress(ModelFileError):
            text = None if word.startswith("-") else read_model_text(find_model_file(word))
            if text is not None:
                return text
    return ModelText(Path())
