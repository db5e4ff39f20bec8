"""The text of a module that goes with a scene's own: its derivatives, its reduced equations."""

from collections.abc import Mapping
from typing import Any

from codegen.emit.arguments import Arguments
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
    arguments: Arguments | None = None,
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
    arguments
        Of its kernels, if they are not the scene's own.
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
    return laid_out(program, origin, lines, head, arguments or Arguments.of(told))
