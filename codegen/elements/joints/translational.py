"""Translational joint: one body slides along a line fixed in another, without turning."""

from dataclasses import dataclass
from typing import ClassVar

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import I, J, JointReaction, Statement
from codegen.declare.symbols import given
from codegen.elements.joints.body_line import ACROSS, AXIS, DIRECTION
from codegen.elements.registry import element

OFFSET = given("angle_offset")
PHI = (ACROSS, J.phi - I.phi - OFFSET)


@element
@dataclass(frozen=True, eq=False)
class Translational:
    """The line through point i along `axis` of body i carries point j; the bodies keep their angle.

    Haug (3.3.13) states parallelism by a cross product, v_i⊥ᵀ v_j = 0, which also holds when the
    slider is turned by π. Here the second equation is φ_j - φ_i = const: the same Jacobian up to
    a factor, constant, and with the one solution that is meant.
    """

    kind: ClassVar[str] = "translational"
    name: str
    i: Point
    j: Point
    axis: tuple[sympy.Expr, sympy.Expr]
    angle: sympy.Expr

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The guide and the slider."""
        return (self.i.body, self.j.body)

    def statement(self) -> Statement:
        """Distance of point j from the line, and the angle between the bodies."""
        length = sympy.sqrt(self.axis[0] ** 2 + self.axis[1] ** 2)
        ux, uy = AXIS
        bindings = I.bind(self.i) | J.bind(self.j)
        bindings |= {ux: self.axis[0] / length, uy: self.axis[1] / length, OFFSET: self.angle}
        return Statement(PHI, ("normal", "angle"), JointReaction(DIRECTION), bindings)

    def problems(self) -> list[str]:
        """A zero axis has no direction."""
        if all(a == 0 for a in self.axis):
            return [f"translational '{self.name}': the axis (0, 0) has no direction; give one."]
        return []
