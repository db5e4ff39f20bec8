"""Bodies, and the points, curves and outlines on them.

The methods of a body return its coordinates, the place of a point and of an axis (r + A s'), its
mass block and inertia force, and equations between its coordinates. A body whose orientation is not
an angle defines `position`, `rotation`, `angular_velocity`, `mass_matrix` and `equations`, and
`angle` as None; `Model.add` declares it.
"""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import sympy

from codegen.declare.symbols import Coordinate, Velocity, alpha, own_coordinate, rate
from codegen.errors import ModelError
from codegen.readers.calls import declaring_class, named_attributes
from codegen.readers.expressions import plain_expression
from codegen.readers.quantities import in_unit, metres
from codegen.readers.values import KindError, members, shown
from codegen.tables.piecewise_function import closed

Loads = dict[Coordinate, sympy.Expr]
"""Generalized forces Q, by coordinate."""


class Pose:
    """The coordinates x, y and φ that belong to a name."""

    name: str
    x = own_coordinate("x", "Horizontal position of the origin, m.")
    y = own_coordinate("y", "Vertical position of the origin, m.")
    phi = own_coordinate("phi", "Orientation φ, counter-clockwise from the global x axis, rad.")


@named_attributes
@declaring_class("body")
@dataclass(frozen=True, eq=False)
class Body(Pose):
    """A rigid planar body; its frame x'-y' has its origin at the centre of mass.

    Points, curves and pictures of a body with an outline are given in the axes of its drawing,
    which are parallel to x' and y'; their origin need not be the centre of mass.

    Attributes
    ----------
    name
        The modeller's name, an identifier.
    mass, inertia
        In kg and kg m² (about the centre of mass); None if only kinematic scenes use the body.
    model
        Token of the model that the body belongs to.
    outlines
        Closed polygons of points (x', y'), m, that draw the body; empty: joints determine them.
    center
        The centre of mass in the axes of the drawing, m; (0, 0) without an outline.
    conditions
        What is asked of its outline's parameters.
    laws
        (m, law) of a mass or an inertia m that varies, an own coordinate of the body's `MassLaw`.
    fixed, turns
        Whether the body is the ground, and whether it has an orientation.
    """

    name: str
    mass: sympy.Expr | None
    inertia: sympy.Expr | None
    model: object
    outlines: tuple[tuple[tuple[Any, Any], ...], ...] = field(default=(), kw_only=True)
    center: tuple[Any, Any] = field(default=(0, 0), kw_only=True)
    conditions: tuple[Any, ...] = field(default=(), kw_only=True)
    laws: tuple[tuple[Coordinate, sympy.Expr], ...] = field(default=(), kw_only=True)
    fixed: ClassVar[bool] = False
    turns: ClassVar[bool] = True

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.name!r})"

    @property
    def vx(self) -> Velocity:
        """Horizontal velocity of the origin, m/s."""
        return self.x.rate

    @property
    def vy(self) -> Velocity:
        """Vertical velocity of the origin, m/s."""
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
    def mass_matrix(self) -> dict[tuple[Coordinate, Coordinate], sympy.Expr | None]:
        """Entries M_ab(q) of the body's mass block, for a pair of coordinates in one order.

        M must be positive definite on the velocities that `equations` allow; for other velocities
        it may be singular, as with Euler parameters.
        """
        pairs = zip(self.coordinates, self.masses, strict=True)
        return {(q, q): mass for q, mass in pairs}

    @property
    def inertia_force(self) -> Loads:
        """Q_v of M q̈ + Φ_qᵀ λ = Q + Q_v, quadratic in the velocities.

        By Lagrange's equations from T = q̇ᵀ M q̇ / 2: Q_v = T_q - Ṁ q̇. Zero where M is constant.
        """
        block = self.mass_matrix.items()
        entries = {pair: plain_expression(m) for pair, m in block if m is not None}
        moving = {*self.coordinates, *(q.rate for q in self.coordinates)}
        if not any(m.free_symbols & moving for m in entries.values()):
            return {}
        kinetic = sympy.Add(
            *(m * a.rate * b.rate / (2 if a == b else 1) for (a, b), m in entries.items())
        )
        forces = {}
        for q in self.coordinates:
            momentum = sympy.diff(kinetic, q.rate)
            terms = (sympy.diff(momentum, p) * p.rate for p in self.coordinates)
            forces[q] = sympy.expand(sympy.diff(kinetic, q) - sympy.Add(*terms))
        return {q: force for q, force in forces.items() if force != 0}

    @property
    def equations(self) -> tuple[tuple[str, sympy.Expr], ...]:
        """(word, Φ) of equations Φ = 0 between the body's coordinates; most bodies have none."""
        return ()

    @property
    def position(self) -> tuple[sympy.Expr, sympy.Expr]:
        """Global position r of the origin of the body's frame."""
        return (self.x, self.y)

    @property
    def velocity(self) -> tuple[sympy.Expr, sympy.Expr]:
        """Velocity ṙ of the origin of the body's frame."""
        return (self.vx, self.vy)

    @property
    def mass_centre(self) -> tuple[sympy.Expr, sympy.Expr]:
        """Global position of the centre of mass."""
        return self.position

    @property
    def angle(self) -> sympy.Expr | None:
        """Orientation φ; None if the coordinates give only cos φ and sin φ."""
        return self.phi

    @property
    def rotation(self) -> tuple[sympy.Expr, sympy.Expr]:
        """(cos φ, sin φ), the first column of A, from the body's frame to the global one."""
        angle = plain_expression(self.angle)  # SymPy's functions would evaluate text in a tuple
        return sympy.cos(angle), sympy.sin(angle)

    @property
    def angular_velocity(self) -> sympy.Expr:
        """ω = φ̇."""
        return self.omega

    def torque(self, value: sympy.Expr) -> Loads:
        """Generalized forces of a torque: value ∂ω/∂q̇."""
        (exerted,) = expressions_in("N m", f"torque of body '{self.name}'", value)
        turning = plain_expression(self.angular_velocity)
        slopes = {q: sympy.diff(turning, q.rate) for q in self.coordinates}
        return {q: exerted * slope for q, slope in slopes.items() if slope != 0}

    def at(self, x: Any, y: Any) -> "Point":
        """The point (x', y') of this body, m; with an outline, in the axes of its drawing."""
        return Point(self, *self._from_center(x, y))

    def curve(self, x: Any, y: Any) -> "Curve":
        """The curve x'(α), y'(α) of this body, m, in the symbol `alpha`; its axes as in `at`."""
        return Curve(self, *self._from_center(x, y))

    def circle(self, radius: Any, center: tuple[Any, Any] = (0, 0)) -> "Curve":
        """A circle in this body, m, run through counter-clockwise; its center as in `at`."""
        try:  # what is no length is reported with its joint
            x, y = (plain_expression(in_unit(v, "m")) for v in members(center, 2))
        except KindError:
            return Curve(self, center, center)
        try:
            r = plain_expression(in_unit(radius, "m"))
        except KindError:
            return Curve(self, radius, y)
        return self.curve(x + r * sympy.cos(alpha), y + r * sympy.sin(alpha))

    def polar(self, radius: Any) -> "Curve":
        """The curve at the distance r(α), m, from the point ``at(0, 0)`` in the direction α."""
        return self.circle(radius)

    def _from_center(self, x: Any, y: Any) -> tuple[Any, Any]:
        """(x', y') of the drawing's axes in the body's frame; what is no length as it is."""
        given = metres(x), metres(y)
        if self.center == (0, 0):
            return given
        try:
            px, py = (plain_expression(v) - c for v, c in zip(given, self.center, strict=True))
        except KindError:
            return given
        return px, py


