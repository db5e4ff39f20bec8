"""Joints in which curves touch: a cam on a flat face or a roller, a point on a curve (Haug 3.4)."""

from collections.abc import Mapping
from math import atan2, cos, sin

import numpy as np
import sympy

from codegen.declare.body import Curve, Point
from codegen.declare.element import I, J, JointReaction, Statement
from codegen.declare.element_fields import Axis, compared, direction, in_ground, outward, places
from codegen.declare.symbols import Coordinate, alpha, coordinate, given, own_coordinate
from codegen.drawing import shapes
from codegen.elements.joints.guides import bind_axis
from codegen.elements.registry import element
from codegen.elements.scalar_measures import Rubbing, RubbingJoint, sliding, turned
from codegen.parameter_conditions import ALPHAS, SAMPLES

AXIS = sympy.Matrix([given("j_ux"), given("j_uy")])
NORMAL = sympy.Matrix([-AXIS[1], AXIS[0]])
AT_I, AT_J = coordinate("contact", "alpha"), coordinate("contact", "beta")

FACING = -0.999  # accuracy: cosine of two normals that oppose each other
AWAY = 20.0  # measured: weight of a step beside the normal against one along it


def sliding_on(cam: Curve, at: Coordinate, point: Point) -> Rubbing:
    """A point slides along a curve, in the direction in which its parameter grows."""
    tangent = cam.at(at).diff(at)
    way = turned(cam.body, *(tangent / sympy.sqrt(tangent.dot(tangent))))
    return sliding((cam.body, point.body), (point.x, point.y), way)


@element
class CamFlatFollower(RubbingJoint):
    """A cam of body i pushes the flat face of body j, and touches it at one point.

    n_jᵀ (r_i + A_i c(α) - r_j^P) = 0 and n_jᵀ A_i c'(α) = 0: the face touches the profile c.

    The second equation is divided by a typical |c'|, so that it is nearly an angle.

    The parameter α at the contact is a coordinate of the joint's own. The second equation
    determines it, since n_jᵀ A_i c'' vanishes nowhere on a convex profile. If the normal n = (-u_y,
    u_x) of the face's axis u points from the cam into the follower, the component fy of the
    reaction is the contact force: where fy is negative, the follower would lift off.
    """

    kind = "cam and flat-faced follower"
    example = """
        e = model.parameter("e", 0.1, unit="m")
        model.cam_flat_follower("touch", i.circle(0.5, center=(e, 0)), Q, axis=(1, 0))
    """
    name: str
    cam: Curve
    face: Point
    axis: Axis = direction()
    alpha = own_coordinate("alpha", "The profile's parameter at the contact, rad.")

    def statement(self) -> Statement:
        """The face's distance from the contact, and the profile's slope against the face."""
        profile = self.cam.at(AT_I)
        normal = J.A * NORMAL
        phi = (
            normal.dot(I.r + I.A * profile - J.r) - NORMAL.dot(J.s),
            normal.dot(I.A * (profile.diff(AT_I) / self.cam.pace)),
        )
        bindings = I.bind(Point(self.cam.body, 0, 0)) | J.bind(self.face) | {AT_I: self.alpha}
        bindings |= bind_axis(self.axis, AXIS)
        reaction = JointReaction(J.A * AXIS)
        return Statement(phi, ("normal", "slope"), reaction, bindings, (("slope", self.alpha),))

    def rubbing(self) -> Rubbing:
        """The face slides on the cam along its axis."""
        contact, (ux, uy) = Point(self.cam.body, *self.cam.at(self.alpha)), self.axis
        way = turned(self.face.body, *(u / sympy.sqrt(ux**2 + uy**2) for u in (ux, uy)))
        return sliding((self.cam.body, self.face.body), (contact.x, contact.y), way)

    def near(self, numbers: Mapping[sympy.Symbol, float]) -> dict[Coordinate, float]:
        """The contact for a rough pose: where the cam reaches farthest towards the follower."""
        ends = (body.rotation for body in (self.cam.body, self.face.body))
        cam, face = (atan2(*(float(a.subs(numbers)) for a in (s, c))) for c, s in ends)
        tilt = face - cam
        ux, uy = (float(a.subs(numbers)) for a in self.axis)
        towards = np.array([-uy * cos(tilt) - ux * sin(tilt), ux * cos(tilt) - uy * sin(tilt)])
        reach = places(self.cam.at(alpha).subs(numbers)) @ towards
        return {self.alpha: ALPHAS[int(np.argmax(compared(reach)))]}

    def profiles(self) -> tuple[tuple[Curve, bool], ...]:
        """The closed curves, and whether each has to be convex."""
        return ((self.cam, True),)

    def shapes(self) -> shapes.Shapes:
        """The profile, and the line of the face."""
        ux, uy = self.axis
        return shapes.Profile(self.cam), shapes.Rack(self.face, ux, uy)


