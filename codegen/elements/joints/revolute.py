"""Revolute joint: a point of one body coincides with a point of another (Haug 3.3.10)."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.drawing import shapes
from codegen.elements.registry import element

PHI = tuple(I.point - J.point)
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
        return Statement(PHI, ("x", "y"), JointReaction(X_AXIS), bindings)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A pin."""
        return (shapes.Pin(self.i, self.j),)
