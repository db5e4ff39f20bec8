"""Checks of bodies in space: whether their inertia is one of a rigid body."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from codegen.declare.space_body import SpaceBody

if TYPE_CHECKING:
    from codegen.model import Model

_ROUNDING = 1e-9  # accuracy: part of the largest moment; what exceeds less is rounding


def inertia_problems(model: "Model", body: SpaceBody) -> Iterator[str]:
    """An inertia that is not positive definite, or that no distribution of mass has."""
    if body.inertia is None:
        return
    where = f"inertia of body '{body.name}'"
    symbols = body.inertia.free_symbols
    if unknown := sorted(s.name for s in symbols if s not in model.defaults):
        yield (
            f"{where}: unknown symbol {', '.join(map(repr, unknown))}; an inertia consists of "
            "numbers and expressions of parameters."
        )
        return
    try:
        matrix = np.array(body.inertia.subs(model.defaults).tolist(), float)
        moments = np.linalg.eigvalsh(matrix)
    except (TypeError, ValueError, ArithmeticError, np.linalg.LinAlgError):
        yield f"{where} is {body.inertia.tolist()}; give finite real numbers in kg m^2."
        return
    shown = ", ".join(f"{moment:.6g}" for moment in moments)
    if not moments[0] > 0.0:
        yield f"{where} has the principal moments {shown} kg m^2; all three must be positive."
    elif moments[2] > (1.0 + _ROUNDING) * (moments[0] + moments[1]):
        yield (
            f"{where} has the principal moments {shown} kg m^2, of which the largest exceeds the "
            "sum of the others; no distribution of mass has that. Check units and axes."
        )
