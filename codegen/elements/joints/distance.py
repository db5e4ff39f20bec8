"""Distance constraint: two points keep their distance (Haug, sections 3.2 and 3.3)."""

from dataclasses import dataclass
from typing import ClassVar

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Statement
from codegen.elements.joints.revolute_revolute import RevoluteRevolute
from codegen.elements.registry import element


@element
@dataclass(frozen=True, eq=False)
class Distance:
    """(r_j^P - r_i^P)ᵀ (r_j^P - r_i^P) - c² = 0; absolute where one of the points is on the ground.

    The equation is that of a massless link of length c, and so is the reaction: its x axis points
    from point i to point j.
    """

    kind: ClassVar[str] = "distance"
    name: str
    i: Point
    j: Point
    value: sympy.Expr

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies of the two points."""
        return (self.i.body, self.j.body)

    def statement(self) -> Statement:
        """One equation: the squared distance of the two points, m²."""
        return RevoluteRevolute(self.name, self.i, self.j, self.value).statement()

    def problems(self) -> list[str]:
        """Points in one place have no direction between them: that is two equations, not one."""
        if self.value.is_number and not self.value.is_positive:
            where = f"distance '{self.name}'"
            return [f"{where}: the distance {self.value} m is not positive; use a revolute joint."]
        return []
