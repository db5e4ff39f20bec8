"""Composite revolute-revolute joint: a massless link between two points (Haug 3.3.6)."""

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.element_conditions import Condition, number_problems, sign_conditions
from codegen.declare.symbols import given
from codegen.drawing import shapes
from codegen.elements.registry import element

LENGTH = given("length")
SPAN = J.point - I.point
PHI = (SPAN.dot(SPAN) - LENGTH**2,)


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
    length: sympy.Expr
    instead_of: Body | None = None

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The two that it connects."""
        return (self.i.body, self.j.body)

    def statement(self) -> Statement:
        """One equation: the squared distance of the two points."""
        bindings = I.bind(self.i) | J.bind(self.j) | {LENGTH: self.length}
        return Statement(PHI, ("length",), JointReaction(SPAN / LENGTH), bindings)

    def problems(self) -> list[str]:
        """A link of length 0 is a revolute joint, and singular as a distance."""
        return number_problems(self)

    def conditions(self) -> tuple[Condition, ...]:
        """A link with a length."""
        value = ("length", self.length, "m")
        return sign_conditions(value, positive=True, advice=", or use a revolute joint")

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A rod with a pin at either end."""
        return (shapes.Rod(self.i, self.j),)
