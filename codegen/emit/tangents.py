"""The module of a scene's exact derivatives, which implicit methods ask for."""

from typing import Any

from codegen.emit.module import Origin, counted, laid_out
from codegen.lower.kernels import Lowered
from codegen.lower.program import Program


def tangents_text(lowered: Lowered, program: Program, origin: Origin, module: str) -> str:
    """The whole module, signed with the SHA-256 of its own text.

    Parameters
    ----------
    lowered, program
        The scene, and what differentiates it.
    module
        SHA-256 of the text of the scene's own module, whose ``p`` these kernels take: with another
        one they are stale.
    """
    told = lowered.description
    docstring = [
        f'"""Machine {told.model}, scene {told.scene}: exact derivatives for implicit methods.',
        "",
        "Each kernel differentiates one of the scene's own module along the direction that it is",
        "given, operation by operation, with the modes and parameters held. Arguments in SI units.",
        '"""',
    ]
    tables: dict[str, Any] = {
        "GENERATOR": origin.generator,
        "MODEL": told.model,
        "SCENE": told.scene,
        "SOURCES": origin.sources,
        "DECLARATION_SHA256": origin.declaration,
        "MODULE_SHA256": module,
        "OPERATIONS": counted(program),
    }
    return laid_out(program, origin, docstring, tables, len(told.parameters))
