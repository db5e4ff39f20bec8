"""Joints along a line of body i, through point i along an axis: a block, or a pin in a slot.

`ALONG` and `ACROSS` are the components u_iᵀ d_ij and (u_i⊥)ᵀ d_ij of d_ij = r_j^P - r_i^P, with the
unit vector u_i = A_i u'_i and u_i⊥ turned from it by +π/2: point j lies ahead of point i where
`ALONG` is positive, and to the left of the line where `ACROSS` is. Written from the centre of body
i, since the part of s'_i is constant: u_iᵀ A_i s'_i = u'_iᵀ s'_i. Screws, racks and drivers measure
along such a line, too.
"""

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.element_fields import Axis, direction, quantity
from codegen.declare.symbols import given
from codegen.drawing import shapes
from codegen.elements.registry import element

AXIS = sympy.Matrix([given("i_ux"), given("i_uy")])
NORMAL = sympy.Matrix([-AXIS[1], AXIS[0]])
DIRECTION = I.A * AXIS
ALONG = DIRECTION.dot(J.point - I.r) - AXIS.dot(I.s)
ACROSS = (I.A * NORMAL).dot(J.point - I.r) - NORMAL.dot(I.s)

ANGLE, DISTANCE = given("angle_offset"), given("distance")
GUIDED = (ACROSS, J.phi - I.phi - ANGLE)
ON_LINE = (ACROSS - DISTANCE,)


def bind_axis(axis: Axis, placeholders: sympy.Matrix = AXIS) -> dict[sympy.Symbol, sympy.Expr]:
    """Placeholders of the unit vector u' → its components; `axis` may have any length but 0."""
    length = sympy.sqrt(axis[0] ** 2 + axis[1] ** 2)
    return {place: a / length for place, a in zip(placeholders, axis, strict=True)}


@element
class Translational(Constraint):
    """The line through point i along `axis` of body i carries point j; the bodies keep their angle.

    Haug (3.3.13) states parallelism by a cross product, v_i⊥ᵀ v_j = 0, which also holds when the
    slider is turned by π. Here the second equation is φ_j - φ_i = const: the same Jacobian up to
    a factor, constant, and with the one solution that is meant.
    """

    kind = "translational"
    example = 'model.translational("guide", P, Q, axis=(2, 1), angle=0.3)'
    name: str
    i: Point
    j: Point
    axis: Axis = direction()
    angle: sympy.Expr = quantity("rad")

    def statement(self) -> Statement:
        """Distance of point j from the line, and the angle between the bodies."""
        bindings = I.bind(self.i) | J.bind(self.j) | bind_axis(self.axis) | {ANGLE: self.angle}
        return Statement(GUIDED, ("normal", "angle"), JointReaction(DIRECTION), bindings)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A block on a guide."""
        return (shapes.Slide(self.i, self.j, *self.axis),)


@element
class RevoluteTranslational(Constraint):
    """(u_i⊥)ᵀ d_ij - c = 0: point j keeps the distance c, to the left, from a line of body i.

    The massless slide block between a guide (body i) and a pin (point j of body j). The reaction's
    x axis points along the line: the guide pushes across it, so `fx` and `torque` are 0.
    `instead_of` names the body that the joint stands for: it acts in the scenes that leave this
    body out.
    """

    kind = "revolute-translational"
    example = 'model.revolute_translational("slot", P, Q, axis=(2, 1))'
    name: str
    i: Point
    j: Point
    axis: Axis = direction()
    distance: sympy.Expr = quantity("m")
    instead_of: Body | None = None

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The two that it connects."""
        return (self.i.body, self.j.body)

    def statement(self) -> Statement:
        """One equation: the distance of point j from the line, m."""
        bindings = I.bind(self.i) | J.bind(self.j) | bind_axis(self.axis)
        bindings |= {DISTANCE: self.distance}
        return Statement(ON_LINE, ("normal",), JointReaction(DIRECTION), bindings)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A pin in a slot."""
        return (shapes.Slot(self.i, self.j, *self.axis),)
