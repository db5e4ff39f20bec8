"""Applied force at a point, and applied torque: any expression of t, q, q̇ and parameters."""

from typing import Literal

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Effect, Measure, label
from codegen.declare.symbols import Coordinate
from codegen.elements.registry import element


@element
class AppliedForce(Effect):
    """F at a point P: Q_r = F, Q_φ = (B s')ᵀ F (Haug 6.1), with F in global or in body axes."""

    kind = "force"
    name: str
    point: Point
    fx: sympy.Expr
    fy: sympy.Expr
    frame: Literal["ground", "body"] = "ground"

    def forces(self, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
        """The generalized forces on x, y and φ."""
        body, fx, fy = self.point.body, self.fx, self.fy
        (x, y), (c, s) = body.position, body.rotation
        if self.frame == "body":
            torque = self.point.sx * fy - self.point.sy * fx
            fx, fy = c * fx - s * fy, s * fx + c * fy
        else:
            torque = (self.point.x - x) * fy - (self.point.y - y) * fx
        return {body.x: fx, body.y: fy, **({} if torque == 0 else body.torque(torque))}

    def measures(self, bodies: tuple[Body, ...]) -> tuple[Measure, ...]:
        """F, in the axes in which it is given."""
        return Measure("force", "fx", "N", self.fx), Measure("force", "fy", "N", self.fy)

    def problems(self) -> list[str]:
        """The ground cannot be pushed."""
        if self.point.body.fixed:
            return [f"{label(self)} acts on the ground; give a moving body."]
        return []


@element
class AppliedTorque(Effect):
    """A torque about the axis normal to the plane, counter-clockwise positive."""

    kind = "torque"
    name: str
    body: Body
    value: sympy.Expr

    def forces(self, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
        """Q_φ, or the generalized forces that do the same work."""
        return self.body.torque(self.value)

    def measures(self, bodies: tuple[Body, ...]) -> tuple[Measure, ...]:
        """The torque."""
        return (Measure("torque", "", "N m", self.value),)

    def problems(self) -> list[str]:
        """The ground cannot be turned, and a particle has nothing to turn."""
        if self.body.fixed:
            return [f"{label(self)} acts on the ground; give a moving body."]
        if not self.body.turns:
            name = self.body.name
            return [f"{label(self)} turns '{name}', which is a particle; use a body."]
        return []
