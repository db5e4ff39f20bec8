"""What every driver asks of its law: a function of time and parameters alone."""

import sympy

from codegen.declare.symbols import KINDS, Coordinate, kinds, t


def component(letter: str) -> tuple[str, str]:
    """Name and unit of what a driver exerts along a coordinate of that letter."""
    kind = KINDS[letter]
    if kind.unit == "m":
        return f"f{letter}", kind.force_unit
    return ("torque" if kind.unit == "rad" else "force"), kind.force_unit


def law_problems(where: str, law: sympy.Expr) -> list[str]:
    """A law that contains coordinates is no law of time."""
    return [
        f"{where}: the law {law} contains the coordinate {s.name}; "
        f"a motion law depends on {t} and parameters only."
        for s in kinds(law, Coordinate)
    ]
