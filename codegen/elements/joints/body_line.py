"""A line of body i, through point i along an axis: sliding joints, racks and drivers measure it.

`ALONG` and `ACROSS` are the components u_iᵀ d_ij and (u_i⊥)ᵀ d_ij of d_ij = r_j^P - r_i^P, with the
unit vector u_i = A_i u'_i and u_i⊥ turned from it by +π/2: point j lies ahead of point i where
`ALONG` is positive, and to the left of the line where `ACROSS` is. Written from the centre of body
i, since the part of s'_i is constant: u_iᵀ A_i s'_i = u'_iᵀ s'_i.
"""

import sympy

from codegen.declare.element import I, J
from codegen.declare.element_conditions import Condition
from codegen.declare.symbols import given

Axis = tuple[sympy.Expr, sympy.Expr]
AXIS = sympy.Matrix([given("i_ux"), given("i_uy")])
NORMAL = sympy.Matrix([-AXIS[1], AXIS[0]])
DIRECTION = I.A * AXIS
ALONG = DIRECTION.dot(J.point - I.r) - AXIS.dot(I.s)
ACROSS = (I.A * NORMAL).dot(J.point - I.r) - NORMAL.dot(I.s)


def bind_axis(axis: Axis, placeholders: sympy.Matrix = AXIS) -> dict[sympy.Symbol, sympy.Expr]:
    """Placeholders of the unit vector u' → its components; `axis` may have any length but 0."""
    length = sympy.sqrt(axis[0] ** 2 + axis[1] ** 2)
    return {place: a / length for place, a in zip(placeholders, axis, strict=True)}


def axis_conditions(axis: Axis) -> tuple[Condition, ...]:
    """A zero axis has no direction."""
    ux, uy = axis
    text = "the axis ({1:g}, {2:g}) has no direction; give one."
    return (Condition(text, (ux**2 + uy**2, ux, uy), open=True),)
