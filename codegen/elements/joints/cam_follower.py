"""Cam and follower: two curves touch (Haug 3.4, cam-follower)."""

from collections.abc import Mapping

import numpy as np
import sympy

from codegen.declare.body import Curve
from codegen.declare.cam_profile_checks import compared, in_ground, outward
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.symbols import Coordinate, coordinate, own_coordinate
from codegen.drawing import shapes
from codegen.elements.registry import element
from codegen.parameter_conditions import ALPHAS

AT_I, AT_J = coordinate("contact", "alpha"), coordinate("contact", "beta")

FACING = -0.999  # accuracy: cosine of two normals that oppose each other
AWAY = 20.0  # measured: weight of a step beside the normal against one along it


@element
class CamFollower(Constraint):
    """The contact points coincide, along c_i' and across it, and the tangents are parallel.

    With d = A_iᵀ (r_j + A_j c_j(β) - r_i) - c_i(α) the equations are c_i'ᵀ d = 0, c_i'⊥ᵀ d = 0 and
    c_i'⊥ᵀ A_iᵀ A_j c_j' = 0, each divided by a typical |c_i'|, the last by |c_j'| too, so that
    they are lengths and an angle, nearly. The parameters α and β at the contact are coordinates of
    the joint's own; the first equation determines α and the last one β wherever the curvatures of
    the two curves differ. The reaction acts at the contact, its y axis along the normal, to the
    left of the direction in which α runs; a roller is a circle.
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
        bindings = I.bind(self.cam.body.at(0, 0)) | J.bind(self.follower.body.at(0, 0))
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

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """Both profiles."""
        return shapes.Profile(self.cam), shapes.Profile(self.follower)
