"""Scenes of a study: read, compiled and loaded; undeclared variants are compiled in a cache."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from codegen import argument_readers as readers
from codegen.errors import AnalysisError, InputError
from runtime.machine_loading import load

if TYPE_CHECKING:
    from codegen import Model, Scene
    from runtime.machine_facade import Machine

CACHE = ".linkwright_cache"  # folder for modules of undeclared scenes, in the user's folder
LEFT_OUT = "none"  # fidelity of an effect left out: `codegen.reading.scene_variants.Variant.word`

_VALUES = readers.optional(readers.values('{"mass": 2.0}'))
_INSTANT = readers.number("a finite number of seconds")
READERS = {
    "model": readers.model, "scene": readers.optional(readers.scene),
    "folder": readers.optional(readers.path), "generated": readers.optional(readers.path),
    **dict.fromkeys(("parameters", "guess", "start"), _VALUES),
    "t_end": readers.optional(_INSTANT), "t_start": _INSTANT, "progress": readers.study_reporter,
}  # fmt: skip
"""Arguments that all studies take."""


class Source(NamedTuple):
    """The model and scene that a user named, the folder of the work, that of the modules."""

    given: "str | os.PathLike[str] | Model"
    given_scene: "str | Scene | None"
    folder: str | os.PathLike[str] | None
    generated: str | os.PathLike[str] | None
    model: "Model"
    scene: "Scene"

    def machine(self, scene: "Scene | None" = None) -> "Machine":
        """The machine of the named scene, or of another of the model, as `load` finds it."""
        named = self.given_scene if scene is None else scene.name if scene.root is None else scene
        scene = scene or self.scene
        if isinstance(named, str | None) and not hasattr(self.given, "scenes"):
            return load(self.given, scene.name, folder=self.folder, generated=self.generated)
        return self.variant(scene)

    def variant(self, scene: "Scene") -> "Machine":
        """The machine of an undeclared scene of the model, compiled in the cache."""
        return load(self.model, scene, folder=cache_folder(self.folder))


def read_source(
    model: "str | os.PathLike[str] | Model", scene: "str | Scene | None",
    folder: str | os.PathLike[str] | None, generated: str | os.PathLike[str] | None = None,
) -> Source:  # fmt: skip
    """Read the model, and find the scene in it: the first unless one is named."""
    from codegen.reading.scene_variants import declared

    read = declared(Path(model) if isinstance(model, os.PathLike) else model, scene)
    return Source(model, scene, folder, generated, *read)


def cache_folder(folder: str | os.PathLike[str] | None) -> Path:
    """The cache in the user's folder, created if need be and hidden from version control."""
    path = (Path(folder) if folder is not None else Path.cwd()) / CACHE
    try:
        path.mkdir(exist_ok=True)
        (path / ".gitignore").write_text("*\n", encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{path}: undeclared scenes are compiled in this folder, which cannot be written "
            f"({error.strerror}); give folder=, or work in another folder."
        ) from error
    return path


def known_values(
    machine: "Machine", parameters: Mapping[str, float], guess: Mapping[str, float],
    start: Mapping[str, float],
) -> dict[str, dict[str, float]]:  # fmt: skip
    """The arguments of an analysis: those values that the scene has; `start` where it has one."""
    rows = machine.coordinates
    states = {*rows.names, *(row.velocity for row in rows)}
    values = {
        "parameters": {k: x for k, x in parameters.items() if k in machine.parameters.names},
        "guess": {k: x for k, x in guess.items() if k in states},
    }
    kept = {k: x for k, x in start.items() if k in states}
    return values | ({"start": kept} if kept else {})


def require_time_span(machine: "Machine", t_start: float, t_end: float | None) -> float:
    """The last instant of a run, s; refused if it is missing, or not after the first."""
    title = machine.description.title
    if t_end is None:
        raise AnalysisError(f"{title}: t_end is missing; give the last instant in s (--t-end).")
    if not t_start < t_end < float("inf"):
        raise AnalysisError(
            f"{title}: the time span from {t_start:g} to {t_end:g} s must be finite and positive."
        )
    return float(t_end)


def analysis_of(machine: "Machine") -> str:
    """The analysis that a scene is meant for."""
    description = machine.description
    if description.analysis == "equilibrium":
        return "equilibrium"
    if description.drivers and machine.is_determined:
        return "inverse_dynamics" if description.has_masses else "kinematics"
    return "simulate"
