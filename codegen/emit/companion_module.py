"""The text of a module that goes with a scene's own: its derivatives, its reduced equations."""

from collections.abc import Mapping
from typing import Any

from codegen.emit.module import Origin, counted, laid_out
from codegen.lower.kernels.scene_kernels import Lowered
from codegen.lower.program import Program


def companion_text(
    lowered: Lowered,
    program: Program,
    origin: Origin,
    module: str,
    docstring: tuple[str, ...],
    tables: Mapping[str, Any] | None = None,
    declared: int | None = None,
) -> str:
    """The whole module, signed with the SHA-256 of its own text.

    Parameters
    ----------
    lowered, program
        The scene, and the companion's kernels.
    module
        SHA-256 of the text of the scene's own module: with another one the companion is stale.
    docstring
        What it is, on the first line after the names of machine and scene, and more lines.
    tables
        Tables of its own.
    declared
        Number of slots of ``p`` before the constants; the scene's parameters unless given.
    """
    told = lowered.description
    first, *more = docstring
    head: dict[str, Any] = {
        "GENERATOR": origin.generator,
        "MODEL": told.model,
        "SCENE": told.scene,
        "SOURCES": origin.sources,
        "DECLARATION_SHA256": origin.declaration,
        "MODULE_SHA256": module,
        **(tables or {}),
        "OPERATIONS": counted(program),
    }
    lines = [f'"""Machine {told.model}, scene {told.scene}: {first}', "", *more, '"""']
    slots = len(told.parameters) if declared is None else declared
    return laid_out(program, origin, lines, head, slots)
