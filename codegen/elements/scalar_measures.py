"""Scalars s(q, t) along which forces act, such as lengths, angles and gaps, and their checks."""

from typing import Any, NamedTuple

import sympy

from codegen.declare.body import Bodies, Body, Point
from codegen.declare.element import Constraint, Element, Measure, Measures, label
from codegen.declare.symbols import SPEED, Coordinate, Time, Velocity, kinds, rate


def span(i: Point, j: Point) -> tuple[sympy.Expr, ...]:
    """d = r_j^P - r_i^P in the global frame, m."""
    return tuple(b - a for a, b in zip(i.position, j.position, strict=True))


def distance(i: Point, j: Point) -> sympy.Expr:
    """ℓ = √(dᵀd), m (Haug 6.1)."""
    return sympy.sqrt(sympy.Add(*(d**2 for d in span(i, j))))


def distance_rate(i: Point, j: Point) -> sympy.Expr:
    """dℓ/dt = dᵀ ḋ / ℓ, m/s: shorter than `rate` of ℓ, which is a sum of quotients."""
    pairs = zip(span(i, j), i.velocity, j.velocity, strict=True)
    return sympy.Add(*(d * (after - before) for d, before, after in pairs)) / distance(i, j)


def distance_and_rate(between: Any) -> tuple[sympy.Expr, sympy.Expr]:
    """ℓ and ℓ̇ of the points of an element; the rate written out, as a law may switch with it."""
    return distance(between.i, between.j), distance_rate(between.i, between.j)


def angle_and_rate(between: Any) -> tuple[sympy.Expr, sympy.Expr]:
    """θ and θ̇ of the bodies of an element."""
    theta = relative_angle(between.i, between.j)
    return theta, rate(theta)


def relative_angle(i: Body, j: Body) -> sympy.Expr:
    """θ = φ_j - φ_i, rad, counted through full turns; `angle_problems` refuses other bodies."""
    phi_i, phi_j = (sympy.S.Zero if b.angle is None else b.angle for b in (i, j))
    return phi_j - phi_i


def rim_travel(i: tuple[Body, sympy.Expr], j: tuple[Body, sympy.Expr], carrier: Body) -> sympy.Expr:
    """R_i (φ_i - φ_c) + R_j (φ_j - φ_c), m, of two wheels with radii of either sign."""
    return sympy.Add(*(radius * relative_angle(carrier, wheel) for wheel, radius in (i, j)))


def is_constant(*expressions: sympy.Expr) -> bool:
    """Whether the expressions are numbers or parameters, the same throughout a run."""
    return not any(kinds(e, Coordinate, Velocity, Time) for e in expressions)


def same_body(where: str, bodies: Bodies) -> list[str]:
    """Two ends on one body."""
    if len(bodies) == 2 and bodies[0] is bodies[1]:
        return [f"{where} is between body '{bodies[0].name}' and itself; give two."]
    return []


def angle_problems(element: object, *bodies: Body) -> list[str]:
    """Particles among the bodies, which nothing can turn, and bodies that count no angle."""
    return [
        f"{label(element)} needs the angle of '{body.name}', which has none: it is oriented by "
        f"{', '.join(q.letter for q in body.coordinates)}. Use an element that asks for points."
        if body.turns
        else f"{label(element)} turns '{body.name}', which is a particle and has no angle; use a "
        "body."
        for body in bodies
        if body.angle is None or not body.turns
    ]


def is_angle(scalar: sympy.Expr) -> bool:
    """Whether a scalar is a sum and difference of angles, as that of a torsion spring is."""
    moved = kinds(scalar, Coordinate)
    return (
        bool(moved)
        and not kinds(scalar, Velocity, Time)
        and all(q.unit == "rad" and abs(sympy.diff(scalar, q)) == 1 for q in moved)
    )


def is_length(scalar: sympy.Expr) -> bool:
    """Whether a scalar is known to be in m: a sum of lengths, or the root of a sum of squares.

    A length x enters a sum with ∂s/∂x = ±1, and a sum of squares s² with ∂²s²/∂x² = 2.
    """
    moved = kinds(scalar, Coordinate)
    if kinds(scalar, Velocity) or not any(q.unit == "m" for q in moved):
        return False
    rest = scalar.as_independent(*moved, as_Add=True)[1]
    root = rest.is_Pow and rest.exp == sympy.S.Half
    return all(
        (sympy.diff(rest.base, q, 2) == 2) if root else (abs(sympy.diff(rest, q)) == 1)
        for q in moved
        if q.unit == "m"
    )