Bodies = tuple[Body, ...]


@named_attributes
@declaring_class("Point")
@dataclass(frozen=True, eq=False)
class Point:
    """A point of a body, at (sx, sy) of the body's frame, in metres.

    If sx or sy depends on t or on coordinates, the point moves in the body, and its velocity
    includes this motion.
    """

    body: Body
    sx: Any
    sy: Any

    def __repr__(self) -> str:
        return f"a Point of {shown(self.body)}"

    @property
    def x(self) -> sympy.Expr:
        """Horizontal position in the global frame: r_x + (A s')_x."""
        (sx, sy), (c, s) = self.place, self.body.rotation
        return self.body.position[0] + sx * c - sy * s

    @property
    def y(self) -> sympy.Expr:
        """Vertical position in the global frame: r_y + (A s')_y."""
        (sx, sy), (c, s) = self.place, self.body.rotation
        return self.body.position[1] + sx * s + sy * c

    @property
    def vx(self) -> sympy.Expr:
        """Horizontal velocity in the global frame."""
        (own_x, own_y), (c, s) = self.own_velocity, self.body.rotation
        turning = self.body.angular_velocity * (self.y - self.body.position[1])
        return self.body.velocity[0] - turning + c * own_x - s * own_y

    @property
    def vy(self) -> sympy.Expr:
        """Vertical velocity in the global frame."""
        (own_x, own_y), (c, s) = self.own_velocity, self.body.rotation
        turning = self.body.angular_velocity * (self.x - self.body.position[0])
        return self.body.velocity[1] + turning + s * own_x + c * own_y

    @property
    def position(self) -> tuple[sympy.Expr, ...]:
        """Global position, m."""
        return self.x, self.y

    @property
    def velocity(self) -> tuple[sympy.Expr, ...]:
        """Global velocity, m/s."""
        return self.vx, self.vy

    @property
    def own_velocity(self) -> tuple[sympy.Expr, sympy.Expr]:
        """The velocity in the body's frame, d(sx, sy)/dt; zero for a point fixed in it."""
        x, y = map(rate, self.place)
        return x, y

    @property
    def place(self) -> tuple[sympy.Expr, sympy.Expr]:
        """(sx, sy) as expressions, m; ModelError if they are not expressions."""
        x, y = expressions_in("m", f"point of {_named(self.body)}", self.sx, self.sy)
        return closed(x), closed(y)


