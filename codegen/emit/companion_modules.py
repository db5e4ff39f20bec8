"""The texts of the modules that go with a scene's own: derivatives, reduced equations, picture.

Each carries the SHA-256 of the text of the scene's own module: with another one it is stale.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from codegen.drawing.picture import VERSION
from codegen.emit.kernel_docstrings import Arguments, formula
from codegen.emit.module import Origin, assemble_module, operation_table
from codegen.lower.kernels.picture_kernels import LoweredPicture
from codegen.lower.lowered_scene import Lowered
from codegen.lower.program import Program
from codegen.reduce.reduced_kernels import Reduced


def tangents_text(lowered: Lowered, program: Program, origin: Origin, module: str) -> str:
    """The module of a scene's exact derivatives, whose kernels take the scene's own ``p``."""
    about = (
        "exact derivatives for implicit methods.",
        "Each kernel differentiates one of the scene's own module along the direction that it is",
        "given, operation by operation, with the modes and parameters held. Arguments in SI units.",
    )
    arguments = Arguments.of(lowered.description)
    return _companion_text(lowered, program, origin, module, about, {}, arguments)


def reduced_text(lowered: Lowered, reduced: Reduced, origin: Origin, module: str) -> str:
    """The module of a scene's reduced equations; in its ``p`` branches precede the constants."""
    description, program = lowered.description, reduced.program
    kept, all_ = (len(x) - len(description.states) for x in (reduced.kept, description.coordinates))
    coordinates = f"{kept} of {all_} coordinates"
    about = (
        "reduced coordinates.",
        f"Left: {coordinates}, {len(reduced.closures)} of {len(description.constraints)} rows.",
        "The kernels are called as those of the scene's own module, of the coordinates",
        "that are left; expand gives all of them. SI units.",
    )
    tables = {
        "FORMULATION": "reduced",
        "KEPT": reduced.kept,
        "CLOSURES": reduced.closures,
        "ANGLES": reduced.angles,
        "BRANCHES": reduced.branches,
        "CONSTANTS": tuple(formula(program, number) for number in program.constants),
        **reduced.jacobian.tables("JACOBIAN"),
        **reduced.mass.tables("MASS"),
    }
    arguments = Arguments.of(description, reduced.kept, len(reduced.branches))
    return _companion_text(lowered, program, origin, module, about, tables, arguments)


def picture_text(lowered: Lowered, picture: LoweredPicture, origin: Origin, module: str) -> str:
    """The module of a scene's picture, whose kernels take the scene's own ``p``."""
    about = (
        "its picture.",
        "picture writes the poses of BODIES and the numbers of SHAPES, in the slots that stand",
        "there, curves the points of curves. SI units.",
    )
    layout = picture.layout
    tables = {
        "LAYOUT": VERSION, "BODIES": plain(layout.bodies), "SHAPES": plain(layout.shapes),
    }  # fmt: skip
    arguments = Arguments.of(lowered.description)
    # Behind the parameters stand the scene's constants, which are none of the picture's.
    origin = replace(origin, unroll="always")
    return _companion_text(lowered, picture.program, origin, module, about, tables, arguments)


def plain(rows: tuple[Any, ...]) -> tuple[Any, ...]:
    """Nested tuples without the names of their fields."""
    return tuple(plain(row) if isinstance(row, tuple) else row for row in rows)


def _companion_text(
    lowered: Lowered, program: Program, origin: Origin, module: str, about: tuple[str, ...],
    tables: Mapping[str, Any], arguments: Arguments,
) -> str:  # fmt: skip
    model, scene, (first, *more) = lowered.description.model, lowered.description.scene, about
    head: dict[str, Any] = {
        "GENERATOR": origin.generator,
        "MODEL": model,
        "SCENE": scene,
        "SOURCES": origin.sources,
        "DECLARATION_SHA256": origin.declaration,
        "MODULE_SHA256": module,
        **tables,
        "OPERATIONS": operation_table(program),
    }
    docstring = [f'"""Machine {model}, scene {scene}: {first}', "", *more, '"""']
    return assemble_module(program, origin, docstring, head, arguments)
