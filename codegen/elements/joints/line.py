"""A line of body i, through point i along an axis: what sliding joints, racks and drivers measure.

`ALONG` and `ACROSS` are the components u_iᵀ d_ij and (u_i⊥)ᵀ d_ij of d_ij = r_j^P - r_i^P, with the
unit vector u_i = A_i u'_i and u_i⊥ turned from it by +π/2: point j lies ahead of point i where
`ALONG` is positive, and to the left of the line where `ACROSS` is.
"""

import sympy

from codegen.declare.element import I, J
from codegen.elements.joints.translational import AXIS, NORMAL

Axis = tuple[sympy.Expr, sympy.Expr]
DIRECTION = I.A * AXIS
ALONG = DIRECTION.dot(J.point - I.point)
ACROSS = (I.A * NORMAL).dot(J.point - I.point)


def bind_axis(axis: Axis) -> dict[sympy.Symbol, sympy.Expr]:
    """Placeholders of the unit vector u'_i → its components; `axis` may have any length but 0."""
    length = sympy.sqrt(axis[0] ** 2 + axis[1] ** 2)
    return {placeholder: a / length for placeholder, a in zip(AXIS, axis, strict=True)}


def axis_problems(where: str, axis: Axis) -> list[str]:
    """A zero axis has no direction."""
    if all(a == 0 for a in axis):
        return [f"{where}: the axis (0, 0) has no direction; give one."]
    return []
