"""Weld: two bodies move as one."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.element_fields import quantity
from codegen.declare.symbols import given
from codegen.drawing import shapes
from codegen.elements.joints.points import COINCIDENT, X_AXIS
from codegen.elements.registry import element

ANGLE = given("angle")
PHI = (*COINCIDENT, J.phi - I.phi - ANGLE)


@element
class Weld(Constraint):
    """Two bodies are fixed to each other, at a point and at an angle.

    r_i^P - r_j^P = 0 and φ_j - φ_i - α = 0: a revolute joint that cannot turn.

    The reaction is the force and the torque that body i exerts on body j at the point, in axes
    fixed in body i: the load of the seam.
    """

    kind = "weld"
    example = 'model.weld("seam", P, Q, angle=0.3)'
    name: str
    i: Point
    j: Point
    angle: sympy.Expr = quantity("rad")

    def statement(self) -> Statement:
        """Three equations: the x and y distance of the two points, m, and the angle, rad."""
        bindings = I.bind(self.i) | J.bind(self.j) | {ANGLE: self.angle}
        return Statement(PHI, ("x", "y", "angle"), JointReaction(X_AXIS), bindings)

    def shapes(self) -> shapes.Shapes:
        """A rigid connection."""
        return (shapes.Fixing(self.i, self.j),)