@element
class CamFollower(RubbingJoint):
    """A cam of body i pushes a curved follower of body j, such as a roller of any shape.

    The contact points coincide, along c_i' and across it, and the tangents are parallel.

    With d = A_iᵀ (r_j + A_j c_j(β) - r_i) - c_i(α) the equations are c_i'ᵀ d = 0, c_i'⊥ᵀ d = 0 and
    c_i'⊥ᵀ A_iᵀ A_j c_j' = 0. Each is divided by a typical |c_i'|, the third by |c_j'| too: the
    first two are nearly lengths in m, the third nearly an angle in rad. The parameters α and β at
    the contact are the joint's own coordinates. The first equation determines α; the third one
    determines β where the curvatures of the two curves differ. The reaction acts at the contact.
    The y axis of the reaction is the normal to the left of the direction in which α grows.
    """

    kind = "cam and follower"
    example = """
        e = model.parameter("e", 0.1, unit="m")
        model.cam_follower("touch", i.circle(0.5, center=(e, 0)), j.circle(0.25))
    """
    name: str
    cam: Curve
    follower: Curve
    alpha = own_coordinate("alpha", "The parameter of the cam's profile at the contact, rad.")
    beta = own_coordinate("beta", "The parameter of the follower's profile at the contact, rad.")

    def statement(self) -> Statement:
        """Three equations and two coordinates."""
        on_cam, on_follower = self.cam.at(AT_I), self.follower.at(AT_J)
        tangent = on_cam.diff(AT_I)
        normal = sympy.Matrix([-tangent[1], tangent[0]]) / self.cam.pace
        arm = J.A * on_follower
        apart = I.A.T * (J.r + arm - I.r) - on_cam
        slope = I.A.T * (J.A * on_follower.diff(AT_J) / self.follower.pace)
        bindings = I.bind(Point(self.cam.body, 0, 0)) | J.bind(Point(self.follower.body, 0, 0))
        bindings |= {AT_I: self.alpha, AT_J: self.beta}
        direction = I.A * tangent / sympy.sqrt(tangent.dot(tangent))
        along, across = (axis.dot(apart) for axis in (tangent / self.cam.pace, normal))
        return Statement(
            (along, across, normal.dot(slope)),
            ("along", "across", "slope"),
            JointReaction(direction, arm=arm),
            bindings,
            (("along", self.alpha), ("slope", self.beta)),
        )

    def rubbing(self) -> Rubbing:
        """The curves slide along their common tangent."""
        contact = Point(self.follower.body, *self.follower.at(self.beta))
        return sliding_on(self.cam, self.alpha, contact)

    def profiles(self) -> tuple[tuple[Curve, bool], ...]:
        """The closed curves, and whether each has to be convex."""
        return (self.cam, False), (self.follower, False)

    def near(self, numbers: Mapping[sympy.Symbol, float]) -> dict[Coordinate, float]:
        """The contact for a rough pose: from outside, where the curves face each other closest.

        Of the pairs of points whose outward normals oppose, the one that lies most along them.
        """
        one, other = (in_ground(curve, numbers)[::4] for curve in (self.cam, self.follower))
        out_one, out_other = outward(one), outward(other)
        apart = other[None] - one[:, None]
        gap = np.einsum("ijk,ik->ij", apart, out_one)
        sideways = np.hypot(*np.moveaxis(apart - gap[..., None] * out_one[:, None], 2, 0))
        score = np.where(out_one @ out_other.T < FACING, gap - AWAY * sideways, -np.inf)
        on_cam, on_follower = divmod(int(np.argmax(compared(score))), len(other))
        return {self.alpha: ALPHAS[4 * on_cam], self.beta: ALPHAS[4 * on_follower]}

    def touches_inside(self, numbers: Mapping[sympy.Symbol, float]) -> bool:
        """Whether the outward normals point the same way where α and β are: a roller in a ring."""
        normals = [
            outward(in_ground(curve, numbers))[round(numbers[q] / ALPHAS[1]) % SAMPLES]
            for curve, q in ((self.cam, self.alpha), (self.follower, self.beta))
        ]
        return bool(normals[0] @ normals[1] > 0.0)

    def shapes(self) -> shapes.Shapes:
        """Both profiles."""
        return shapes.Profile(self.cam), shapes.Profile(self.follower)


