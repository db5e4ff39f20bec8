"""The module of a scene's equations in fewer coordinates."""

from codegen.emit.arguments import Arguments
from codegen.emit.companion_module import companion_text
from codegen.emit.formula import formula
from codegen.emit.module import Origin
from codegen.lower.kernels.scene_kernels import Lowered
from codegen.reduce.reduced_kernels import Reduced


def reduced_text(lowered: Lowered, reduced: Reduced, origin: Origin, module: str) -> str:
    """The whole module; its ``p`` holds the branches behind the parameters, then its constants.

    Parameters
    ----------
    lowered, reduced
        The scene, and its reduced equations.
    module
        SHA-256 of the text of the scene's own module.
    """
    told, program = lowered.description, reduced.program
    n, m = len(reduced.kept), len(reduced.closures)
    about = (
        "reduced coordinates.",
        f"Left: {n} of {len(told.coordinates)} coordinates, {m} of {len(told.constraints)} rows.",
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
        "JACOBIAN_ROWS": reduced.jacobian.rows,
        "JACOBIAN_COLUMNS": reduced.jacobian.columns,
        "MASS_ROWS": reduced.mass.rows,
        "MASS_COLUMNS": reduced.mass.columns,
    }
    arguments = Arguments.of(told, reduced.kept, len(reduced.branches))
    return companion_text(lowered, program, origin, module, about, tables, arguments)
