"""Bodies in space, and the points and axes on them.

A body has the coordinates r = (x, y, z) of its centre of mass and the Euler parameters p = (e0, e1,
e2, e3), with one equation pᵀp = 1 between them. Its frame x'-y'-z' has its origin at the centre of
mass; points, axes and the inertia J' are given in it. ω' is the angular velocity in body axes.
"""

from dataclasses import dataclass, field
from typing import Any

import sympy

from codegen.declare.body import Body, Loads, Point, expressions_in
from codegen.declare.rotation_entries import G, rotation_matrix, spin
from codegen.declare.symbols import Coordinate, QuasiCoordinate, Velocity, own_coordinate, rate
from codegen.drawing.meshes import Mesh
from codegen.errors import ModelError
from codegen.readers.calls import declaring_class, named_attributes
from codegen.readers.values import shown

Three = tuple[Any, Any, Any]


def component(vector: str, k: int, text: str) -> Any:
    """A property: one component of a vector of its object; `text` describes it."""
    return property(lambda owner: getattr(owner, vector)[k], doc=text)


ORIGIN = (0.0, 0.0, 0.0)  # formula: the place of a body at the drawing, by default
UPRIGHT = (1.0, 0.0, 0.0, 0.0)  # formula: its Euler parameters, by default


@named_attributes
@declaring_class("body")
@dataclass(frozen=True, eq=False, repr=False)
class SpaceBody(Body):
    """A rigid body in space; its frame x'-y'-z' has its origin at the centre of mass.

    Attributes
    ----------
    name, mass, model
        As of a planar body.
    inertia
        J' about the centre of mass in body axes, 3 × 3, kg m²; None if only kinematic scenes use
        the body.
    place, attitude
        The pose at the drawing: position of the centre of mass, m, and Euler parameters.
    forms
        What draws the body; empty: joints and inertia determine it.
    """

    forms: tuple[Mesh, ...] = field(default=(), kw_only=True)
    place: tuple[float, ...] = field(default=ORIGIN, kw_only=True)
    attitude: tuple[float, ...] = field(default=UPRIGHT, kw_only=True)

    z = own_coordinate("z", "Position of the centre of mass along the global z axis, m.")
    e0 = own_coordinate("e0", "Euler parameter cos(χ/2) of a rotation by χ.")
    e1 = own_coordinate("e1", "Euler parameter u_x sin(χ/2), u the axis of rotation.")
    e2 = own_coordinate("e2", "Euler parameter u_y sin(χ/2).")
    e3 = own_coordinate("e3", "Euler parameter u_z sin(χ/2).")

    @property
    def vz(self) -> Velocity:
        """Velocity of the centre of mass along the global z axis, m/s."""
        return self.z.rate

    @property
    def p(self) -> tuple[Any, ...]:
        """The Euler parameters e0, e1, e2, e3."""
        return (self.e0, self.e1, self.e2, self.e3)

    @property
    def omega(self) -> sympy.ImmutableMatrix:
        """The angular velocity ω' in body axes, rad/s, 3 × 1."""
        return sympy.ImmutableMatrix(spin(self.p, tuple(e.rate for e in self.p)))

    omega_x = component("omega", 0, "ω' about the body's x' axis, rad/s.")
    omega_y = component("omega", 1, "ω' about the body's y' axis, rad/s.")
    omega_z = component("omega", 2, "ω' about the body's z' axis, rad/s.")

    @property
    def A(self) -> sympy.ImmutableMatrix:
        """Rotation matrix from the body's frame to the global one, 3 × 3."""
        return rotation_matrix(self.p)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The generalized coordinates x, y, z, e0, e1, e2, e3."""
        return (self.x, self.y, self.z, *self.p)

    @property
    def turning(self) -> tuple[QuasiCoordinate, ...]:
        """The directions in which it turns about its own axes."""
        return tuple(QuasiCoordinate(f"{self.name}_turn{c}", real=True) for c in "xyz")

    @property
    def mass_matrix(self) -> dict[tuple[Coordinate, Coordinate], sympy.Expr | None]:
        """m for each of x, y, z; for p, 4 Gᵀ J' G + 4 tr(J') p pᵀ.

        The last term makes the block definite; `codegen.derive.inertia` says why it may be there.
        """
        block: dict[tuple[Coordinate, Coordinate], sympy.Expr | None] = {
            (q, q): self.mass for q in self.coordinates[:3]
        }
        if self.inertia is None:
            return block | {(e, e): None for e in self.p}
        p = sympy.Matrix(self.p)
        g = matrix_g(self.p)
        whole = 4 * (g.T * self.inertia * g + self.inertia.trace() * p * p.T)
        rows = ((i, k) for i in range(4) for k in range(i, 4))
        return block | {(self.p[i], self.p[k]): whole[i, k] for i, k in rows}

    @property
    def inertia_force(self) -> Loads:
        """Q_v = -4 Ġᵀ J' ω' for p, with the share -4 tr(J') (ṗᵀṗ) p of the added mass."""
        if self.inertia is None:
            return {}
        p = sympy.Matrix(self.p)
        rates = sympy.Matrix([e.rate for e in self.p])
        force = -4 * matrix_g(tuple(rates)).T * self.inertia * sympy.Matrix(self.omega)
        force -= 4 * self.inertia.trace() * rates.dot(rates) * p
        return dict(zip(self.p, force, strict=True))

    @property
    def equations(self) -> tuple[tuple[str, sympy.Expr], ...]:
        """pᵀp = 1."""
        return (("norm", sympy.Add(*(e**2 for e in self.p), -1)),)

    @property
    def position(self) -> Three:  # type: ignore[override]
        """Global position r of the centre of mass."""
        return (self.x, self.y, self.z)

    @property
    def velocity(self) -> Three:  # type: ignore[override]
        """Velocity ṙ of the centre of mass."""
        return (self.vx, self.vy, self.vz)

    @property
    def angle(self) -> None:
        """None: the orientation is no single angle."""
        return

    def torque(self, value: Any) -> Loads:
        """Generalized forces of a torque n' in body axes, N m, three numbers."""
        exerted = expressions_in("N m", f"torque of body '{self.name}'", *value)
        if len(exerted) != 3:
            raise ModelError(f"torque of body '{self.name}': {shown(value)} is not 3 values.")
        return {q: n for q, n in zip(self.turning, exerted, strict=True) if n != 0}

    def at(self, x: Any, y: Any, z: Any) -> "SpacePoint":  # type: ignore[override]
        """The point (x', y', z') of this body, m."""
        return SpacePoint(self, x, y, z)

    def along(self, x: Any, y: Any, z: Any) -> "Axis":
        """The direction (x', y', z') of this body, of any length but 0."""
        return Axis(self, (x, y, z))


class SpaceGround(SpaceBody):
    """The body that does not move; its frame is the global one."""

    fixed = True
    x = y = z = vx = vy = vz = sympy.S.Zero
    e0, e1, e2, e3 = sympy.S.One, sympy.S.Zero, sympy.S.Zero, sympy.S.Zero
    omega = sympy.ImmutableMatrix.zeros(3, 1)
    coordinates = turning = ()


@named_attributes
@declaring_class("Point")
@dataclass(frozen=True, eq=False, repr=False)
class SpacePoint(Point):
    """A point of a body in space, at (sx, sy, sz) of the body's frame, in metres.

    If these depend on t or on coordinates, the point moves in the body, and its velocity includes
    this motion.
    """

    body: SpaceBody
    sz: Any

    @property
    def position(self) -> tuple[sympy.Expr, ...]:
        """Global position r + A s', m."""
        arm = self.body.A * sympy.Matrix(self.place)
        return tuple(r + s for r, s in zip(self.body.position, arm, strict=True))

    x = component("position", 0, "Global x, m.")
    y = component("position", 1, "Global y, m.")
    z = component("position", 2, "Global z, m.")
    vx = component("velocity", 0, "Global velocity along x, m/s.")
    vy = component("velocity", 1, "Global velocity along y, m/s.")
    vz = component("velocity", 2, "Global velocity along z, m/s.")

    @property
    def velocity(self) -> tuple[sympy.Expr, ...]:
        """Global velocity ṙ + A (ω' × s' + ṡ'), m/s."""
        s = sympy.Matrix(self.place)
        turning = sympy.Matrix(self.body.omega).cross(s) + s.applyfunc(rate)
        return tuple(sympy.Matrix(self.body.velocity) + self.body.A * turning)

    @property
    def place(self) -> Three:  # type: ignore[override]
        """(sx, sy, sz) as expressions, m; ModelError if they are not expressions."""
        if not isinstance(self.body, SpaceBody):
            raise ModelError(f"{shown(self.body)} is no body in space; write body.at(x, y, z).")
        where = f"point of body '{self.body.name}'"
        x, y, z = expressions_in("m", where, self.sx, self.sy, self.sz)
        return x, y, z


@declaring_class("Axis")
@dataclass(frozen=True, eq=False)
class Axis:
    """A direction of a body, in its frame; as `Body.along` returns it."""

    body: SpaceBody
    direction: Three


def matrix_g(p: tuple[Any, ...]) -> sympy.Matrix:
    """G of four Euler parameters, or Ġ of their rates, 3 × 4."""
    return sympy.Matrix([[sign * p[k] for sign, k in row] for row in G])
