"""The files that go with a scene's own: which scenes get one, and what it holds.

There are two kinds, the exact derivatives that implicit methods take and the equations in reduced
coordinates. Each is written when it is asked for, and brought up to date wherever it exists.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from codegen.artefact import companion_path
from codegen.derive.equations import Equations
from codegen.emit.module import Origin
from codegen.emit.reduced_module import reduced_text
from codegen.emit.tangent_module import tangents_text
from codegen.errors import SceneError
from codegen.generated_files.build_clock import Clock, File
from codegen.lower.differentiation.tangent import tangent_program
from codegen.lower.kernels.scene_kernels import Lowered
from codegen.lower.operation_count import operations
from codegen.lower.program import Program
from codegen.reduce.reduced_kernels import reduce

Made = Callable[[Lowered, Origin, str], tuple[Program, str]]
"""(scene, provenance, SHA-256 of its own module) → kernels and text."""


@dataclass(frozen=True)
class Companion:
    """A kind of file.

    Attributes
    ----------
    name, stage
        The word in the file's name and in ``build(..., NAME=True)``, and what making it is called.
    title
        What it holds, for people.
    missing
        Why a scene has none: the rest of a sentence that begins with its name; empty where it may.
    made
        Its kernels and its text.
    """

    name: str
    stage: str
    title: str
    missing: Callable[[Equations], str]
    made: Made

    def wanted(self, equations: Equations, path: Path, asked: bool) -> bool:
        """Whether a scene gets one: asked for now, or there from before.

        Parameters
        ----------
        path
            The scene's own generated file.
        """
        there = asked or companion_path(path, self.name).is_file()
        return there and not self.missing(equations)

    def file(self, lowered: Lowered, provenance: Origin, main: File) -> File:
        """Make the module that goes with a scene's own file, `main`."""
        clock = Clock({}, main.clock.progress, main.clock.what)
        with clock(self.stage):
            program, text = self.made(lowered, provenance, main.digest)
        counts = {kernel.name: operations(program, kernel) for kernel in program.kernels}
        return File(companion_path(main.path, self.name), text, clock, operations=counts)

    def refuse(self, model: str, scenes: Sequence[Equations], named: bool) -> None:
        """Complain where it is asked for and there is none.

        Parameters
        ----------
        named
            Whether the user named these scenes, instead of taking all there are.

        Raises
        ------
        SceneError
            If a scene that was named can have none, or no scene can.
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
    if equations.sought:
        names = ", ".join(dict.fromkeys(name for name, _ in equations.sought))
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


TANGENTS = Companion("tangents", "differentiate", "derivatives", _tangents_missing, _tangents)
REDUCED = Companion("reduced", "reduce", "reduced", _reduced_missing, _reduced)
COMPANIONS = (TANGENTS, REDUCED)
