"""The coordinate of a joint with one freedom of its own: an angle, or a travel along a line."""

import sympy

from codegen.declare.element import Constraint
from codegen.elements.forces.scalar_measures import relative_angle, span
from codegen.elements.joints.revolute import Revolute
from codegen.elements.joints.revolute_translational import RevoluteTranslational
from codegen.elements.joints.translational import Translational

JOINTS = (Revolute, Translational, RevoluteTranslational)


def joint_coordinate(joint: Constraint) -> tuple[sympy.Expr, str]:
    """φ_j - φ_i of a revolute joint, else u_iᵀ d along the line of body i, and its unit."""
    assert isinstance(joint, JOINTS)
    if isinstance(joint, Revolute):
        return relative_angle(joint.i.body, joint.j.body), "rad"
    ux, uy = joint.axis
    c, s = joint.i.body.rotation
    dx, dy = span(joint.i, joint.j)
    size = sympy.sqrt(ux**2 + uy**2)
    return ((ux * c - uy * s) * dx + (ux * s + uy * c) * dy) / size, "m"
