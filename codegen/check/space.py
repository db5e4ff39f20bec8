"""Checks of machines in space: inertia of rigid bodies, gears between joints of one carrier."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from codegen.declare.element import label
from codegen.declare.space_body import SpaceBody
from codegen.declare.symbols import owners
from codegen.elements.space.transmissions import Teeth

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


def teeth_problems(model: "Model", teeth: Teeth) -> Iterator[str]:
    """Joints of a gear or a rack without a carrier; welds and guides make one body of two."""
    names = [name for row in (teeth.angle, teeth.driven) for name in owners(row)]
    if len(names) != 2 or not {*names} <= {*model.joints}:
        return
    ends = [{*model.joints[name].bodies} for name in names]
    held = [{*j.bodies} for j in model.joints.values() if {*getattr(j, "facing", ())} == {*"hf"}]
    for _ in held:  # a chain of them at most
        ends[0] = ends[0].union(*(pair for pair in held if pair & ends[0]))
    if not ends[0] & ends[-1]:
        bodies = (" and ".join(b.name for b in model.joints[name].bodies) for name in names)
        pairs = ", ".join(f"'{n}' of {two}" for n, two in zip(names, bodies, strict=True))
        yield (
            f"{label(teeth)}: joints {pairs} have no carrier in common, and the angle of a joint "
            "is that of its second body against its first; join both to the body that carries "
            f"them. For a coupling without one write model.constraint(name, {names[1]}."
            f"{teeth.letter} - n * {names[0]}.angle)."
        )
