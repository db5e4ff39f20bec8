"""The line between two points: its length, the rate of it, and what a tension along it does."""

from dataclasses import dataclass

import sympy

from codegen.declare.body import Point
from codegen.declare.symbols import Coordinate


@dataclass(frozen=True)
class Line:
    """d = r_j^P - r_i^P in the global frame, and its length ℓ = √(dᵀd) (Haug 6.1)."""

    i: Point
    j: Point

    @property
    def d(self) -> tuple[sympy.Expr, sympy.Expr]:
        """The vector from point i to point j, m."""
        return self.j.x - self.i.x, self.j.y - self.i.y

    @property
    def length(self) -> sympy.Expr:
        """ℓ, m."""
        dx, dy = self.d
        return sympy.sqrt(dx**2 + dy**2)

    @property
    def rate(self) -> sympy.Expr:
        """dℓ/dt = dᵀ ḋ / ℓ, m/s."""
        dx, dy = self.d
        i, j = self.i, self.j
        return (dx * (j.vx - i.vx) + dy * (j.vy - i.vy)) / self.length

    def pulled(self, f: sympy.Expr) -> dict[Coordinate, sympy.Expr]:
        """Generalized forces of a tension f, which pulls the points together.

        Q_i = (f/ℓ) [d, (B_i s_i')ᵀ d] and Q_j the opposite with B_j s_j' (Haug 6.1).
        """
        dx, dy = self.d
        pull = f / self.length
        found: dict[Coordinate, sympy.Expr] = {}
        for point, way in ((self.i, pull), (self.j, -pull)):
            if point.body.fixed:
                continue
            body, (x, y, _) = point.body, point.body.pose
            found |= {body.x: way * dx, body.y: way * dy}
            arm = (point.x - x) * dy - (point.y - y) * dx
            if arm != 0:
                found[body.phi] = way * arm
        return found
