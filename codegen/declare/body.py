"""Bodies, and the points and curves on them that joints and forces take hold of."""

from dataclasses import dataclass
from typing import Any

import sympy

from codegen.declare.symbols import Coordinate, Velocity, alpha, coordinate
from codegen.declare.units import is_quantity, plain_length


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid planar body; its frame x'-y' has its origin at the centre of mass.

    Attributes
    ----------
    name
        The modeller's name, an identifier.
    mass, inertia
        In kg and kg m² (about the centre of mass); None where a kinematic scene needs none.
    model
        Token of the model that the body belongs to.
    """

    name: str
    mass: sympy.Expr | None
    inertia: sympy.Expr | None
    model: object

    @property
    def fixed(self) -> bool:
        """Whether the body is the ground."""
        return False

    @property
    def x(self) -> Coordinate:
        """Horizontal position of the centre of mass, m."""
        return coordinate(self.name, "x")

    @property
    def y(self) -> Coordinate:
        """Vertical position of the centre of mass, m."""
        return coordinate(self.name, "y")

    @property
    def phi(self) -> Coordinate:
        """Orientation φ, counter-clockwise from the global x axis, rad."""
        return coordinate(self.name, "phi")

    @property
    def vx(self) -> Velocity:
        """Horizontal velocity of the centre of mass, m/s."""
        return self.x.rate

    @property
    def vy(self) -> Velocity:
        """Vertical velocity of the centre of mass, m/s."""
        return self.y.rate

    @property
    def omega(self) -> Velocity:
        """Angular velocity φ̇, rad/s."""
        return self.phi.rate

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The body's generalized coordinates x, y, φ."""
        return (self.x, self.y, self.phi)

    @property
    def masses(self) -> tuple[sympy.Expr | None, ...]:
        """The diagonal of M, one entry a coordinate."""
        return (self.mass, self.mass, self.inertia)

    @property
    def turns(self) -> bool:
        """Whether the body has an orientation."""
        return True

    @property
    def pose(self) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr]:
        """Position and orientation as expressions; zeros for the ground."""
        return (self.x, self.y, self.phi)

    @property
    def twist(self) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr]:
        """Velocities as expressions; zeros for the ground."""
        return (self.vx, self.vy, self.omega)

    def at(self, x: Any, y: Any) -> "Point":
        """The point (x', y') of this body's frame, m."""
        return Point(self, *(plain_length(value) for value in (x, y)))

    def curve(self, x: Any, y: Any) -> "Curve":
        """The curve x'(α), y'(α) of this body's frame, m, written in the symbol `alpha`."""
        return Curve(self, *(plain_length(value) for value in (x, y)))

    def circle(self, radius: Any, center: tuple[Any, Any] = (0, 0)) -> "Curve":
        """A circle in this body, m, run through counter-clockwise."""
        r, (x, y) = plain_length(radius), map(plain_length, center)
        try:
            return Curve(self, x + r * sympy.cos(alpha), y + r * sympy.sin(alpha))
        except Exception:  # no length, and reported with its joint
            return Curve(self, *((r, y) if is_quantity(r) or r is None else (x, y)))

    def polar(self, radius: Any) -> "Curve":
        """The curve at the distance r(α), m, from the body's centre in the direction α."""
        return self.circle(radius)


@dataclass(frozen=True, eq=False)
class Particle(Body):
    """A point mass: a body without extent, inertia and orientation."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The generalized coordinates x, y."""
        return (self.x, self.y)

    @property
    def masses(self) -> tuple[sympy.Expr | None, ...]:
        """The diagonal of M, one entry a coordinate."""
        return (self.mass, self.mass)

    @property
    def turns(self) -> bool:
        """A point has no orientation."""
        return False

    @property
    def pose(self) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr]:
        """Position, and zero for the orientation."""
        return (self.x, self.y, sympy.S.Zero)

    @property
    def twist(self) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr]:
        """Velocity, and zero for the angular velocity."""
        return (self.vx, self.vy, sympy.S.Zero)


@dataclass(frozen=True, eq=False)
class Ground(Body):
    """The body that does not move; its frame is the global one."""

    @property
    def fixed(self) -> bool:
        """Whether the body is the ground."""
        return True

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The ground brings no coordinates."""
        return ()

    @property
    def pose(self) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr]:
        """Zeros: the global frame."""
        return (sympy.S.Zero,) * 3

    @property
    def twist(self) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr]:
        """Zeros: the ground does not move."""
        return (sympy.S.Zero,) * 3


@dataclass(frozen=True, eq=False)
class Point:
    """A point fixed in a body, at (sx, sy) of the body's frame, in metres."""

    body: Body
    sx: Any
    sy: Any

    @property
    def x(self) -> sympy.Expr:
        """Horizontal position in the global frame: r_x + (A s')_x."""
        x, _, phi = self.body.pose
        return x + self.sx * sympy.cos(phi) - self.sy * sympy.sin(phi)

    @property
    def y(self) -> sympy.Expr:
        """Vertical position in the global frame: r_y + (A s')_y."""
        _, y, phi = self.body.pose
        return y + self.sx * sympy.sin(phi) + self.sy * sympy.cos(phi)

    @property
    def vx(self) -> sympy.Expr:
        """Horizontal velocity in the global frame."""
        vx, _, omega = self.body.twist
        return vx - omega * (self.y - self.body.pose[1])

    @property
    def vy(self) -> sympy.Expr:
        """Vertical velocity in the global frame."""
        _, vy, omega = self.body.twist
        return vy + omega * (self.x - self.body.pose[0])


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve fixed in a body: x'(α), y'(α) in the body's frame, m; closed ones have period 2π.

    `pace` is a typical |c'|, m per rad, by which equations are divided that hold tangents.
    """

    body: Body
    x: Any
    y: Any
    pace: float = 1.0

    def at(self, parameter: sympy.Expr) -> sympy.Matrix:
        """The point of the curve at a parameter, in the body's frame, 2 × 1."""
        return sympy.Matrix([sympy.sympify(c).subs(alpha, parameter) for c in (self.x, self.y)])
