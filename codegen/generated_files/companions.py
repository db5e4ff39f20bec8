"""Companion modules of a scene: exact derivatives, reduced equations, its picture, all outputs.

Each kind is written on request, and updated wherever it exists.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

from codegen.derive.equations import Equations, derive
from codegen.emit.module import (
    Origin,
    module_text,
    operation_table,
    picture_text,
    reduced_text,
    tangents_text,
)
from codegen.errors import SceneError
from codegen.files.generated_modules import companion_path
from codegen.generated_files.generated_file import Clock, CompanionReport, FileReport
from codegen.lower.differentiation.program_tangents import tangent_program
from codegen.lower.kernels.picture_kernels import lower_picture
from codegen.lower.lowered_scene import Lowered, lower
from codegen.lower.program import Program
from codegen.model import Model
from codegen.model.scene_requests import DEFAULT, OF_ANALYSIS
from codegen.reduce.reduced_kernels import reduce

Emit = Callable[[Lowered, Origin, str], tuple[Program, str]]
"""(scene, provenance, SHA-256 of its own module) → kernels and text."""


@dataclass(frozen=True)
class Companion:
    """A kind of companion module."""

    name: str  # the word in the file's name and in `build(..., NAME=True)`
    stage: str
    title: str  # its content, for people
    # Why a scene can have none: the rest of a sentence that begins with its name; else empty.
    missing: Callable[[Equations], str]
    emit: Emit  # its kernels and its text

    def is_due(self, equations: Equations, path: Path, requested: bool) -> bool:
        """Whether the scene of the file `path` gets one: requested now, or existing from before."""
        due = requested or companion_path(path, self.name).is_file()
        return due and not self.missing(equations)

    def file(
        self, lowered: Lowered, provenance: Origin, main: FileReport, clock: Clock
    ) -> CompanionReport:
        """The companion of a scene's own file, `main`."""
        own = Clock({}, clock.progress, clock.title)
        with own(self.stage):
            program, text = self.emit(lowered, provenance, main.digest)
        return CompanionReport(
            path=companion_path(main.path, self.name), text=text, title=self.title,
            operations=dict(operation_table(program)), seconds=own.seconds,
        )  # fmt: skip

    def refuse(self, model: str, scenes: Sequence[Equations], named: bool) -> None:
        """Refuse a request for scenes that can have none.

        Raises SceneError if a scene that was named can have none, or no scene can; `named`: the
        user named these scenes, instead of taking all there are.
        """
        missing: Mapping[str, str] = {e.scene.name: self.missing(e) for e in scenes}
        if all(missing.values()) or (named and any(missing.values())):
            raise SceneError(
                f"model '{model}', scene '{name}' {why} or build this one without --{self.name}."
                for name, why in missing.items()
                if why
            )


def _tangents_missing(equations: Equations) -> str:
    if equations.mass:
        return ""
    return (
        "is kinematic: no masses move in it, so there are no accelerations under forces to "
        "differentiate; ask for derivatives of a scene with masses,"
    )


def _reduced_missing(equations: Equations) -> str:
    if not equations.mass or equations.scene.analysis == "equilibrium":
        return (
            "is not for dynamics: there are no accelerations under forces in it to write in "
            "reduced coordinates; ask for a scene with masses that moves,"
        )
    if equations.stiction:
        names = ", ".join(dict.fromkeys(name for name, _ in equations.stiction))
        return (
            f"has frictions that stick by the force of a reaction ({names}), which reduced "
            "coordinates leave out; give them creep=,"
        )
    return ""


def _tangents(lowered: Lowered, provenance: Origin, module: str) -> tuple[Program, str]:
    program = tangent_program(lowered.program)
    return program, tangents_text(lowered, program, provenance, module)


def _reduced(lowered: Lowered, provenance: Origin, module: str) -> tuple[Program, str]:
    reduced = reduce(lowered)
    return reduced.program, reduced_text(lowered, reduced, provenance, module)


def _picture(lowered: Lowered, provenance: Origin, module: str) -> tuple[Program, str]:
    picture = lower_picture(lowered)
    return picture.program, picture_text(lowered, picture, provenance, module)


def _outputs(lowered: Lowered, provenance: Origin, module: str) -> tuple[Program, str]:
    """The scene's own module again, with the same coordinates and all outputs."""
    scene = lowered.scene.equations.scene
    words = (DEFAULT, *(word for word in OF_ANALYSIS[scene.analysis] if word != "works"))
    named = replace(scene.with_(outputs=words), name=scene.name, counted=scene.counted)
    whole = lower(derive(cast(Model, scene.owner), named), lowered.shared)
    return whole.program, module_text(whole, provenance, module)


COMPANIONS = (
    Companion("tangents", "differentiate", "derivatives", _tangents_missing, _tangents),
    Companion("reduced", "reduce", "reduced", _reduced_missing, _reduced),
    Companion("picture", "picture", "picture", lambda equations: "", _picture),
    Companion("outputs", "outputs", "all outputs", lambda equations: "", _outputs),
)
