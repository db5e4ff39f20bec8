"""Joints in space, made of three kinds of equations.

Two points coincide, r_i + A_i s'_i - r_j - A_j s'_j = 0; two vectors are perpendicular, aᵀ b = 0;
a vector is perpendicular to the line between two points, aᵀ d = 0 with d = r_j^P - r_i^P (E. J.
Haug, Computer-Aided Kinematics and Dynamics of Mechanical Systems, 1989, 9.4). Body i has the axis
h of a joint and two vectors f, g perpendicular to it and to each other; body j has h, too.
"""

from typing import ClassVar

import sympy

from codegen.declare.element import Constraint, Statement, WrenchReaction
from codegen.declare.element_fields import quantity, shared_fields
from codegen.declare.space_body import SpacePoint, Three
from codegen.declare.space_frame import I, J
from codegen.declare.symbols import given
from codegen.elements.registry import element

SPAN = J.point - I.point
COINCIDENT = tuple(-SPAN)
F, G, H_I = I.vector("f"), I.vector("g"), I.vector("h")
F_J, H_J = J.vector("f"), J.vector("h")
PARALLEL = (F.dot(H_J), G.dot(H_J))
ON_LINE = (F.dot(SPAN), G.dot(SPAN))
LENGTH = given("length")


@shared_fields
class JointInSpace(Constraint):
    """A joint at a point of each of two bodies, with the wrench on body j at its point."""

    phi: ClassVar[tuple[sympy.Expr, ...]]
    rows: ClassVar[tuple[str, ...]]
    name: str
    i: SpacePoint
    j: SpacePoint

    def vectors(self) -> tuple[dict[str, Three], dict[str, Three]]:
        """Vectors of bodies i and j by letter, in their frames."""
        return {}, {}

    def statement(self) -> Statement:
        """The equations of its class."""
        of_i, of_j = self.vectors()
        bindings = I.bind(self.i, **of_i) | J.bind(self.j, **of_j)
        return Statement(self.phi, self.rows, WrenchReaction(J), bindings)


@shared_fields
class JointWithAxis(JointInSpace):
    """A joint with an axis: f, g and h of body i, f and h of body j."""

    axes: tuple[Three, Three, Three, Three, Three]

    def vectors(self) -> tuple[dict[str, Three], dict[str, Three]]:
        """f, g and h of body i; f and h of body j."""
        f, g, h, f_j, h_j = self.axes
        return {"f": f, "g": g, "h": h}, {"f": f_j, "h": h_j}


@element(space=True)
class Spherical(JointInSpace):
    """A ball joint: a point of body i and a point of body j coincide."""

    kind = "spherical"
    phi, rows = COINCIDENT, ("x", "y", "z")


@element(space=True)
class RevoluteInSpace(JointWithAxis):
    """A hinge: two points coincide and both bodies share an axis.

    r_i^P - r_j^P = 0, f_iᵀ h_j = 0 and g_iᵀ h_j = 0.
    """

    kind = "revolute in space"
    phi, rows = (*COINCIDENT, *PARALLEL), ("x", "y", "z", "f", "g")


@element(space=True)
class Cylindrical(JointWithAxis):
    """Body j turns about an axis of body i and slides along it.

    f_iᵀ d = 0, g_iᵀ d = 0, f_iᵀ h_j = 0 and g_iᵀ h_j = 0.
    """

    kind = "cylindrical"
    phi, rows = (*ON_LINE, *PARALLEL), ("line_f", "line_g", "f", "g")


@element(space=True)
class TranslationalInSpace(JointWithAxis):
    """Body j slides along an axis of body i and does not turn against it.

    The equations of a cylindrical joint, and g_iᵀ f_j = 0.
    """

    kind = "translational in space"
    phi = (*ON_LINE, *PARALLEL, G.dot(F_J))
    rows = ("line_f", "line_g", "f", "g", "turn")


@element(space=True)
class WeldInSpace(JointWithAxis):
    """Two bodies are fixed to each other.

    r_i^P - r_j^P = 0, f_iᵀ h_j = 0, g_iᵀ h_j = 0 and g_iᵀ f_j = 0.
    """

    kind = "weld in space"
    phi = (*COINCIDENT, *PARALLEL, G.dot(F_J))
    rows = ("x", "y", "z", "f", "g", "turn")


@element(space=True)
class Universal(JointInSpace):
    """A Cardan joint: two points coincide, and an axis of each body stays perpendicular.

    r_i^P - r_j^P = 0 and h_iᵀ h_j = 0.
    """

    kind = "universal"
    phi, rows = (*COINCIDENT, H_I.dot(H_J)), ("x", "y", "z", "cross")
    axis_i: Three
    axis_j: Three

    def vectors(self) -> tuple[dict[str, Three], dict[str, Three]]:
        """h of both bodies."""
        return {"h": self.axis_i}, {"h": self.axis_j}


@element(space=True)
class DistanceInSpace(JointInSpace):
    """Two points keep their distance, as a massless rod with two ball joints makes them.

    dᵀ d - L² = 0.
    """

    kind = "distance in space"
    phi, rows = (SPAN.dot(SPAN) - LENGTH**2,), ("length",)
    length: sympy.Expr = quantity("m", "positive", advice=", or use a spherical joint")

    def statement(self) -> Statement:
        """One equation: the squared distance of the two points."""
        bindings = I.bind(self.i) | J.bind(self.j) | {LENGTH: self.length}
        return Statement(self.phi, self.rows, WrenchReaction(J), bindings)