def unit_of(scalar: sympy.Expr) -> str:
    """Its unit, "rad" or "m", where that follows from the coordinates; else empty."""
    return "rad" if is_angle(scalar) else "m" if is_length(scalar) else ""


WORDS = {
    "m": ("length", "force", "N"),
    "rad": ("angle", "torque", "N m"),
    "": ("length", "force", ""),
}
"""Unit of a scalar → what it is called, and the force along it with its unit."""


def force_unit(element: Any) -> str:
    """Unit of the force along the scalar of an element that has the `unit`."""
    return "N m" if element.unit == "rad" else "N"


def along_scalar(
    s: sympy.Expr, unit: str, force: sympy.Expr, *, named: str | None = None
) -> Measures:
    """A scalar, its rate and the force along it, which may contain `SPEED`, as outputs."""
    word, exerted, force_unit = WORDS[unit]
    return (
        Measure(named or word, "", unit, s),
        Measure("rate", "", f"{unit or 1}/s", SPEED, s),
        Measure(exerted, "", force_unit, force, s),
    )


class Rubbing(NamedTuple):
    """How the second body of a joint slips against the first, and what presses them together."""

    slip: sympy.Expr  # s(q), rad or m; or ṡ itself, linear in velocities, where there is no s(q)
    pressing: tuple[str, ...]  # the components of the joint's reaction whose size is N
    bodies: Bodies  # the first and the second
    place: tuple[sympy.Expr, sympy.Expr]  # in the global frame, m
    way: tuple[sympy.Expr, sympy.Expr]  # the direction of the slip there, of any length


class RubbingJoint(Constraint):
    """A joint in which friction acts under its own reaction."""

    friction_arm = ""  # the argument that is the arm of a friction's torque, m; "": it is a force

    def rubbing(self) -> Rubbing:
        """The slip, and the reaction that presses."""
        raise NotImplementedError


def turned(body: Body, ux: sympy.Expr, uy: sympy.Expr) -> tuple[sympy.Expr, sympy.Expr]:
    """A vector of the body's frame, in the global one."""
    c, s = body.rotation
    return c * ux - s * uy, s * ux + c * uy


def sliding(
    bodies: Bodies, place: tuple[sympy.Expr, sympy.Expr], way: tuple[sympy.Expr, sympy.Expr]
) -> Rubbing:
    """Two bodies slide on each other at a place, along a unit vector; fy of the reaction presses.

    The slip is the velocity of the second body against the first there, both taken as rigid.
    """
    slip: sympy.Expr = sympy.S.Zero
    for body, sign in zip(bodies, (-1, 1), strict=True):
        (x, y), (vx, vy), omega = body.position, body.velocity, body.angular_velocity
        u, v = vx - omega * (place[1] - y), vy + omega * (place[0] - x)
        slip += sign * (way[0] * u + way[1] * v)
    return Rubbing(slip, ("fy",), bodies, place, way)


class SpanMeasures:
    """The length between two points and its rate, as expressions for other elements and outputs."""

    i: Point
    j: Point

    @property
    def length(self) -> sympy.Expr:
        """ℓ, m."""
        return distance(self.i, self.j)

    @property
    def rate(self) -> sympy.Expr:
        """ℓ̇, m/s."""
        return distance_rate(self.i, self.j)


class TurnMeasures:
    """The angle between two bodies and its rate, as expressions for other elements and outputs."""

    i: Body
    j: Body

    @property
    def angle(self) -> sympy.Expr:
        """θ = φ_j - φ_i, rad."""
        return relative_angle(self.i, self.j)

    @property
    def rate(self) -> sympy.Expr:
        """θ̇, rad/s."""
        return rate(self.angle)

    def problems(self) -> list[str]:
        """Bodies without an angle, and a body against itself."""
        bodies = self.i, self.j
        return angle_problems(self, *bodies) + same_body(label(self), bodies)


def line_problems(element: Element, i: Point, j: Point) -> list[str]:
    """Two points of one body, which keep their distance."""
    if i.body is not j.body:
        return []
    reason = "coincide" if distance(i, j) == 0 else "keep their distance"
    where = f"{label(element)}: both ends, ({i.sx}, {i.sy}) and ({j.sx}, {j.sy}), are on body"
    return [f"{where} '{i.body.name}' and {reason}; connect two bodies."]
