"""Absolute constraints: a point's x or y, or a body's angle, keeps a value (Haug 3.2.1-3.2.3)."""

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.symbols import Letter, given
from codegen.drawing import shapes
from codegen.elements.joints.revolute import X_AXIS
from codegen.elements.registry import element

VALUE = given("value")
LEFT_SIDE = {"x": J.point[0], "y": J.point[1], "phi": J.phi}


@element
class Absolute(Constraint):
    """x_j^P = c, y_j^P = c or φ_j = c; the reaction is that of the ground on the body."""

    kind = "absolute"
    example = 'model.absolute("level", Q, "y", 0.5)'
    name: str
    ground: Body
    point: Point
    letter: Letter
    value: sympy.Expr

    def statement(self) -> Statement:
        """One equation."""
        bindings = I.bind(self.ground.at(0, 0)) | J.bind(self.point) | {VALUE: self.value}
        phi = (LEFT_SIDE[self.letter] - VALUE,)
        return Statement(phi, (self.letter,), JointReaction(X_AXIS), bindings)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A mark at the point."""
        return (shapes.Mark(self.point),)
