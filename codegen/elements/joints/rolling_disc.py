"""Rolling disc: a disc rolls along a line of another body without slip."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.element_conditions import Condition, number_problems, sign_conditions
from codegen.drawing import shapes
from codegen.elements.joints import body_line as line
from codegen.elements.joints.body_line import Axis
from codegen.elements.joints.rack_and_pinion import OFFSET, PHI, RADIUS
from codegen.elements.registry import element

TO_CONTACT = J.A * J.s - RADIUS * (I.A * line.NORMAL)


@element
class RollingDisc(Constraint):
    """(u⊥)ᵀ d - R = 0 and uᵀ d + R (φ_disc - φ_line) - s0 = 0: the disc touches and does not slip.

    With u the direction of the line and d the way from its point to the disc's centre, which stays
    on the left of the line. In the plane rolling is a matter of positions: `offset` s0 is uᵀ d at
    φ_disc = φ_line. The equations are those of a rack and pinion; a disc on a disc is a gear.

    The reaction is the force of the line on the disc at the contact, in axes of the line: `fx` is
    the traction, `fy` the normal force, `torque` is 0. The disc is held on the line and never
    slips: it would lift off where `fy` is negative, and slide where |fx| exceeds μ fy.
    """

    kind = "rolling disc"
    example = 'model.rolling_disc("roll", disc=Q, line=P, radius=0.2, axis=(1, 0))'
    name: str
    disc: Point
    line: Point
    radius: sympy.Expr
    axis: Axis
    offset: sympy.Expr

    def statement(self) -> Statement:
        """Two equations, m. The line is frame I here."""
        bindings = I.bind(self.line) | J.bind(self.disc) | line.bind_axis(self.axis)
        bindings |= {RADIUS: self.radius, OFFSET: self.offset}
        reaction = JointReaction(line.DIRECTION, arm=TO_CONTACT)
        return Statement(PHI, ("normal", "rolling"), reaction, bindings)

    def problems(self) -> list[str]:
        """A line needs a direction, and a disc a radius."""
        return number_problems(self)

    def conditions(self) -> tuple[Condition, ...]:
        """A line with a direction, and a disc with a radius."""
        advice = "; for a disc on the other side of the line reverse its axis"
        radius = sign_conditions(("radius", self.radius, "m"), positive=True, advice=advice)
        return line.axis_conditions(self.axis) + radius

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """The disc and the line."""
        disc, line = shapes.Wheel(self.disc, self.radius), shapes.Rack(self.line, *self.axis)
        return disc, line
