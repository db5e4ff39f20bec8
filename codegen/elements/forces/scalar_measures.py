"""Scalars s(q, t) along which forces act, such as lengths, angles and gaps, and their checks."""

from typing import ClassVar

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Effect, Element, Measure, Pulls, label
from codegen.declare.element_conditions import Condition, number_problems, sign_conditions
from codegen.declare.symbols import SPEED, Coordinate, Time, Velocity, kinds


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


WORDS = {"m": ("length", "force", "N"), "rad": ("angle", "torque", "N m")}
"""Unit of a scalar → what it is called, and the force along it with its unit."""


def along_scalar(
    s: sympy.Expr, unit: str, force: sympy.Expr, *, named: str | None = None
) -> tuple[Measure, ...]:
    """A scalar, its rate and the force along it, which may contain `SPEED`, as outputs."""
    word, exerted, force_unit = WORDS[unit]
    return (
        Measure(named or word, "", unit, s),
        Measure("rate", "", f"{unit}/s", SPEED, s),
        Measure(exerted, "", force_unit, force, s),
    )


class SpringDamper(Effect):
    """f = k (s - s0) + c ṡ + F along a scalar s; V exists where k and s0 are constant."""

    unit: ClassVar[str] = "m"
    """Of s."""
    stiffness: sympy.Expr
    damping: sympy.Expr
    actuator: sympy.Expr

    @property
    def scalar(self) -> tuple[sympy.Expr, sympy.Expr]:
        """s and s0."""
        raise NotImplementedError

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """V = k (s - s0)² / 2 of the elastic part."""
        s, free = self.scalar
        if self.stiffness == 0 or not is_constant(self.stiffness, free):
            return None
        return self.stiffness * (s - free) ** 2 / 2

    def pulls(self, bodies: tuple[Body, ...]) -> Pulls:
        """The force of the damper and the actuator, and of a spring that varies."""
        s, free = self.scalar
        force = self.damping * SPEED + self.actuator
        if not is_constant(self.stiffness, free):
            force += self.stiffness * (s - free)
        return () if force == 0 else ((s, force),)

    def measures(self, bodies: tuple[Body, ...]) -> tuple[Measure, ...]:
        """s, its rate, s - s0, and f."""
        s, free = self.scalar
        force = self.stiffness * (s - free) + self.damping * SPEED + self.actuator
        found = along_scalar(s, self.unit, force)
        return (*found, Measure("deflection", "", self.unit, s - free))

    def characteristic_problems(self, keyword: str) -> list[str]:
        """A law that exerts nothing, and numbers that no spring has."""
        idle = self.stiffness == 0 and self.damping == 0 and self.actuator == 0
        advice = f"give it a stiffness, a damping, an actuator or a {keyword}."
        problems = [f"{label(self)} does nothing; {advice}"] if idle else []
        return problems + number_problems(self)


def characteristic(keyword: str, *values: tuple[str, sympy.Expr, str]) -> tuple[Condition, ...]:
    """Springs, dampers and lengths that are not negative."""
    other = f", and write other characteristics with {keyword}="
    return sign_conditions(*values, advice=other)
