"""Cam and flat-faced follower: a curve touches a straight line (Haug 3.4)."""

from collections.abc import Mapping
from math import atan2, cos, sin

import numpy as np
import sympy

from codegen.declare.body import Curve, Point
from codegen.declare.cam_profile_checks import compared, places
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.element_conditions import Condition, number_problems
from codegen.declare.symbols import Coordinate, alpha, coordinate, given, own_coordinate
from codegen.drawing import shapes
from codegen.elements.joints.body_line import Axis, axis_conditions, bind_axis
from codegen.elements.registry import element
from codegen.parameter_conditions import ALPHAS

AXIS = sympy.Matrix([given("j_ux"), given("j_uy")])
NORMAL = sympy.Matrix([-AXIS[1], AXIS[0]])
AT = coordinate("contact", "alpha")


@element
class CamFlatFollower(Constraint):
    """n_jᵀ (r_i + A_i c(α) - r_j^P) = 0 and n_jᵀ A_i c'(α) = 0: the face touches the profile c.

    The second equation is divided by a typical |c'|, so that it is an angle, nearly.

    The parameter α at the contact is a coordinate of the joint's own. The second equation
    determines it, since n_jᵀ A_i c'' vanishes nowhere on a convex profile. With the normal
    n = (-u_y, u_x) of the face's axis u pointing from the cam into the follower, the component fy
    of the reaction is the force of contact: where it is negative, the follower would lift off.
    """

    kind = "cam and flat-faced follower"
    example = """
        e = model.parameter("e", 0.1, unit="m")
        model.cam_flat_follower("touch", i.circle(0.5, center=(e, 0)), Q, axis=(1, 0))
    """
    name: str
    cam: Curve
    face: Point
    axis: Axis
    alpha = own_coordinate("alpha", "The profile's parameter at the contact, rad.")

    def statement(self) -> Statement:
        """The face's distance from the contact, and the profile's slope against the face."""
        profile = self.cam.at(AT)
        normal = J.A * NORMAL
        phi = (
            normal.dot(I.r + I.A * profile - J.r) - NORMAL.dot(J.s),
            normal.dot(I.A * (profile.diff(AT) / self.cam.pace)),
        )
        bindings = I.bind(self.cam.body.at(0, 0)) | J.bind(self.face) | {AT: self.alpha}
        bindings |= bind_axis(self.axis, AXIS)
        reaction = JointReaction(J.A * AXIS)
        return Statement(phi, ("normal", "slope"), reaction, bindings, (("slope", self.alpha),))

    def near(self, numbers: Mapping[sympy.Symbol, float]) -> dict[Coordinate, float]:
        """The contact for a rough pose: where the cam reaches farthest towards the follower."""
        ends = (body.rotation for body in (self.cam.body, self.face.body))
        cam, face = (atan2(*(float(a.subs(numbers)) for a in (s, c))) for c, s in ends)
        tilt = face - cam
        ux, uy = (float(a.subs(numbers)) for a in self.axis)
        towards = np.array([-uy * cos(tilt) - ux * sin(tilt), ux * cos(tilt) - uy * sin(tilt)])
        reach = places(self.cam.at(alpha).subs(numbers)) @ towards
        return {self.alpha: ALPHAS[int(np.argmax(compared(reach)))]}

    def problems(self) -> list[str]:
        """A face needs a direction."""
        return number_problems(self)

    def profiles(self) -> tuple[tuple[Curve, bool], ...]:
        """The closed curves, and whether each has to be convex."""
        return ((self.cam, True),)

    def conditions(self) -> tuple[Condition, ...]:
        """An axis with a direction."""
        return axis_conditions(self.axis)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """The profile, and the line of the face."""
        ux, uy = self.axis
        return shapes.Profile(self.cam), shapes.Rack(self.face, ux, uy)
