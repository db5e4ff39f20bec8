"""Two joints in space with a body without mass between them, the coupler, as one joint.

See E. J. Haug, Computer-Aided Kinematics and Dynamics of Mechanical Systems, 1989, 9.4. The coupler
of two ball joints is a distance, that of two hinges with intersecting axes a universal joint, and
that of a guide and a ball joint a strut.
"""

import sympy

from codegen.declare.element_fields import quantity, shared_fields
from codegen.declare.space_body import SpacePoint, Three
from codegen.declare.space_frame import I, J
from codegen.drawing.shapes import Rod, Shapes
from codegen.drawing.space_shapes import SpaceJoint
from codegen.elements.registry import element
from codegen.elements.space.joints import (
    COSINE,
    COUNTED,
    H_I,
    IN_PLANE,
    LINK,
    ON_LINE,
    PARALLEL,
    SLIDE,
    SPAN,
    JointWithAxis,
)

U, M, N = I.vector("u"), I.vector("m"), I.vector("n")
K_J = J.vector("k")


@shared_fields
class Link(JointWithAxis):
    """A coupler of given length, perpendicular to the axis of body i."""

    numbers = ("length",)
    length: sympy.Expr = quantity("m", "positive")

    def shapes(self) -> Shapes:
        """A rod."""
        return (Rod(self.i, self.j),)


@element(space=True)
class RevoluteSpherical(Link):
    """A link without mass turns about an axis of body i; a ball joint holds it to body j.

    h_iᵀ d = 0 and dᵀ d - L² = 0: the point of body j stays on a circle about the axis.
    """

    kind = "revolute-spherical"
    facing = ()
    phi, rows = (*IN_PLANE, *LINK), ("plane", "length")


@element(space=True)
class RevoluteRevoluteInSpace(Link):
    """A link without mass with a hinge at either end, whose axes are parallel.

    f_iᵀ h_j = 0, g_iᵀ h_j = 0, h_iᵀ d = 0 and dᵀ d - L² = 0. With axes that intersect it is a
    universal joint.
    """

    kind = "revolute-revolute in space"
    countable = ("angle",)
    phi, rows = (*PARALLEL, *IN_PLANE, *LINK), ("f", "g", "plane", "length")


@element(space=True)
class RevoluteCylindrical(JointWithAxis):
    """A sleeve without mass slides along an axis of body i and turns; a hinge holds it to body j.

    f_iᵀ d = 0, g_iᵀ d = 0 and h_iᵀ k_j - cos α = 0, with the hinge k_j, which meets the axis h_i.
    """

    kind = "revolute-cylindrical"
    form = "bead"
    countable, facing = ("slide",), ()
    phi, rows = (*ON_LINE, H_I.dot(K_J) - COSINE), ("line_f", "line_g", "cross")
    numbers = ("cosine",)
    hinge: Three
    cosine: sympy.Expr = quantity()

    def vectors(self) -> tuple[dict[str, Three], dict[str, Three]]:
        """The axis of body i, and the hinge of body j."""
        of_i, of_j = super().vectors()
        return of_i, of_j | {"k": self.hinge}


@element(space=True)
class RevoluteTranslationalInSpace(JointWithAxis):
    """A block without mass slides along a line of body i; a hinge holds it to body j.

    f_iᵀ h_j = 0, g_iᵀ h_j = 0, m_iᵀ d = 0 and n_iᵀ d = 0, with the hinge h and the line u; m and n
    are perpendicular to u.
    """

    kind = "revolute-translational in space"
    countable = ("angle", "slide")
    counts = COUNTED | {"slide": (SLIDE, U.dot(SPAN) - SLIDE)}
    phi, rows = (*PARALLEL, M.dot(SPAN), N.dot(SPAN)), ("f", "g", "line_m", "line_n")
    line: tuple[Three, Three, Three]

    def vectors(self) -> tuple[dict[str, Three], dict[str, Three]]:
        """f, g and h of both, and of body i the line."""
        of_i, of_j = super().vectors()
        return of_i | dict(zip("umn", self.line, strict=True)), of_j

    def shapes(self) -> Shapes:
        """A block on a rail."""
        return (SpaceJoint(self.i, self.j, "rail", SpacePoint(self.i.body, *self.line[0])),)