@named_attributes
@declaring_class("Curve")
@dataclass(frozen=True, eq=False)
class Curve:
    """A curve fixed in a body: x'(α), y'(α) in the body's frame, m; closed ones have period 2π.

    `pace` is a typical |c'|, m per rad, by which equations with tangents are divided.
    """

    body: Body
    x: Any
    y: Any
    pace: float = 1.0

    def __repr__(self) -> str:
        return f"a Curve of {shown(self.body)}"

    def at(self, parameter: sympy.Expr) -> sympy.Matrix:
        """The point of the curve at a parameter, in the body's frame, 2 × 1."""
        (at,) = expressions_in("rad", "curve.at", parameter)
        x, y = expressions_in("m", f"curve of {_named(self.body)}", self.x, self.y)
        return sympy.Matrix([x.subs(alpha, at), y.subs(alpha, at)])


def expressions_in(unit: str, where: str, *values: Any) -> list[sympy.Expr]:
    """Values in a unit as expressions; ModelError where one is none."""
    try:
        return [plain_expression(in_unit(value, unit)) for value in values]
    except KindError:
        given = ", ".join(map(shown, values))
        raise ModelError(f"{where}: {given}: give numbers or expressions in {unit}.") from None


def _named(body: object) -> str:
    """A body in messages; ModelError where it is none."""
    if not isinstance(body, Body):
        raise ModelError(f"{shown(body)} is no body; write body.at(x, y).")
    return f"body '{body.name}'"


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
