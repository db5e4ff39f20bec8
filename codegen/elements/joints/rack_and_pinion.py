"""Rack and pinion: a gear rolls along the pitch line of a toothed bar (Haug, section 3.4)."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.element_conditions import Condition, number_problems, sign_conditions
from codegen.declare.symbols import given
from codegen.drawing import shapes
from codegen.elements.joints import body_line as line
from codegen.elements.registry import element

RADIUS, OFFSET = given("radius"), given("offset")
PHI = (line.ACROSS - RADIUS, line.ALONG + RADIUS * (J.phi - I.phi) - OFFSET)


@element
class RackAndPinion(Constraint):
    """(u⊥)ᵀ d - R = 0 and uᵀ d + R (φ_pinion - φ_rack) - s0 = 0, both bodies free to move.

    With u the rack's axis and d the way from the rack's point, on the pitch line, to the pinion's
    centre: the pinion stays on the left of the axis, at its pitch radius, and rolls without slip.
    A pinion that turns counter-clockwise on a rack held fast moves against the axis; a rack under
    a pinion held in place moves along it. `offset` s0 is uᵀ d at the angle φ_pinion = φ_rack.

    The reaction is the force and torque of the pinion on the rack, in the rack's axes (x along
    `axis`) and about the pinion's centre: `fx` is the force at the teeth, `torque` = R `fx` the
    torque that turns the pinion for it. The teeth bear in both directions and without play; `fy` is
    the force of the guide that keeps the centre at its distance, and not that of a pressure angle.
    """

    kind = "rack-and-pinion"
    example = 'model.rack_and_pinion("teeth", pinion=Q, rack=P, radius=0.2, axis=(1, 0))'
    name: str
    pinion: Point
    rack: Point
    radius: sympy.Expr
    axis: line.Axis
    offset: sympy.Expr

    def statement(self) -> Statement:
        """Two equations, m. The rack carries the line, so that it is frame I here."""
        bindings = I.bind(self.rack) | J.bind(self.pinion) | line.bind_axis(self.axis)
        bindings |= {RADIUS: self.radius, OFFSET: self.offset}
        return Statement(PHI, ("normal", "rolling"), JointReaction(line.DIRECTION, J, -1), bindings)

    def problems(self) -> list[str]:
        """A rack needs a direction, and a pinion a radius."""
        return number_problems(self)

    def conditions(self) -> tuple[Condition, ...]:
        """An axis with a direction, and a pinion with a radius."""
        advice = "; for a pinion on the other side of the rack reverse the rack's axis"
        radius = sign_conditions(("radius", self.radius, "m"), positive=True, advice=advice)
        return line.axis_conditions(self.axis) + radius

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """The pinion and the rack."""
        ux, uy = self.axis
        pinion = shapes.Wheel(self.pinion, self.radius, toothed=True)
        return pinion, shapes.Rack(self.rack, ux, uy, toothed=True)
