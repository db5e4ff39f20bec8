"""A round body rolls along a line: a pinion on a rack (Haug, section 3.4), a disc on a floor."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.element_fields import Axis, direction, quantity
from codegen.declare.symbols import given
from codegen.drawing import shapes
from codegen.elements.joints import sliding_joints as line
from codegen.elements.registry import element

RADIUS, OFFSET = given("radius"), given("offset")
PHI = (line.ACROSS - RADIUS, line.ALONG + RADIUS * (J.phi - I.phi) - OFFSET)
TO_CONTACT = J.A * J.s - RADIUS * (I.A * line.NORMAL)


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
    axis: Axis = direction()
    radius: sympy.Expr = quantity(
        "m", "positive",
        advice="; for a pinion on the other side of the rack reverse the rack's axis",
    )  # fmt: skip
    offset: sympy.Expr = quantity("m")

    def statement(self) -> Statement:
        """Two equations, m. The rack carries the line, so that it is frame I here."""
        bindings = I.bind(self.rack) | J.bind(self.pinion) | line.bind_axis(self.axis)
        bindings |= {RADIUS: self.radius, OFFSET: self.offset}
        return Statement(PHI, ("normal", "rolling"), JointReaction(line.DIRECTION, J, -1), bindings)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """The pinion and the rack."""
        ux, uy = self.axis
        pinion = shapes.Wheel(self.pinion, self.radius, toothed=True)
        return pinion, shapes.Rack(self.rack, ux, uy, toothed=True)


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
    axis: Axis = direction()
    radius: sympy.Expr = quantity(
        "m", "positive", advice="; for a disc on the other side of the line reverse its axis"
    )
    offset: sympy.Expr = quantity("m")

    def statement(self) -> Statement:
        """Two equations, m. The line is frame I here."""
        bindings = I.bind(self.line) | J.bind(self.disc) | line.bind_axis(self.axis)
        bindings |= {RADIUS: self.radius, OFFSET: self.offset}
        reaction = JointReaction(line.DIRECTION, arm=TO_CONTACT)
        return Statement(PHI, ("normal", "rolling"), reaction, bindings)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """The disc and the line."""
        disc, line = shapes.Wheel(self.disc, self.radius), shapes.Rack(self.line, *self.axis)
        return disc, line
