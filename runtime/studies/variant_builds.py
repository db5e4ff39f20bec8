"""Where scenes are compiled that nobody declared: variants made to be compared."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

from codegen.errors import InputError
from runtime.load import load

if TYPE_CHECKING:
    from codegen import Model, Scene
    from runtime.machine import Machine

CACHE = ".linkwright_cache"
"""Folder for their modules, in the one that the user works in."""


def cache(folder: str | os.PathLike[str] | None) -> Path:
    """The folder for such scenes, made if need be, hidden from version control as caches are.

    Parameters
    ----------
    folder
        The one that the user works in; the current directory if None.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    path = (Path(folder) if folder is not None else Path.cwd()) / CACHE
    try:
        path.mkdir(exist_ok=True)
        (path / ".gitignore").write_text("*\n", encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{path}: scenes that nobody declared are compiled there, and it cannot be written "
            f"({error.strerror}); give folder=, or work in another folder."
        ) from error
    return path


def loaded(
    model: "str | os.PathLike[str] | Model",
    scene: "str | Scene | None",
    found: "tuple[Model, Scene]",
    folder: str | os.PathLike[str] | None,
) -> "Machine":
    """The machine that a user named, as `load` finds it; of a scene made on the fly, in the cache.

    Parameters
    ----------
    model, scene, folder
        What the user gave.
    found
        The model that was read, and its scene.
    """
    read, chosen = found
    if isinstance(scene, str | None) and not hasattr(model, "scenes"):
        return load(model, chosen.name, folder=folder)
    return load(read, chosen, folder=cache(folder))
