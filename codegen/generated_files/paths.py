"""Where generated files go, and what they are called."""

import hashlib
from collections.abc import Mapping
from pathlib import Path

from codegen.derive.equations import Equations
from codegen.model_file import ModelFile, library_folder


def default_folder(file: ModelFile) -> Path:
    """Where the generated files of a model belong."""
    library = library_folder()
    ours = file.path is not None and file.path.is_relative_to(library / "models")
    return (library if ours else Path.cwd()) / "generated"


def file_name(stem: str, equations: Equations, settings: Mapping[str, float]) -> str:
    """``model__scene.py`` after the model file, with a tail for a build with other defaults."""
    stem = f"{stem}__{equations.scene.name}"
    if settings:
        text = ",".join(f"{name}={value!r}" for name, value in sorted(settings.items()))
        stem += f"__{hashlib.sha256(text.encode()).hexdigest()[:8]}"
    return f"{stem}.py"
