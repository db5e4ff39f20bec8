"""Translational joint: one body slides along a line fixed in another, without turning."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.element_conditions import Condition, number_problems
from codegen.declare.symbols import given
from codegen.drawing import shapes
from codegen.elements.joints.body_line import ACROSS, DIRECTION, Axis, axis_conditions, bind_axis
from codegen.elements.registry import element

OFFSET = given("angle_offset")
PHI = (ACROSS, J.phi - I.phi - OFFSET)


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
    axis: Axis
    angle: sympy.Expr

    def statement(self) -> Statement:
        """Distance of point j from the line, and the angle between the bodies."""
        bindings = I.bind(self.i) | J.bind(self.j) | bind_axis(self.axis) | {OFFSET: self.angle}
        return Statement(PHI, ("normal", "angle"), JointReaction(DIRECTION), bindings)

    def problems(self) -> list[str]:
        """A zero axis has no direction."""
        return number_problems(self)

    def conditions(self) -> tuple[Condition, ...]:
        """An axis with a direction."""
        return axis_conditions(self.axis)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A block on a guide."""
        return (shapes.Slide(self.i, self.j, *self.axis),)
