"""Points that coincide, or that keep their distance (Haug 3.2 and 3.3)."""

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.element_fields import quantity
from codegen.declare.symbols import given
from codegen.drawing import shapes
from codegen.elements.registry import element

COINCIDENT = tuple(I.point - J.point)
X_AXIS = I.A * sympy.Matrix([1, 0])


@element
class Revolute(Constraint):
    """r_i + A_i s'_i - r_j - A_j s'_j = 0; the reaction axes are those of the first body."""

    kind = "revolute"
    example = 'model.revolute("pin", P, Q)'
    name: str
    i: Point
    j: Point

    def statement(self) -> Statement:
        """Two equations, the x and y distance of the two points."""
        bindings = I.bind(self.i) | J.bind(self.j)
        return Statement(COINCIDENT, ("x", "y"), JointReaction(X_AXIS), bindings)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A pin."""
        return (shapes.Pin(self.i, self.j),)


LENGTH = given("length")
SPAN = J.point - I.point
LINK = (SPAN.dot(SPAN) - LENGTH**2,)


@element
class RevoluteRevolute(Constraint):
    """(r_j^P - r_i^P)ᵀ (r_j^P - r_i^P) - L² = 0; the reaction's x axis points along the link.

    `instead_of` names the body that the link stands for: the joint acts in the scenes that leave
    this body out.
    """

    kind = "revolute-revolute"
    example = 'model.revolute_revolute("link", P, Q, 2.0)'
    name: str
    i: Point
    j: Point
    length: sympy.Expr = quantity(
        "m", "positive", binds="positive", advice=", or use a revolute joint"
    )
    instead_of: Body | None = None

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The two that it connects."""
        return (self.i.body, self.j.body)

    def statement(self) -> Statement:
        """One equation: the squared distance of the two points."""
        bindings = I.bind(self.i) | J.bind(self.j) | {LENGTH: self.length}
        return Statement(LINK, ("length",), JointReaction(SPAN / LENGTH), bindings)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A rod with a pin at either end."""
        return (shapes.Rod(self.i, self.j),)


@element
class Distance(RevoluteRevolute):
    """(r_j^P - r_i^P)ᵀ (r_j^P - r_i^P) - c² = 0; absolute where one of the points is on the ground.

    The equation is that of a massless link of length c, and so is the reaction: its x axis points
    from point i to point j.
    """

    kind = "distance"
    example = 'model.distance("wire", P, Q, 2.0)'
