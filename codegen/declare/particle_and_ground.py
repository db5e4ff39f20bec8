"""Bodies with fewer coordinates than three: the particle without angle, the ground without any."""

import sympy

from codegen.declare.body import Body
from codegen.declare.symbols import Coordinate


class Particle(Body):
    """A point mass: a body without extent, inertia and orientation."""

    turns = False
    angle = angular_velocity = sympy.S.Zero

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The generalized coordinates x, y."""
        return (self.x, self.y)

    @property
    def masses(self) -> tuple[sympy.Expr | None, ...]:
        """The diagonal of M, one entry a coordinate."""
        return (self.mass, self.mass)


class Ground(Body):
    """The body that does not move; its frame is the global one, its x, y and φ are 0."""

    fixed = True
    x = y = phi = vx = vy = omega = sympy.S.Zero
    coordinates = masses = ()
    position = velocity = (sympy.S.Zero, sympy.S.Zero)
    angle = angular_velocity = sympy.S.Zero
