"""Distance constraint: two points keep their distance (Haug, sections 3.2 and 3.3)."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import Constraint, Statement, label
from codegen.elements.joints.revolute_revolute import RevoluteRevolute
from codegen.elements.registry import element


@element
class Distance(Constraint):
    """(r_j^P - r_i^P)ᵀ (r_j^P - r_i^P) - c² = 0; absolute where one of the points is on the ground.

    The equation is that of a massless link of length c, and so is the reaction: its x axis points
    from point i to point j.
    """

    kind = "distance"
    name: str
    i: Point
    j: Point
    value: sympy.Expr

    def statement(self) -> Statement:
        """One equation: the squared distance of the two points, m²."""
        return RevoluteRevolute(self.name, self.i, self.j, self.value).statement()

    def problems(self) -> list[str]:
        """Points in one place have no direction between them: that is two equations, not one."""
        if self.value.is_number and not self.value.is_positive:
            where = f"{label(self)}: the distance {self.value} m"
            return [f"{where} is not positive; use a revolute joint."]
        return []
