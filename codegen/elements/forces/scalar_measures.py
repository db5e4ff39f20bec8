"""Scalars s(q, t) along which forces act, such as lengths, angles and gaps, and their checks."""

from typing import ClassVar

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Effect, Element, Measure, Pulls, label
from codegen.declare.element_conditions import Condition, number_problems, sign_conditions
from codegen.declare.symbols import SPEED, Coordinate, Time, Velocity, kinds, rate


def span(i: Point, j: Point) -> tuple[sympy.Expr, sympy.Expr]:
    """d = r_j^P - r_i^P in the global frame, m."""
    return j.x - i.x, j.y - i.y


def distance(i: Point, j: Point) -> sympy.Expr:
    """ℓ = √(dᵀd), m (Haug 6.1)."""
    dx, dy = span(i, j)
    return sympy.sqrt(dx**2 + dy**2)


def distance_rate(i: Point, j: Point) -> sympy.Expr:
    """dℓ/dt = dᵀ ḋ / ℓ, m/s: shorter than `rate` of ℓ, which is a sum of quotients."""
    dx, dy = span(i, j)
    return (dx * (j.vx - i.vx) + dy * (j.vy - i.vy)) / distance(i, j)


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


def same_body(where: str, bodies: tuple[Body, ...]) -> list[str]:
    """Two ends on one body."""
    if len(bodies) == 2 and bodies[0] is bodies[1]:
        return [f"{where} is between body '{bodies[0].name}' and itself; give two."]
    return []


def angle_problems(element: Element, *bodies: Body) -> list[str]:
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


def along_scalar(
    s: sympy.Expr, unit: str, force: sympy.Expr, *, named: str | None = None
) -> tuple[Measure, ...]:
    """A scalar, its rate and the force along it, which may contain `SPEED`, as outputs."""
    word, exerted, force_unit = WORDS[unit]
    return (
        Measure(named or word, "", unit, s),
        Measure("rate", "", f"{unit or 1}/s", SPEED, s),
        Measure(exerted, "", force_unit, force, s),
    )


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


def line_problems(element: Element, i: Point, j: Point) -> list[str]:
    """Two points of one body, which keep their distance."""
    if i.body is not j.body:
        return []
    reason = "coincide" if distance(i, j) == 0 else "keep their distance"
    where = f"{label(element)}: both ends, ({i.sx}, {i.sy}) and ({j.sx}, {j.sy}), are on body"
    return [f"{where} '{i.body.name}' and {reason}; connect two bodies."]


class SpringDamper(Effect):
    """f = F0 + k (s - s0) + c ṡ + F along a scalar s; V exists where k, s0 and F0 are constant."""

    unit: ClassVar[str] = "m"
    """Of s."""
    stiffness: sympy.Expr
    damping: sympy.Expr
    actuator: sympy.Expr
    preload: sympy.Expr

    @property
    def scalar(self) -> tuple[sympy.Expr, sympy.Expr]:
        """s and s0."""
        raise NotImplementedError

    @property
    def present(self) -> tuple[bool, bool, bool]:
        """Whether it has an elastic part, a damper and an actuator."""
        elastic = self.stiffness != 0 or self.preload != 0
        return elastic, self.damping != 0, self.actuator != 0

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """V = k (s - s0)² / 2 + F0 (s - s0) of the elastic part."""
        s, free = self.scalar
        if not self._conservative or (self.stiffness == 0 and self.preload == 0):
            return None
        return self.stiffness * (s - free) ** 2 / 2 + self.preload * (s - free)

    def pulls(self, bodies: tuple[Body, ...]) -> Pulls:
        """The force of the damper and the actuator, and of a spring that varies."""
        s, free = self.scalar
        force = self.damping * SPEED + self.actuator
        if not self._conservative:
            force += self.stiffness * (s - free) + self.preload
        return () if force == 0 else ((s, force),)

    def measures(self, bodies: tuple[Body, ...]) -> tuple[Measure, ...]:
        """s, its rate, s - s0, and f."""
        s, free = self.scalar
        force = self.stiffness * (s - free) + self.preload + self.damping * SPEED + self.actuator
        found = along_scalar(s, self.unit, force)
        return (*found, Measure("deflection", "", self.unit, s - free))

    @property
    def _conservative(self) -> bool:
        return is_constant(self.stiffness, self.scalar[1], self.preload)

    def characteristic_problems(self, keyword: str) -> list[str]:
        """A law that exerts nothing, and numbers that no spring has."""
        acting = (self.stiffness, self.damping, self.actuator, self.preload)
        idle = all(value == 0 for value in acting)
        advice = f"give it a stiffness, a damping, a preload, an actuator or a {keyword}."
        problems = [f"{label(self)} does nothing; {advice}"] if idle else []
        return problems + number_problems(self)


def characteristic(keyword: str, *values: tuple[str, sympy.Expr, str]) -> tuple[Condition, ...]:
    """Springs, dampers and lengths that are not negative."""
    other = f", and write other characteristics with {keyword}="
    return sign_conditions(*values, advice=other)
