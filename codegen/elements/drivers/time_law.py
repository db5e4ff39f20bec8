"""What every driver asks of its law: a function of time and parameters alone."""

import sympy

from codegen.declare.symbols import Coordinate, kinds, t

COMPONENTS = {
    "x": ("fx", "N"),
    "y": ("fy", "N"),
    "phi": ("torque", "N m"),
    "alpha": ("torque", "N m"),
    "beta": ("torque", "N m"),
}
"""Letter of what is driven → name and unit of what the driver exerts along it."""


def law_problems(where: str, law: sympy.Expr) -> list[str]:
    """A law that contains coordinates is no law of time."""
    return [
        f"{where}: the law {law} contains the coordinate {s.name}; "
        f"a motion law depends on {t} and parameters only."
        for s in kinds(law, Coordinate)
    ]
