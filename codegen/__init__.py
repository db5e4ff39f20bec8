"""Linkwright's compiler: a declared mechanism in, a module of numba kernels out.

Public names: `Model` to declare, `build` to compile, the errors, and the words of an element of
one's own: `element` registers its class, which derives from `Constraint` or `Effect`; `Statement`
holds its equations in the placeholders of the frames `I` and `J`. They load SymPy only when they
are first used, so that the runtime can ask for the errors alone.
"""

from codegen.errors import (
    AnalysisError,
    AssemblyError,
    GeneratedFileError,
    InputError,
    LinkwrightError,
    ModelError,
    ModelFileError,
    NoAttributeError,
    ParameterError,
    RedundancyError,
    SceneError,
    SupersededError,
    TableWarning,
    UnknownNameError,
)

TYPE_CHECKING = False  # type checkers take it as true; importing typing would load modules
if TYPE_CHECKING:
    from codegen.declare.body import Body, Curve, Point
    from codegen.declare.cam_profiles import CamProfile, flat_faced_cam, roller_cam
    from codegen.declare.element import (
        ConjugateReaction,
        Constraint,
        Effect,
        I,
        J,
        JointReaction,
        Measure,
        Statement,
        WrenchReaction,
    )
    from codegen.declare.motion_program import MotionProgram, fourier_series, motion_program
    from codegen.declare.outline_files import read_outline, write_path
    from codegen.declare.outlines import Outline, bar, disc, polygon, rectangle
    from codegen.declare.scene import Scene
    from codegen.declare.solid_forms import extruded, read_mesh
    from codegen.declare.space_body import SpaceBody, SpacePoint
    from codegen.declare.space_frame import SpaceFrame
    from codegen.declare.symbols import SPEED, Coordinate, alpha, coordinate, given, t
    from codegen.driver import build
    from codegen.elements.registry import element
    from codegen.generated_files.generated_file import BuildReport
    from codegen.model import Model
    from codegen.model.space_model import SpaceModel
    from codegen.picture_at_start import declared_picture as declared_picture
    from codegen.symbolic_equations import SceneEquations
    from codegen.symbolic_equations import scene_equations as scene_equations

__version__ = "0.1.0"

_ROOMS = {
    "codegen.model": ("Model",),
    "codegen.model.space_model": ("SpaceModel",),
    "codegen.declare.body": ("Body", "Curve", "Point"),
    "codegen.declare.cam_profiles": ("CamProfile", "flat_faced_cam", "roller_cam"),
    "codegen.declare.motion_program": ("MotionProgram", "fourier_series", "motion_program"),
    "codegen.declare.outline_files": ("read_outline", "write_path"),
    "codegen.declare.outlines": ("Outline", "bar", "disc", "polygon", "rectangle"),
    "codegen.declare.element": (
        *("ConjugateReaction", "Constraint", "Effect", "I", "J", "JointReaction", "Measure"),
        *("Statement", "WrenchReaction"),
    ),
    "codegen.declare.scene": ("Scene",),
    "codegen.declare.solid_forms": ("extruded", "read_mesh"),
    "codegen.declare.space_body": ("SpaceBody", "SpacePoint"),
    "codegen.declare.space_frame": ("SpaceFrame",),
    "codegen.declare.symbols": ("SPEED", "Coordinate", "alpha", "coordinate", "given", "t"),
    "codegen.generated_files.generated_file": ("BuildReport",),
    "codegen.driver": ("build",),
    "codegen.picture_at_start": ("declared_picture",),  # for `Model.draw`
    "codegen.elements.registry": ("element",),
    "codegen.symbolic_equations": ("SceneEquations", "scene_equations"),
}
_HOMES = {name: room for room, names in _ROOMS.items() for name in names}

__all__ = ["AnalysisError", "AssemblyError", "Body", "BuildReport", "ConjugateReaction"]
__all__ += ["Constraint", "Coordinate", "Curve", "Effect", "GeneratedFileError", "I", "InputError"]
__all__ += ["J", "JointReaction", "LinkwrightError", "Model", "ModelError", "ModelFileError"]
__all__ += ["SPEED", "NoAttributeError", "Outline", "ParameterError", "Point", "RedundancyError"]
__all__ += ["Measure", "Scene", "SceneEquations", "SceneError", "Statement", "SupersededError"]
__all__ += ["SpaceBody", "SpaceFrame", "SpaceModel", "SpacePoint", "TableWarning"]
__all__ += ["UnknownNameError", "WrenchReaction"]
__all__ += ["__version__", "alpha", "bar", "build", "coordinate", "disc", "element", "given"]
__all__ += ["polygon", "read_outline", "rectangle", "t"]
__all__ += ["CamProfile", "MotionProgram", "flat_faced_cam", "fourier_series", "motion_program"]
__all__ += ["extruded", "read_mesh", "roller_cam", "write_path"]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'codegen' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value
