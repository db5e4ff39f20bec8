"""The wrench of a joint in space: the force and torque that its multipliers stand for.

    F = -Φ_rᵀ λ,   n = -Φ_πᵀ λ,   T = n - (A s') × F at the point s',

with the turn δπ about global axes, ∂A/∂π_k = ẽ_k A (E. J. Haug, Computer-Aided Kinematics and
Dynamics of Mechanical Systems, 1989, 11.3).
"""

import sympy

from codegen.declare.element import WrenchReaction
from codegen.declare.symbols import Multiplier, derivative

AXES = "xyz"


def wrench(
    phi: tuple[sympy.Expr, ...], multipliers: tuple[Multiplier, ...], reaction: WrenchReaction
) -> tuple[tuple[str, str, sympy.Expr], ...]:
    """(component, unit, value): fx, fy, fz, tx, ty, tz in global axes; axial of a rod."""
    assert reaction.arm is not None
    on = reaction.on
    entries = {entry: sympy.Dummy(str(entry), real=True) for entry in on.A}
    back = {symbol: entry for entry, symbol in entries.items()}
    matrix = on.A.xreplace(entries)
    held = zip(phi[: reaction.rows], multipliers[: reaction.rows], strict=True)
    pairs = tuple((e.xreplace(entries), lam) for e, lam in held)
    force = sympy.Matrix([-sum(derivative(e, r) * lam for e, lam in pairs) for r in on.r])
    couple = sympy.zeros(3, 1)
    for j in range(3):  # the column j of A, which a turn moves as a vector
        column = matrix[:, j]
        slopes = [-sum(derivative(e, entry) * lam for e, lam in pairs) for entry in column]
        couple += column.cross(sympy.Matrix(slopes))
    torque = couple - sympy.Matrix(reaction.arm).xreplace(entries).cross(force)
    values = [*force, *torque.applyfunc(sympy.expand)]
    words = [*((f"f{c}", "N") for c in AXES), *((f"t{c}", "N m") for c in AXES)]
    if reaction.tension is not None:
        words, values = [*words, ("axial", "N")], [*values, reaction.tension * multipliers[0]]
    return tuple((*word, value.xreplace(back)) for word, value in zip(words, values, strict=True))
