"""The module of a scene's exact derivatives, which implicit methods ask for."""

from codegen.emit.companion_module import companion_text
from codegen.emit.module import Origin
from codegen.lower.kernels.scene_kernels import Lowered
from codegen.lower.program import Program

ABOUT = (
    "exact derivatives for implicit methods.",
    "Each kernel differentiates one of the scene's own module along the direction that it is",
    "given, operation by operation, with the modes and parameters held. Arguments in SI units.",
)


def tangents_text(lowered: Lowered, program: Program, origin: Origin, module: str) -> str:
    """The whole module; its kernels take the ``p`` of the scene's own, whose SHA-256 is `module`.

    Parameters
    ----------
    lowered, program
        The scene, and what differentiates it.
    """
    return companion_text(lowered, program, origin, module, ABOUT)
