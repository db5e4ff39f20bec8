"""Composite revolute-translational joint: a pin that slides along a line (Haug, section 3.3)."""

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.element_conditions import Condition, number_problems
from codegen.declare.symbols import given
from codegen.drawing import shapes
from codegen.elements.joints.body_line import ACROSS, DIRECTION, Axis, axis_conditions, bind_axis
from codegen.elements.registry import element

DISTANCE = given("distance")
PHI = (ACROSS - DISTANCE,)


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
    axis: Axis
    distance: sympy.Expr
    instead_of: Body | None = None

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The two that it connects."""
        return (self.i.body, self.j.body)

    def statement(self) -> Statement:
        """One equation: the distance of point j from the line, m."""
        bindings = I.bind(self.i) | J.bind(self.j) | bind_axis(self.axis)
        bindings |= {DISTANCE: self.distance}
        return Statement(PHI, ("normal",), JointReaction(DIRECTION), bindings)

    def problems(self) -> list[str]:
        """A zero axis has no direction."""
        return number_problems(self)

    def conditions(self) -> tuple[Condition, ...]:
        """An axis with a direction."""
        return axis_conditions(self.axis)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A pin in a slot."""
        return (shapes.Slot(self.i, self.j, *self.axis),)
