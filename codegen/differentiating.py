"""The files of exact derivatives: which scenes get one, and what it holds."""

from collections.abc import Mapping
from pathlib import Path

from codegen.artefact import tangents_path
from codegen.derive.equations import Equations
from codegen.emit.module import Origin
from codegen.emit.tangents import tangents_text
from codegen.errors import SceneError
from codegen.lower.kernels import Lowered
from codegen.lower.ledger import operations
from codegen.lower.tangent import tangent_program
from codegen.stages import Clock, File


def wanted(equations: Equations, path: Path, asked: bool) -> bool:
    """Whether a scene gets a file of derivatives: asked for now, or there from before.

    Parameters
    ----------
    path
        The scene's own generated file.
    """
    return bool(equations.masses) and (asked or tangents_path(path).is_file())


def derivatives(lowered: Lowered, provenance: Origin, main: File) -> File:
    """Differentiate a scene, and write down the module that goes with its own file, `main`."""
    clock = Clock({}, main.clock.progress, main.clock.what)
    with clock("differentiate"):
        program = tangent_program(lowered.program)
        text = tangents_text(lowered, program, provenance, main.digest)
    counts = {kernel.name: operations(program, kernel) for kernel in program.kernels}
    return File(tangents_path(main.path), text, clock, operations=counts)


def refuse_massless(model: str, scenes: Mapping[str, bool], named: bool) -> None:
    """Complain where derivatives are asked for and there is nothing to differentiate.

    Parameters
    ----------
    scenes
        Scene → whether its bodies have masses.
    named
        Whether the user named these scenes, instead of taking all there are.

    Raises
    ------
    SceneError
        If a scene that was named is kinematic, or all scenes are.
    """
    kinematic = [name for name, massive in scenes.items() if not massive]
    if kinematic and (named or len(kinematic) == len(scenes)):
        raise SceneError(
            f"model '{model}', scene '{name}' is kinematic: no masses move in it, so there are no "
            "accelerations under forces to differentiate; ask for derivatives of a scene with "
            "masses, or build this one without --tangents."
            for name in kinematic
        )
