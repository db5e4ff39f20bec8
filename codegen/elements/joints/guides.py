"""Joints along a line of body i, through point i along an axis: guides, slots, racks and screws.

`ALONG` and `ACROSS` are the components u_iᵀ d_ij and (u_i⊥)ᵀ d_ij of d_ij = r_j^P - r_i^P, with the
unit vector u_i = A_i u'_i and u_i⊥ turned from it by +π/2: point j lies ahead of point i where
`ALONG` is positive, and to the left of the line where `ACROSS` is. Written from the centre of body
i, since the part of s'_i is constant: u_iᵀ A_i s'_i = u'_iᵀ s'_i.
"""

import sympy

from codegen.declare.body import Bodies, Body, Point
from codegen.declare.element import (
    ConjugateReaction,
    Constraint,
    Frame,
    I,
    J,
    JointReaction,
    Statement,
    label,
)
from codegen.declare.element_fields import Axis, Condition, Conditions, direction, quantity
from codegen.declare.symbols import given
from codegen.drawing import shapes
from codegen.elements.registry import element
from codegen.elements.scalar_measures import (
    Rubbing,
    RubbingJoint,
    angle_problems,
    relative_angle,
    same_body,
    span,
    turned,
)

AXIS = sympy.Matrix([given("i_ux"), given("i_uy")])
NORMAL = sympy.Matrix([-AXIS[1], AXIS[0]])
DIRECTION = I.A * AXIS
ALONG = DIRECTION.dot(J.point - I.r) - AXIS.dot(I.s)
ACROSS = (I.A * NORMAL).dot(J.point - I.r) - NORMAL.dot(I.s)

ANGLE, DISTANCE = given("angle_offset"), given("distance")
GUIDED = (ACROSS, J.phi - I.phi - ANGLE)
ON_LINE = (ACROSS - DISTANCE,)


def bind_axis(axis: Axis, placeholders: sympy.Matrix = AXIS) -> dict[sympy.Symbol, sympy.Expr]:
    """Placeholders of the unit vector u' → its components; `axis` may have any length but 0."""
    length = sympy.sqrt(axis[0] ** 2 + axis[1] ** 2)
    return {place: a / length for place, a in zip(placeholders, axis, strict=True)}


class Guide(RubbingJoint):
    """A point of body j slides along a line of body i."""

    i: Point
    j: Point
    axis: Axis

    def rubbing(self) -> Rubbing:
        """u_iᵀ d along the line, under the force across it."""
        i, j, (dx, dy) = self.i, self.j, span(self.i, self.j)
        ux, uy = turned(i.body, *self.axis)
        along = (ux * dx + uy * dy) / sympy.sqrt(self.axis[0] ** 2 + self.axis[1] ** 2)
        return Rubbing(along, ("fy",), (i.body, j.body), (j.x, j.y), (ux, uy))


@element
class Translational(Guide):
    """A slider: body j slides along a straight guide of body i, and does not turn against it.

    Point j stays on the line through point i along `axis` of body i; the angle between the bodies
    stays constant.

    Haug (3.3.13) states parallelism by a cross product, v_i⊥ᵀ v_j = 0, which also holds when the
    slider is turned by π. Here the second equation is φ_j - φ_i = const. The Jacobian is constant
    and equals Haug's up to a factor, and the equation has only the solution that is meant.
    """

    kind = "translational"
    example = 'model.translational("guide", P, Q, axis=(2, 1), angle=0.3)'
    name: str
    i: Point
    j: Point
    axis: Axis = direction()
    angle: sympy.Expr = quantity("rad")

    def statement(self) -> Statement:
        """Distance of point j from the line, and the angle between the bodies."""
        bindings = I.bind(self.i) | J.bind(self.j) | bind_axis(self.axis) | {ANGLE: self.angle}
        return Statement(GUIDED, ("normal", "angle"), JointReaction(DIRECTION), bindings)

    def shapes(self) -> shapes.Shapes:
        """A block on a guide."""
        return (shapes.Slide(self.i, self.j, *self.axis),)


@element
class RevoluteTranslational(Guide):
    """A pin in a slot: a pin of body j slides along a straight line of body i, and turns in it.

    (u_i⊥)ᵀ d_ij - c = 0: point j keeps the distance c, to the left, from a line of body i.

    This is a massless slide block between a guide (body i) and a pin (point j of body j). The
    reaction's x axis points along the line. The guide pushes across the line, so `fx` and `torque`
    are 0. `instead_of` names the body that the joint replaces: the joint acts in the scenes that
    leave this body out.
    """

    kind = "revolute-translational"
    example = 'model.revolute_translational("slot", P, Q, axis=(2, 1))'
    name: str
    i: Point
    j: Point
    axis: Axis = direction()
    distance: sympy.Expr = quantity("m")
    instead_of: Body | None = None

    @property
    def bodies(self) -> Bodies:
        """The two that it connects."""
        return (self.i.body, self.j.body)

    def statement(self) -> Statement:
        """One equation: the distance of point j from the line, m."""
        bindings = I.bind(self.i) | J.bind(self.j) | bind_axis(self.axis)
        bindings |= {DISTANCE: self.distance}
        return Statement(ON_LINE, ("normal",), JointReaction(DIRECTION), bindings)

    def shapes(self) -> shapes.Shapes:
        """A pin in a slot."""
        return (shapes.Slot(self.i, self.j, *self.axis),)


RADIUS, OFFSET = given("radius"), given("offset")
ROLLING = (ACROSS - RADIUS, ALONG + RADIUS * (J.phi - I.phi) - OFFSET)
TO_CONTACT = J.A * J.s - RADIUS * (I.A * NORMAL)


