"""A body of a test's own: turned by two numbers, its frame off the centre of mass.

φ = 2 atan2(e1, e0) with e0² + e1² = 1, so cos φ = e0² - e1² and sin φ = 2 e0 e1. Its mass block is
full, depends on the pose and is singular along (e0, e1), which the equation between them prevents.
"""

from dataclasses import dataclass
from typing import Any

import sympy

from codegen import Model
from codegen.declare.body import Body
from codegen.declare.symbols import Coordinate, CoordinateKind, coordinate, declare_letter

declare_letter("e0", CoordinateKind("e0dot", "1", 1.0))
declare_letter("e1", CoordinateKind("e1dot", "1"))


@dataclass(frozen=True, eq=False)
class TurnedBody(Body):
    """A rigid body whose frame has its origin away from the centre of mass, at (cx, cy) of it."""

    cx: Any = 0.0
    cy: Any = 0.0

    @property
    def e0(self) -> Coordinate:
        """cos(φ/2)."""
        return coordinate(self.name, "e0")

    @property
    def e1(self) -> Coordinate:
        """sin(φ/2)."""
        return coordinate(self.name, "e1")

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """x, y of the origin, e0, e1."""
        return (self.x, self.y, self.e0, self.e1)

    @property
    def equations(self) -> tuple[tuple[str, sympy.Expr], ...]:
        """e0² + e1² = 1."""
        return (("norm", self.e0**2 + self.e1**2 - 1),)

    @property
    def angle(self) -> None:
        """None is counted."""
        return

    @property
    def rotation(self) -> tuple[sympy.Expr, sympy.Expr]:
        """(cos φ, sin φ)."""
        return self.e0**2 - self.e1**2, 2 * self.e0 * self.e1

    @property
    def angular_velocity(self) -> sympy.Expr:
        """ω = 2 (e0 ė1 - e1 ė0)."""
        return 2 * (self.e0 * self.e1.rate - self.e1 * self.e0.rate)

    @property
    def mass_centre(self) -> tuple[sympy.Expr, sympy.Expr]:
        """r + A c."""
        (x, y), (c, s) = self.position, self.rotation
        return x + self.cx * c - self.cy * s, y + self.cx * s + self.cy * c

    @property
    def mass_matrix(self) -> dict[tuple[Coordinate, Coordinate], sympy.Expr | None]:
        """Of T = m |ṙ_c|²/2 + J ω²/2, ω and ṙ_c linear in the velocities."""
        if self.mass is None or self.inertia is None:
            return {}
        rows = [[sympy.diff(a, q) for q in self.coordinates] for a in self.mass_centre]
        spin = [sympy.diff(self.angular_velocity, q.rate) for q in self.coordinates]
        found = {}
        for i, a in enumerate(self.coordinates):
            for k, b in enumerate(self.coordinates[i:], i):
                entry = sympy.Add(*(self.mass * row[i] * row[k] for row in rows))
                entry = sympy.expand(entry + self.inertia * spin[i] * spin[k])
                if entry != 0:
                    found[a, b] = entry
        return found


def turned_body(
    model: Model, name: str, mass: Any, inertia: Any, centre: tuple[Any, Any]
) -> TurnedBody:
    """Declare such a body, `centre` its centre of mass in its frame."""
    cx, cy = (sympy.sympify(c) for c in centre)
    body = TurnedBody(name, sympy.sympify(mass), sympy.sympify(inertia), model.token, cx, cy)
    return model.add(body)
