"""The line between two points: its length, the rate of it, and what a tension along it does."""

from dataclasses import dataclass

import sympy

from codegen.declare.body import Point


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
