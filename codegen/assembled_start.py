"""The start of a declared scene, assembled as the runtime assembles it before every analysis.

`check`, `draw` and `build` ask here, so that their verdict, and the position, are those of a run.
"""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from codegen.emit.module import Origin, module_text
from codegen.files.generated_modules import scene_path
from codegen.lower.lowered_scene import Lowered
from codegen.machine_code.code_folders import users_folder

if TYPE_CHECKING:
    from runtime.results.assembled_state import Assembly

_KERNELS = ("constants", "constraints", "jacobian", "velocity_rhs", "acceleration_rhs")


def assembled_start(lowered: Lowered) -> "Assembly":
    """The assembled start of a lowered scene; only the kernels that this takes are compiled.

    Their machine code is kept in the user's cache folder. Raises AssemblyError where the scene
    cannot be assembled.
    """
    kernels = tuple(one for one in lowered.program.kernels if one.name in _KERNELS)
    part = replace(lowered, program=replace(lowered.program, kernels=kernels))
    description = lowered.description
    text = module_text(part, Origin("linkwright", (), "", ""))
    folder = users_folder().expanduser() / "starts"
    return assembled_module(scene_path(folder, description.model, description.scene), text)


def assembled_module(path: Path, text: str) -> "Assembly":
    """The assembled start of a generated module; AssemblyError where it has none."""
    from runtime.assembly.assemble import assemble_declared
    from runtime.mechanism.mechanism import read_mechanism

    return assemble_declared(read_mechanism(path, text, path))