@element
class RackAndPinion(Constraint):
    """A pinion rolls along a rack, and their teeth do not slip.

    (u⊥)ᵀ d - R = 0 and uᵀ d + R (φ_pinion - φ_rack) - s0 = 0, both bodies free to move.

    u is the rack's axis, and d the vector from the rack's point, on the pitch line, to the pinion's
    centre. The pinion stays to the left of the axis, at its pitch radius, and rolls without slip. A
    pinion that turns counter-clockwise on a fixed rack moves against the axis; a rack under a
    pinion that stays in place moves along the axis. `offset` s0 is uᵀ d where φ_pinion = φ_rack.

    The reaction is the force and torque of the pinion on the rack, in the rack's axes (x along
    `axis`) and about the pinion's centre. `fx` is the force at the teeth, and `torque` = R `fx` the
    torque that turns the pinion against it. The teeth bear in both directions and without play.
    `fy` is the force that keeps the centre at its distance; it does not come from a pressure angle.
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
        bindings = I.bind(self.rack) | J.bind(self.pinion) | bind_axis(self.axis)
        bindings |= {RADIUS: self.radius, OFFSET: self.offset}
        return Statement(ROLLING, ("normal", "rolling"), JointReaction(DIRECTION, J, -1), bindings)

    def shapes(self) -> shapes.Shapes:
        """The pinion and the rack."""
        ux, uy = self.axis
        pinion = shapes.Wheel(self.pinion, self.radius, toothed=True)
        return pinion, shapes.Rack(self.rack, ux, uy, toothed=True)


@element
class RollingDisc(RubbingJoint):
    """A wheel rolls without slip along a straight line, such as a road or a rail.

    (u⊥)ᵀ d - R = 0 and uᵀ d + R (φ_disc - φ_line) - s0 = 0: the disc touches and does not slip.

    u is the direction of the line. d is the vector from the point `line` to the disc's centre. The
    centre stays to the left of the line. `offset` s0 is uᵀ d at φ_disc = φ_line. The equations are
    those of a rack and pinion; a disc on a disc is a gear.

    The reaction is the force of the line on the disc at the contact, in axes of the line: `fx` is
    the traction, `fy` the normal force, `torque` is 0. The disc always stays on the line: a real
    disc would lift off where `fy` is negative, and slide where |fx| exceeds μ fy.
    """

    kind = "rolling disc"
    friction_arm = "arm"
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
        bindings = I.bind(self.line) | J.bind(self.disc) | bind_axis(self.axis)
        bindings |= {RADIUS: self.radius, OFFSET: self.offset}
        reaction = JointReaction(DIRECTION, arm=TO_CONTACT)
        return Statement(ROLLING, ("normal", "rolling"), reaction, bindings)

    def rubbing(self) -> Rubbing:
        """φ_disc - φ_line, under the normal force: it rolls, and slides nowhere."""
        line, disc = self.line.body, self.disc.body
        place, way = (self.disc.x, self.disc.y), turned(line, *self.axis)
        return Rubbing(relative_angle(line, disc), ("fy",), (line, disc), place, way)

    def shapes(self) -> shapes.Shapes:
        """The disc and the line."""
        disc, line = shapes.Wheel(self.disc, self.radius), shapes.Rack(self.line, *self.axis)
        return disc, line


LEAD, SPINDLE = given("lead"), Frame("spindle")
TRAVEL = (ALONG - LEAD / (2 * sympy.pi) * (SPINDLE.phi - I.phi) - OFFSET,)


@element
class Screw(Constraint):
    """A spindle drives a nut along its axis, by one lead in each turn.

    uᵀ d - h/2π (φ_s - φ_i) - s0 = 0: each turn of the spindle moves the nut by its lead h.

    u is the axis in frame i; d is the vector from the point of `frame` to the point of the nut j.
    Here the spindle is a body that turns in the plane. It stands for the motor, or the wheel of a
    bevel gear, that drives the real spindle. A left-hand thread has a negative lead.

    The reaction is the force along the axis on the nut, N; -h/2π times this force turns the
    spindle. The guide that carries the nut is a separate joint. There is no friction, and no play.
    """

    kind = "screw"
    example = """
        spindle = model.body("spindle", mass=1.0, inertia=0.002)
        model.screw("thread", P, Q, spindle, lead=0.05, axis=(1, 0))
    """
    name: str
    frame: Point
    nut: Point
    spindle: Body
    lead: sympy.Expr = quantity("m")
    axis: Axis = direction()
    offset: sympy.Expr = quantity("m")

    def statement(self) -> Statement:
        """One equation, m: the nut's place along the axis."""
        bindings = I.bind(self.frame) | J.bind(self.nut) | bind_axis(self.axis)
        bindings |= SPINDLE.bind(Point(self.spindle, 0, 0))
        bindings |= {LEAD: self.lead, OFFSET: self.offset}
        return Statement(TRAVEL, ("travel",), ConjugateReaction((("force", "N"),)), bindings)

    def problems(self) -> list[str]:
        """Bodies that are no screw."""
        frame, nut = self.frame.body, self.nut.body
        problems = angle_problems(self, frame, self.spindle)
        problems += same_body(label(self), (frame, nut))
        if self.spindle is frame:
            problems.append(
                f"{label(self)}: the spindle '{frame.name}' is the frame in which it turns; give "
                "two bodies."
            )
        return problems

    def conditions(self) -> Conditions:
        """A thread that rises."""
        text = "the lead is {1:g} m, and the nut never moves; give the travel of one turn."
        return (Condition(text, (self.lead**2, self.lead), open=True),)

    def shapes(self) -> shapes.Shapes:
        """The nut on its axis."""
        return (shapes.Slide(self.frame, self.nut, *self.axis),)
