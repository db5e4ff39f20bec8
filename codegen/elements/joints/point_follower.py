"""Point follower: a point of one body moves along a curve of another (Haug 3.4, point-follower)."""

from collections.abc import Mapping

import numpy as np
import sympy

from codegen.declare.body import Curve, Point
from codegen.declare.cam_profile_checks import compared, in_ground
from codegen.declare.element import Constraint, I, J, JointReaction, Statement
from codegen.declare.symbols import Coordinate, coordinate, own_coordinate
from codegen.drawing import shapes
from codegen.elements.registry import element
from codegen.parameter_conditions import ALPHAS

AT = coordinate("contact", "alpha")


@element
class PointFollower(Constraint):
    """d = A_iᵀ (r_j^P - r_i) - c(α) = 0, written along the curve, c'ᵀ d, and across it.

    Both are divided by a typical |c'|, so that they are lengths, nearly.

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
        profile = self.curve.at(AT)
        tangent = profile.diff(AT)
        apart = I.A.T * (J.point - I.r) - profile
        tx, ty = tangent / self.curve.pace
        direction = I.A * tangent / sympy.sqrt(tangent.dot(tangent))
        bindings = I.bind(self.curve.body.at(0, 0)) | J.bind(self.point) | {AT: self.alpha}
        return Statement(
            (tx * apart[0] + ty * apart[1], tx * apart[1] - ty * apart[0]),
            ("along", "across"),
            JointReaction(direction),
            bindings,
            (("along", self.alpha),),
        )

    def near(self, numbers: Mapping[sympy.Symbol, float]) -> dict[Coordinate, float]:
        """The place on the curve for a rough pose: the nearest one to the point."""
        curve = in_ground(self.curve, numbers)
        point = np.array([float(c.subs(numbers)) for c in (self.point.x, self.point.y)])
        with np.errstate(over="ignore"):  # of lengths from 1e154 m on
            apart = np.linalg.norm(curve - point, axis=1)
        return {self.alpha: ALPHAS[int(np.nanargmin(compared(apart)))]}

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """The curve, and a pin that follows it."""
        return shapes.Profile(self.curve), shapes.Mark(self.point)