@element
class PointFollower(RubbingJoint):
    """A point of body j, a pin or a knife edge, follows a curve of body i: a cam or a slot.

    d = A_iᵀ (r_j^P - r_i) - c(α) = 0, as two equations: along the curve, c'ᵀ d, and across it.

    Both are divided by a typical |c'|, so that they are nearly lengths.

    The parameter α is a coordinate of the joint's own; the equation along the curve determines
    it, with the derivative -c'ᵀ c'. Haug writes the two equations in global axes, where neither
    determines α at every orientation.
    """

    kind = "point follower"
    example = """
        a = model.parameter("a", 0.6, unit="m")
        model.point_follower("slot", i.curve(a * cos(alpha), 0.5 * sin(alpha)), Q)
    """
    name: str
    curve: Curve
    point: Point
    alpha = own_coordinate("alpha", "The curve's parameter at the point, rad.")

    def statement(self) -> Statement:
        """Distance of the point from the curve's, along the tangent and across it."""
        profile = self.curve.at(AT_I)
        tangent = profile.diff(AT_I)
        apart = I.A.T * (J.point - I.r) - profile
        tx, ty = tangent / self.curve.pace
        direction = I.A * tangent / sympy.sqrt(tangent.dot(tangent))
        bindings = I.bind(Point(self.curve.body, 0, 0)) | J.bind(self.point) | {AT_I: self.alpha}
        return Statement(
            (tx * apart[0] + ty * apart[1], tx * apart[1] - ty * apart[0]),
            ("along", "across"),
            JointReaction(direction),
            bindings,
            (("along", self.alpha),),
        )

    def rubbing(self) -> Rubbing:
        """The point slides along the curve."""
        return sliding_on(self.curve, self.alpha, self.point)

    def near(self, numbers: Mapping[sympy.Symbol, float]) -> dict[Coordinate, float]:
        """The place on the curve for a rough pose: the nearest one to the point."""
        curve = in_ground(self.curve, numbers)
        point = np.array([float(c.subs(numbers)) for c in (self.point.x, self.point.y)])
        with np.errstate(over="ignore"):  # of lengths from 1e154 m on
            apart = np.linalg.norm(curve - point, axis=1)
        return {self.alpha: ALPHAS[int(np.nanargmin(compared(apart)))]}

    def shapes(self) -> shapes.Shapes:
        """The curve, and a pin that follows it."""
        return shapes.Profile(self.curve), shapes.Mark(self.point)
