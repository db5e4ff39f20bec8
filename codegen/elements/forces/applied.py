"""Applied force at a point, and applied torque: any expression of t, q, q̇ and parameters."""

from dataclasses import dataclass
from typing import ClassVar, Literal

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.symbols import Coordinate
from codegen.elements.registry import element


@element
@dataclass(frozen=True, eq=False)
class AppliedForce:
    """F at a point P: Q_r = F, Q_φ = (B s')ᵀ F (Haug 6.1), with F in global or in body axes."""

    kind: ClassVar[str] = "force"
    name: str
    point: Point
    fx: sympy.Expr
    fy: sympy.Expr
    frame: Literal["ground", "body"] = "ground"

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The body that the force acts on."""
        return (self.point.body,)

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """An applied force is not asked whether it has a potential."""
        return None

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

    def problems(self) -> list[str]:
        """The ground cannot be pushed."""
        if self.point.body.fixed:
            return [f"force '{self.name}' acts on the ground; give a moving body."]
        return []


@element
@dataclass(frozen=True, eq=False)
class AppliedTorque:
    """A torque about the axis normal to the plane, counter-clockwise positive."""

    kind: ClassVar[str] = "torque"
    name: str
    body: Body
    value: sympy.Expr

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The body that the torque acts on."""
        return (self.body,)

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """An applied torque is not asked whether it has a potential."""
        return None

    def forces(self, bodies: tuple[Body, ...]) -> dict[Coordinate, sympy.Expr]:
        """Q_φ, or what does the same work."""
        return self.body.torque(self.value)

    def problems(self) -> list[str]:
        """The ground cannot be turned, and a particle has nothing to turn."""
        if self.body.fixed:
            return [f"torque '{self.name}' acts on the ground; give a moving body."]
        if not self.body.turns:
            name = self.body.name
            return [f"torque '{self.name}' turns '{name}', which is a particle; use a body."]
        return []
