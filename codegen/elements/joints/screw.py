"""Screw: a nut travels in proportion to the turn of a spindle."""

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import ConjugateReaction, Constraint, Frame, I, J, Statement, label
from codegen.declare.element_conditions import Condition
from codegen.declare.element_fields import Axis, direction, quantity
from codegen.declare.symbols import given
from codegen.drawing import shapes
from codegen.elements.joints import sliding_joints as line
from codegen.elements.registry import element

LEAD, SPINDLE, OFFSET = given("lead"), Frame("spindle"), given("offset")
PHI = (line.ALONG - LEAD / (2 * sympy.pi) * (SPINDLE.phi - I.phi) - OFFSET,)


@element
class Screw(Constraint):
    """uᵀ d - h/2π (φ_s - φ_i) - s0 = 0: each turn of the spindle moves the nut by its lead h.

    With u the axis in the frame i, and d the way from its point to that of the nut j. The spindle's
    own axis would lie in the plane; here the body that stands for it turns in the plane, as the
    wheel of a bevel gear before it, or a motor, would. A left-hand thread has a negative lead.

    The reaction is the force along the axis on the nut, N; -h/2π times it turns the spindle. A
    guide that carries the nut is a joint of its own. There is no friction, and no play.
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
        bindings = I.bind(self.frame) | J.bind(self.nut) | line.bind_axis(self.axis)
        bindings |= SPINDLE.bind(self.spindle.at(0, 0))
        bindings |= {LEAD: self.lead, OFFSET: self.offset}
        return Statement(PHI, ("travel",), ConjugateReaction((("force", "N"),)), bindings)

    def problems(self) -> list[str]:
        """Bodies that are no screw."""
        frame, nut = self.frame.body, self.nut.body
        problems = [
            f"{label(self)} needs the angle of '{body.name}', which has none; use a body with an "
            "angle."
            for body in (frame, self.spindle)
            if body.angle is None or not body.turns
        ]
        if frame is nut:
            problems.append(f"{label(self)} is between body '{nut.name}' and itself; give two.")
        if self.spindle is frame:
            problems.append(
                f"{label(self)}: the spindle '{frame.name}' is the frame in which it turns; give "
                "two bodies."
            )
        return problems

    def conditions(self) -> tuple[Condition, ...]:
        """A thread that rises."""
        text = "the lead is {1:g} m, and the nut never moves; give the travel of one turn."
        return (Condition(text, (self.lead**2, self.lead), open=True),)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """The nut on its axis."""
        return (shapes.Slide(self.frame, self.nut, *self.axis),)
